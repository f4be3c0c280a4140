"""The page's server: files, and what is known of payloads as it changes."""

import asyncio
import json
import time
from collections import Counter
from dataclasses import replace
from urllib.request import urlopen

import aiohttp
import pytest

from ground_page import audio, browser, page
from hand_station import PAYLOAD, HandStation, link
from ports import free_port
from ross_payload.ground.errors import GroundError
from ross_payload.ground.model.fleet import MOST_PAYLOADS
from ross_payload.ground.model.view import SECTIONS
from ross_payload.ground.web import websocket_sessions
from ross_payload.ground.web.app import in_background
from ross_payload.ground.web.server import bound
from ross_protocols.mavlink.codec import chunks
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.values import Severity
from waiting import wait_for_async

OTHER = ComponentId(2, 191)


async def test_whoever_watches_gets_all_sections_and_then_those_that_change():
    station = HandStation()
    station.say(audio())
    async with page(station) as served, browser(served.url) as one:
        assert (await one.next("hello"))["mode"] == "live"
        await one.say(type="watch", id="1-191")
        first = await one.next("payload")
        assert set(first["sections"]) >= set(SECTIONS)
        assert first["sections"]["health"]["microphones"]["rate"] == 16000
        station.say(audio(rate=48000))
        second = await one.next("payload")
        assert set(second["sections"]) == {"standing", "health"}
        assert second["sections"]["health"]["microphones"]["rate"] == 48000


async def test_nothing_is_sent_of_a_payload_that_nobody_watches():
    station = HandStation()
    station.say(audio())
    station.say(audio(), who=OTHER)
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        for _ in range(5):
            station.say(audio(rate=48000), who=OTHER)
            await asyncio.sleep(0.1)
        await one.say(type="unwatch")
        await one.say(type="nothing of the kind")
        await one.next("refused")  # so that what came before it is obeyed
        station.say(audio(rate=48000))
        await one.next("fleet")
        await one.next("fleet")
        assert Counter(each["type"] for each in one.got)["payload"] == 1


async def test_a_flood_of_changes_becomes_few_messages_and_the_last_one_counts():
    station = HandStation()
    station.say(audio())
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        start = time.monotonic()
        for rate in range(1000, 2001):
            station.say(audio(rate=rate))
            if rate % 10 == 0:
                await asyncio.sleep(0.005)
        await one.next("payload", lambda message: rate_of(message) == 2000)
        lasted = time.monotonic() - start
        assert Counter(each["type"] for each in one.got)["payload"] <= 2 + lasted / 0.05


async def test_a_change_is_sent_with_the_time_at_which_it_was_heard():
    station = HandStation()
    station.say(audio())
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        before = time.time() * 1e3
        station.say(audio(rate=8000))
        told = await one.next("payload", lambda message: rate_of(message) == 8000)
        assert before - 1 <= told["heard"] <= told["sent"] <= time.time() * 1e3 + 1
        assert told["sections"]["standing"]["last"] <= told["now"]


async def test_a_browser_that_never_stops_asking_holds_up_nobody_else(monkeypatch):
    turns, during = 0, []

    async def others():
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    monkeypatch.setattr(websocket_sessions, "on_message", lambda session, text: during.append(turns))
    async with page(HandStation()) as served, browser(served.url) as one:
        busy = asyncio.create_task(others())
        for _ in range(200):
            await one.say(type="watch", id="1-191")
        await wait_for_async(lambda: len(during) == 200)
        busy.cancel()
    assert len(set(during)) == 200


async def test_what_a_browser_said_before_it_came_again_is_obeyed_first(monkeypatch):
    """Its socket is cut, and much of what that brought may still wait in the process."""
    said = []
    monkeypatch.setattr(websocket_sessions, "on_message", lambda session, text: said.append(json.loads(text)["type"]))
    async with page(HandStation()) as served, browser(served.url) as one:
        hello = await one.next("hello")

        async def early():
            for _ in range(200):
                await one.say(type="early")

        saying = asyncio.create_task(early())
        async with browser(served.url, you=f"{hello['you']}&proof={hello['proof']}") as again:
            await again.say(type="late")
            await wait_for_async(lambda: "late" in said)
            await asyncio.sleep(0.1)
        await asyncio.gather(saying, return_exceptions=True)
    assert "early" in said
    assert said.index("late") == len(said) - 1


async def test_a_browser_that_does_not_read_holds_nobody_up_and_gets_the_latest():
    TOLD = 30
    station = HandStation()
    station.say(audio())
    talk(station, range(1, 101))
    async with page(station) as served, browser(served.url, window=8192) as slow, browser(served.url) as quick:
        for each in (slow, quick):
            await each.say(type="watch", id="1-191")
            await each.next("payload")
        slow.socket._response.connection.transport.pause_reading()
        for rate in range(1000, 1000 + TOLD):
            talk(station, [rate])
            station.say(audio(rate=rate))
            await quick.next("payload", lambda message, rate=rate: rate_of(message) == rate)
        slow.socket._response.connection.transport.resume_reading()
        await slow.next("payload", lambda message: rate_of(message) == 999 + TOLD)
        assert Counter(each["type"] for each in quick.got)["payload"] >= TOLD
        assert Counter(each["type"] for each in slow.got)["payload"] < TOLD / 2


def talk(station, numbers):
    """Say texts of 600 characters: 100 of them, 60 kB, are sent with every further one."""
    for number in numbers:
        for chunk in chunks(Severity.INFO, f"{number} at {time.monotonic()}".ljust(600, "x"), number):
            station.say(chunk)


def rate_of(message):
    return message["sections"].get("health", {}).get("microphones", {}).get("rate")


async def test_the_fleet_is_told_twice_a_second_and_at_once_when_a_payload_comes():
    station = HandStation()
    async with page(station) as served, browser(served.url) as one:
        first = await one.next("fleet")
        assert first["payloads"] == []
        assert first["advice"]
        station.say(audio())
        told = await one.next("fleet", lambda message: message["payloads"])
        assert told["payloads"][0]["id"] == "1-191"
        assert told["advice"] == ""
        later = await one.next("fleet")
        assert 0.0 < later["now"] - told["now"] < 2.0


async def test_ids_that_are_not_shown_are_counted_and_one_of_them_can_be_watched_and_stopped():
    """As when somebody makes ids up: the 64 that came first are on the page, and the payload came later."""

    station, late = HandStation(), ComponentId(200, 191)
    for _ in range(5):
        station.later += 1.0
        for system in range(1, MOST_PAYLOADS + 1):
            station.say(audio(), who=ComponentId(system, 191))
    station.say(audio(), who=late)
    async with page(station) as served, browser(served.url) as one:
        told = await one.next("fleet")
        assert told["hidden"] == {"count": 1, "ids": ["200-191"]}
        await one.say(type="order", id="200-191", order={"kind": "stop"})
        async with asyncio.timeout(20):
            while not any(who == late and sent.get_type() == "COMMAND_LONG" for sent, who in station.sent):
                await asyncio.sleep(0.02)
        await one.say(type="watch", id="200-191")
        await one.next("fleet")
        station.later += 1.0
        station.say(audio(), who=late)
        assert (await one.next("payload"))["id"] == "200-191"
        told = await one.next("fleet", lambda message: "200-191" in str(message["payloads"]))
        assert (len(told["payloads"]), told["hidden"]["count"]) == (MOST_PAYLOADS, 1)


async def test_a_link_that_goes_down_is_told():
    station = HandStation()
    async with page(station) as served, browser(served.url) as one:
        assert (await one.next("fleet"))["links"][0]["up"]
        station.states = [link(up=False, error="connection refused")]
        told = await one.next("fleet", lambda message: not message["links"][0]["up"])
        assert told["links"][0]["error"] == "connection refused"


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ("no json", "Expecting value"),
        ("[1]", "expected an object with a type, got [1]"),
        ('{"type": "dance"}', "type: expected one of "),
        ('{"type": ["watch"]}', "type: expected one of "),
        ('{"type": "watch", "id": "1-999"}', "expected system-component, as in 1-191, got '1-999'"),
        ('{"type": "watch"}', "expected system-component, as in 1-191, got 'None'"),
        ('{"type": "place", "id": "9-9", "lat": 0, "lon": 0}', "id: expected a payload that was received, got 9-9"),
        ('{"type": "place", "id": "1-191", "lat": 91, "lon": 0}', "lat: expected a number from -90 to 90, got 91"),
        ('{"type": "place", "id": "1-191", "lat": NaN, "lon": 0}', "lat: expected a number from -90 to 90, got nan"),
        ('{"type": "place", "id": "1-191", "lat": true, "lon": 0}', "lat: expected a number from -90 to 90, got True"),
        ("[" * 20000, "maximum recursion"),
    ],
)
async def test_what_cannot_be_meant_is_refused_in_words(message, reason):
    station = HandStation()
    station.say(audio())
    async with page(station) as served, browser(served.url) as one:
        await one.socket.send_str(message)
        assert reason in (await one.next("refused"))["reason"]


async def test_a_message_that_is_far_too_long_ends_the_socket_and_nothing_else():
    async with page(HandStation()) as served, browser(served.url) as one, browser(served.url) as other:
        await one.socket.send_str("x" * 200_000)
        async with asyncio.timeout(20):
            while (await one.socket.receive()).type != aiohttp.WSMsgType.CLOSE:
                pass
        await other.say(type="watch", id="no")
        await other.next("refused")


async def test_without_a_station_the_page_plays_past_flights_only():
    async with page(None) as served, browser(served.url) as one:
        hello = await one.next("hello")
        assert hello["mode"] == "flight"
        assert not hello["may_order"]
        await one.say(type="order", id="1-191", order={"kind": "stop"})
        assert (await one.next("refused"))["reason"] == "a recorded flight accepts no commands"


async def test_the_end_of_the_page_is_told_to_its_browsers_and_does_not_last():
    async with page(HandStation()) as served:
        client = aiohttp.ClientSession()
        socket = await client.ws_connect(f"{served.url}live")
        start = time.monotonic()
    assert time.monotonic() - start < 5.0
    async with asyncio.timeout(20):
        while (message := await socket.receive()).type is not aiohttp.WSMsgType.CLOSE:
            pass
    assert message.data == aiohttp.WSCloseCode.GOING_AWAY
    await client.close()


def test_a_program_without_a_loop_serves_the_page_on_a_thread():
    with in_background([f"udpin:127.0.0.1:{free_port()}"]) as served, urlopen(served.url) as answer:  # noqa: S310
        assert b"RoSS" in answer.read()


async def test_a_fault_of_the_page_costs_a_browser_its_socket_and_not_the_page():
    """The page comes again by itself; whoever looks at the terminal sees what happened."""
    told = []

    asyncio.get_running_loop().set_exception_handler(lambda loop, words: told.append(words["exception"]))
    station = HandStation()
    station.say(audio())
    async with page(station) as served, browser(served.url) as other:
        async with browser(served.url) as one:
            await one.say(type="watch", id="1-191")
            await one.next("payload")
            station.fleet.payloads[PAYLOAD] = replace(station.fleet.payloads[PAYLOAD], history=None)
            served.state.wake(PAYLOAD)
            async with asyncio.timeout(20):
                while (await one.socket.receive()).type is aiohttp.WSMsgType.TEXT:
                    pass
        await other.say(type="order", id="1-191", order={"kind": "stop"})
        async with asyncio.timeout(20):
            while not any(message.get_type() == "COMMAND_LONG" for message, _ in station.sent):
                await asyncio.sleep(0.02)
        await other.next("fleet")
    assert any(isinstance(error, TypeError) for error in told)


def test_of_two_that_begin_at_once_one_has_the_port():
    with bound("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(GroundError, match=f"--port {port}: expected a free port, got one in use"):
            bound("127.0.0.1", port)
