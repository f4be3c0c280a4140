"""The scripts that the manual prints for the ground side do what is said of them, on payloads that a test scripts."""

import asyncio
import io
import math
from contextlib import asynccontextmanager, redirect_stdout

import pytest

import ross_payload.ground
import ross_payload.ground.station
from ground_page import page
from hand_station import PAYLOAD, HandStation
from manual import ROOT, block, executed
from ross_payload.ground import Payload
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.dialect import ross
from scripted_station import Scripted, source, status

GUIDES = "docs/how-to"


@pytest.fixture
def connected(monkeypatch):
    """Let `connect` give a payload on the station of a test."""

    def call(station):
        @asynccontextmanager
        async def connect(*urls):
            async with Payload(station, PAYLOAD) as payload:
                yield payload

        monkeypatch.setattr(ross_payload.ground, "connect", connect)

    return call


def test_the_script_that_enrols_explores_enrols_with_consent_and_seeks_the_voice(connected):
    station = Scripted(Result.ACCEPTED)
    station.found = source(0, 20, final=True), source(1, 160, final=True)
    connected(station)
    executed(block(f"{GUIDES}/enrol-by-pointing.md", "python", "payload.enrol").text)
    sent = [(each.command, each.param1, each.param2, each.param5) for each in station.commands()]
    mode = ross.ROSS_LISTEN_MODE_SOURCE
    assert sent[0][0] == ross.MAV_CMD_ROSS_EXPLORE
    assert sent[1] == (ross.MAV_CMD_ROSS_ENROL, mode, 2, 1)
    assert sent[2][:2] == (ross.MAV_CMD_ROSS_LISTEN, ross.ROSS_LISTEN_MODE_VOICE)
    assert len(sent) == 3


def test_the_script_for_two_payloads_turns_both(monkeypatch):
    station = Scripted(Result.ACCEPTED)

    @asynccontextmanager
    async def opened(urls):
        yield station

    monkeypatch.setattr(ross_payload.ground.station, "Station", opened)
    names = executed(block(f"{GUIDES}/script-the-ground.md", "python", "turn_both").text)
    asyncio.run(names["turn_both"]("udpin:127.0.0.1:14550", PAYLOAD, PAYLOAD))
    turned = [each.param1 for each in station.commands() if each.command == ross.MAV_CMD_ROSS_TURN]
    assert sorted(set(turned)) == [-10, 10]


def test_the_numbers_of_an_address_are_those_of_the_table():
    guide = f"{GUIDES}/command-the-payload.md"
    with redirect_stdout(io.StringIO()) as said:
        executed(block(guide, "python", "divmod").text)
    number, *numbers = said.getvalue().replace("[", "").replace("]", "").replace(",", "").split()
    assert int(number) == ross.MAV_CMD_ROSS_STREAM
    assert [int(each) for each in numbers[-3:]] == [49320, 276, 136076]
    assert math.isnan(float(numbers[3]))
    assert "-1, 3, 2, NaN, 49320, 276, 136076 |" in (ROOT / guide).read_text(encoding="utf-8")


async def test_the_script_for_the_page_prints_the_heading(capsys):
    station = HandStation()
    station.say(status(1.0, heading=math.radians(-30)))
    async with page(station) as served:
        text = block("docs/reference/ground-page.md", "python", "ws_connect").text
        assert "asyncio.run(main())" in text
        names = executed(text.replace("http://127.0.0.1:8765/", served.url).replace("asyncio.run(main())", ""))
        reading = asyncio.create_task(names["main"]())
        async with asyncio.timeout(20):
            while not (said := capsys.readouterr().out):
                await asyncio.sleep(0.01)
        reading.cancel()
    assert float(said) == pytest.approx(30)
