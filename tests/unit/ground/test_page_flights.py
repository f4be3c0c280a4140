"""Flights of the past on the page: what is in the folder, what browsers bring, and how it plays."""

import asyncio
import io
import itertools
import os
import shutil
import stat
import tempfile
import time
from pathlib import Path

import aiohttp
import pytest

from emulated_log import log
from flight_logs import UNIX, record, write_hour
from ground_page import browser, page
from ross_payload.ground.web import flight_library
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common

NAMES = "name: expected that of a telemetry log (.tlog) or of an MCAP file (.mcap)"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A log of two payloads, one of somebody else, a session, and what is none."""
    flights = tmp_path_factory.mktemp("written")
    (flights / "session").mkdir()
    (flights / "empty").mkdir()
    write_hour(flights / "two.tlog", seconds=10, payloads=2, hertz=4)
    write_hour(flights / "session" / "telemetry.tlog", seconds=5, payloads=1, hertz=4)
    beat = Encoder(1, 1).encode(common.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3))
    (flights / "other.tlog").write_bytes(record(UNIX, beat))
    (flights / "text.tlog").write_text("hello")
    (flights / "notes.txt").write_text("hello")
    return flights


@pytest.fixture
def folder(written, tmp_path):
    """A copy of these flights that are written just now."""
    return shutil.copytree(written, tmp_path / "flights", copy_function=shutil.copyfile)


async def opened(one, name="two.tlog", slot="a"):
    await one.say(type="flight", slot=slot, open=name)
    return await one.next("flight", lambda message: message["slot"] == slot)


async def test_the_flights_of_the_folder_are_listed_with_what_is_odd_about_them(folder):
    for path in folder.rglob("*.tlog"):
        make_old(path)
    async with page(None, FlightLibrary(folder)) as served, browser(served.url) as one:
        told = await one.next("flights", lambda message: message["known"])
        known = {each["name"]: each for each in told["known"]}
        assert set(known) == {"two.tlog", "session", "other.tlog", "text.tlog"}
        assert "got a text" in known["text.tlog"]["notes"][0]
        assert "no messages of a payload" in known["other.tlog"]["notes"][0]


def make_old(path):
    os.utime(path, (time.time() - 100, time.time() - 100))


def test_a_folder_that_nobody_may_look_into_hides_no_flight(folder, monkeypatch):
    locked, look = folder / "lost+found", Path.is_file

    def refused(path):
        if locked in path.parents:
            raise PermissionError(13, "Permission denied", str(path))
        return look(path)

    locked.mkdir()
    monkeypatch.setattr(Path, "is_file", refused)
    with FlightLibrary(folder) as library:
        assert "two.tlog" in {each["name"] for each in library.known()}


def test_a_flight_that_is_still_written_is_listed_and_not_read_again_and_again(folder):
    flights = FlightLibrary(folder)
    rows = {each["name"]: each for each in flights.known()}
    assert rows["two.tlog"]["duration"] is None
    assert rows["two.tlog"]["start"] == pytest.approx(UNIX / 1e6)
    make_old(folder / "two.tlog")
    rows = {each["name"]: each for each in flights.known()}
    assert rows["two.tlog"]["duration"] == pytest.approx(9.9, abs=0.2)


def test_a_simulated_flight_has_no_date_while_it_is_written_either(tmp_path):
    log(tmp_path / "mission.tlog", start=0)  # a simulation's clock counts from its own start
    log(tmp_path / "booted.tlog", start=60_000_000)  # a computer that knows no date counts from its boot
    flights = FlightLibrary(tmp_path)
    for _ in ("still written", "whole"):
        rows = {each["name"]: each for each in flights.known()}
        assert [rows["mission.tlog"][key] for key in ("start", "simulated")] == [None, True]
        assert [rows["booted.tlog"][key] for key in ("start", "simulated")] == [None, False]
        for path in tmp_path.iterdir():
            make_old(path)
    assert rows["mission.tlog"]["duration"] == pytest.approx(19.8, abs=0.2)


async def test_an_opened_flight_tells_what_is_in_it_and_shows_its_first_payload(folder):
    async with page(None, FlightLibrary(folder)) as served, browser(served.url) as one:
        told = await opened(one)
        assert told["name"] == "two.tlog"
        assert told["payloads"] == ["1-191", "2-191"]
        assert told["duration"] == pytest.approx(9.9, abs=0.2)
        assert (told["at"], told["playing"], told["speed"]) == (0, False, 1)
        assert told["marks"][0]["words"]
        await one.say(type="flight", slot="a", seek=8)
        shown = await one.next("payload", lambda message: message["now"] == 8)
        assert (shown["slot"], shown["id"]) == ("a", "1-191")
        assert shown["sections"]["mission"]["time"] == pytest.approx(8, abs=0.2)
        await one.say(type="flight", slot="a", watch="2-191")
        shown = await one.next("payload", lambda message: message["id"] == "2-191")
        assert len(shown["sections"]) == 12


async def test_a_flight_stops_at_its_end_and_plays_from_the_beginning_again(folder):
    async with page(None, FlightLibrary(folder)) as served, browser(served.url) as one:
        told = await opened(one)
        await one.say(type="flight", slot="a", seek=told["duration"] - 0.2)
        await one.say(type="flight", slot="a", play=True)
        ended = await one.next("flight", lambda message: message["at"] == told["duration"] and not message["playing"])
        assert ended["at"] == told["duration"]
        await one.say(type="flight", slot="a", play=True)
        await one.next("flight", lambda message: message["playing"] and message["at"] < 5)


async def test_before_its_first_word_nothing_is_known_of_a_payload(folder):
    beat = Encoder(1, 1).encode(common.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3))
    late = (folder / "session" / "telemetry.tlog").read_bytes()
    (folder / "late.tlog").write_bytes(record(UNIX - 20_000_000, beat) + late)

    async with page(None, FlightLibrary(folder)) as served, browser(served.url) as one:
        await opened(one, "late.tlog")
        await one.say(type="flight", slot="a", seek=23.0)
        await one.next("payload", lambda message: (message["sections"].get("standing") or {}).get("state"))
        await one.say(type="flight", slot="a", seek=5.0)
        told = await one.next("payload", lambda message: "standing" in message["sections"])
        assert (told["sections"]["standing"]["state"], told["sections"]["standing"]["last"]) == (None, None)
        assert told["sections"]["sources"] == []


async def test_two_flights_play_apart(folder):
    async with (
        page(None, FlightLibrary(folder)) as served,
        browser(served.url) as one,
        browser(served.url) as other,
    ):
        await opened(one, "two.tlog", "a")
        await opened(one, "session", "b")
        await opened(other, "session", "a")
        await one.say(type="flight", slot="a", seek=8)
        await one.next("flight", lambda message: message["at"] == 8)
        await one.say(type="flight", slot="b", seek=3)
        told = await one.next("flight", lambda message: message["at"] == 3)
        assert (told["slot"], told["name"]) == ("b", "session")
        await one.say(type="flight", slot="b", close=True)
        await one.say(type="flight", slot="b", seek=1)
        assert (await one.next("refused"))["reason"] == "no flight is open in b"
        assert all(each["at"] == 0 for each in other.got if each["type"] == "flight")


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ({"slot": "c", "open": "two.tlog"}, "slot: expected one of a, b, got c"),
        ({"slot": ["a"], "open": "two.tlog"}, "slot: expected one of a, b, got "),
        ({"slot": "a", "open": "../flights/two.tlog"}, "not found"),
        ({"slot": "a", "open": "/etc/passwd"}, "not found"),
        ({"slot": "a", "open": "text.tlog"}, "got a text"),
        ({"slot": "b", "seek": 1}, "no flight is open in b"),
        ({"slot": "a", "seek": "1"}, "seek: expected a number from 0"),
        ({"slot": "a", "speed": 0}, "speed: expected a number from 1 to 64, got 0"),
        ({"slot": "a", "play": 1}, "flight: expected one of open, close"),
        ({"slot": "a", "watch": "all"}, "expected system-component, as in 1-191, got 'all'"),
    ],
)
async def test_what_no_flight_can_do_is_refused(folder, message, reason):
    async with page(None, FlightLibrary(folder)) as served, browser(served.url) as one:
        await opened(one)
        await one.say(type="flight", **message)
        assert reason in (await one.next("refused"))["reason"]


async def bring(served, name, data):
    address, body = f"{served.url}flights", io.BytesIO(data)
    async with aiohttp.ClientSession() as client, client.post(address, params={"name": name}, data=body) as answer:
        return answer.status, await answer.json()


async def test_a_flight_that_is_brought_is_played_and_gone_with_the_page(folder):
    flights = FlightLibrary(None)
    async with page(None, flights) as served, browser(served.url) as one:
        data = (folder / "two.tlog").read_bytes()
        assert await bring(served, "two.tlog", data) == (200, {"name": "two.tlog"})
        told = await one.next("flights", lambda message: message["known"])
        assert told["known"][0]["name"] == "two.tlog"
        kept = flights.path("two.tlog")
        assert stat.S_IMODE(kept.parent.stat().st_mode) == 0o700
        status, answer = await bring(served, "two.tlog", data)
        assert (status, answer) == (200, {"name": "two 2.tlog"})
        assert (await opened(one, "two 2.tlog"))["payloads"] == ["1-191", "2-191"]
    assert not kept.parent.exists()


@pytest.mark.parametrize(
    ("name", "data", "status", "why"),
    [
        (
            "notes.txt",
            b"hello",
            415,
            "name: expected that of a telemetry log (.tlog) or of an MCAP file (.mcap), got notes.txt",
        ),
        ("", b"hello", 415, "name: expected that of a telemetry log (.tlog) or of an MCAP file (.mcap), got none"),
        ("text.tlog", b"hello", 422, "text.tlog: expected a telemetry log (.tlog) or a session folder, got a text"),
        ("empty.tlog", b"", 422, "empty.tlog: expected a telemetry log (.tlog) or a session folder, got an empty file"),
        ("large.tlog", b"x" * 3_000_000, 413, "expected at most 2 MB, got more"),
    ],
)
async def test_what_is_no_flight_is_refused_in_one_line_and_not_kept(name, data, status, why, monkeypatch):
    monkeypatch.setattr(flight_library, "MAX_BYTES", 2 << 20)
    flights = FlightLibrary(None)
    async with page(None, flights) as served:
        found, answer = await bring(served, name, data)
        assert found == status
        assert why in answer["error"]
        assert "\n" not in answer["error"]
        assert "/tmp" not in answer["error"]  # noqa: S108
        assert flights.known() == []


@pytest.mark.parametrize(
    "name", ["../../evil.tlog", "/etc/evil.tlog", "..\\evil.tlog", ".tlog", "....tlog", "a\0b.tlog"]
)
async def test_no_name_leads_out_of_the_folder(folder, name):
    flights = FlightLibrary(None)
    async with page(None, flights) as served:
        status, answer = await bring(served, name, (folder / "session" / "telemetry.tlog").read_bytes())
        assert status == 200
        kept = flights.path(answer["name"])
        assert kept.parent.name.startswith("ross-flights-")
        assert kept.resolve().parent == kept.parent.resolve()
        assert not Path(answer["name"]).name.startswith(".")


async def test_no_more_flights_are_brought_than_there_is_room_for(folder, monkeypatch):
    monkeypatch.setattr(flight_library, "MAX_UPLOADED", 2)
    async with page(None, FlightLibrary(None)) as served:
        data = (folder / "session" / "telemetry.tlog").read_bytes()
        assert (await bring(served, "a.tlog", data))[0] == 200
        assert (await bring(served, "b.tlog", data))[0] == 200
        assert await bring(served, "c.tlog", data) == (
            507, {"error": "2 flights were brought already: no more are accepted"},
        )  # fmt: skip


async def test_a_pipe_among_the_flights_holds_nobody_up(tmp_path):
    log(tmp_path / "one.tlog", seconds=1)
    os.mkfifo(tmp_path / "pipe.tlog")
    writer = os.open(tmp_path / "pipe.tlog", os.O_RDWR)
    os.write(writer, bytes(1000))  # whoever reads it all the same comes to an end
    assert [each["name"] for each in FlightLibrary(tmp_path).known()] == ["one.tlog"]
    os.close(writer)


async def test_a_browser_that_goes_while_it_brings_a_flight_leaves_nothing():
    def parts():
        return list(Path(tempfile.gettempdir()).glob(f"ross-flights-*/gone-{os.getpid()}*.part"))

    async def until(wanted):
        async with asyncio.timeout(20):
            for _ in itertools.count():
                if wanted():
                    return
                await asyncio.sleep(0.02)

    flights = FlightLibrary(None)
    async with page(None, flights) as served:
        host, port = served.url.removeprefix("http://").strip("/").split(":")
        _, writer = await asyncio.open_connection(host, int(port))
        head = f"POST /flights?name=gone-{os.getpid()}.tlog HTTP/1.1\r\nHost: {host}:{port}\r\n"
        head += "Content-Length: 1000000\r\n\r\n"
        writer.write(head.encode() + b"x" * 1000)
        await writer.drain()
        await until(parts)
        writer.transport.abort()
        await until(lambda: not parts())
