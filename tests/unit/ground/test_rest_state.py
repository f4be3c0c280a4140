"""What programs see over REST is what the page shows, whole and typed."""

import asyncio
import math
import os
from dataclasses import replace

import pytest

from emulated_scene import full
from flight_logs import frames, log_of
from ground_page import page
from hand_station import HandStation
from recording_bench import input_of, record
from rest_program import PAYLOAD, program
from ross_payload import __version__
from ross_payload.ground.model.view import view
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_payload.ground.web.positions import TYPED, PayloadPosition
from ross_payload.json_values import finite
from ross_payload.sessions.catalog import Catalog
from ross_payload.sessions.session_store import SessionStore
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.computer import Computer, computer_message
from ross_protocols.mavlink.params import ParamError, SetRequest, error_message
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from scripted_station import Scripted, status
from waiting import wait_for_async

WHO = ComponentId(1, 191)
SECTIONS = {  # of the view, by path and name there
    "standing": ("", "standing"), "pointing": ("", "pointing"), "mission": ("", "mission"), "health": ("", "health"),
    "sources": ("/sources", "sources"), "streams": ("/streams", "streams"), "groups": ("/separation", "groups"),
    "densities": ("/exploration", "densities"), "isolation": ("/exploration", "isolation"),
    "history": ("/history", "history"), "events": ("/texts", "texts"),
}  # fmt: skip
STREAM = StreamReport(
    0, 0, 1, "rtp", Selection.AZIMUTH, True, 48000, on=True, azimuth=1.0, codec=Codec.OPUS, address="127.0.0.1",
    port=5004, level=-40.0, delay=0.1,
)  # fmt: skip


def mission():
    """A station that has heard everything that a payload tells."""
    station = HandStation()
    station.say(*full(30.0), STREAM, v.Text(v.Severity.NOTICE, "RoSS: mission over"))
    return station


def silent():
    """A station that has heard one word."""
    station = HandStation()
    station.say(v.Audio(time_usec=0))
    return station


def mirrored():
    """A station that has heard only what every ground station understands."""
    station = HandStation()
    station.say(v.Named(1.0, "ross_k", 2.0), v.Array(0, "ross_az", 1, (2.0, 30.0, 200.0)))
    return station


def fuller(told, drawn):
    """Whether an answer is what the view draws; what the view leaves out is null."""
    if isinstance(drawn, dict):
        assert drawn.keys() <= told.keys()
        return all(fuller(each, drawn[name]) if name in drawn else each is None for name, each in told.items())
    if isinstance(drawn, list | tuple):
        return len(told) == len(drawn) and all(map(fuller, told, drawn))
    return told == pytest.approx(drawn) if isinstance(drawn, float) else told == drawn


@pytest.mark.parametrize("station", [mission, silent, mirrored])
async def test_every_section_of_the_view_is_answered_as_the_page_draws_it(station):
    heard = station()
    async with page(heard) as served, program(served) as one:
        drawn = finite(view(heard.fleet.payloads[WHO]))
        for name, (path, field) in SECTIONS.items():
            told = await one.get(PAYLOAD + path)
            assert told.status == 200, told
            assert told.told["id"] == "1-191"
            assert fuller(told.told[field], drawn[name]), name
        plan = await one.get(f"{PAYLOAD}/plan")
        assert fuller({name: plan.told[name] for name in ("current", "candidates")}, drawn["plan"])
        assert {*SECTIONS, "plan"} == set(drawn)


async def test_a_direction_is_a_compass_direction_and_a_stream_says_where_it_goes():
    station = silent()
    station.say(replace(status(2.0), heading=math.radians(-90)), STREAM)
    async with page(station) as served, program(served) as one:
        assert (await one.get(PAYLOAD)).told["pointing"]["heading"] == pytest.approx(90, abs=0.01)
        (stream,) = (await one.get(f"{PAYLOAD}/streams")).told["streams"]
        assert (stream["address"], stream["port"], stream["codec"]) == ("127.0.0.1", 5004, "opus")
        assert stream["azimuth"] == pytest.approx(360 - math.degrees(1), abs=0.01)


async def test_the_processor_of_a_payload_is_told():
    station = silent()
    station.say(computer_message(Computer(5.0, (0.5, 0.25), 50.0, 1e9, 2e9), 0))
    async with page(station) as served, program(served) as one:
        processor = (await one.get(PAYLOAD)).told["health"]["processor"]
        assert (processor["loads"], processor["memory"]) == ([0.5, 0.25], pytest.approx(0.5, abs=0.01))


async def test_the_station_and_all_payloads_are_told_with_where_they_stand():
    station = mission()
    station.say(*full(30.0), who=ComponentId(2, 191))
    async with page(station) as served, program(served) as one:
        told = (await one.get("/station")).told
        assert (told["version"], told["mode"], [each["url"] for each in told["links"]]) == (
            __version__, "live", [station.states[0].url],
        )  # fmt: skip
        served.state.positions.typed[WHO] = served.state.positions.typed[ComponentId(2, 191)] = place(0.8)
        payloads = (await one.get("/payloads")).told
        assert [each["id"] for each in payloads["payloads"]] == ["1-191", "2-191"]
        assert payloads["places"]["1-191"]["from"] == "typed"
        assert payloads["bearings"]
        assert (await one.get("/payloads", headers={"Accept": "text/html"})).headers["Cache-Control"] == "no-store"


def place(latitude):
    return PayloadPosition(latitude, 0.2, 10.0, TYPED)


async def test_what_only_looks_asks_the_payload_for_nothing():
    station = mission()
    async with page(station) as served, program(served) as one:
        for path in ("", "/sources", "/streams", "/history", "/orders"):
            await one.get(PAYLOAD + path)
        await one.get("/payloads")
        assert not station.sent


async def test_head_is_answered_without_a_body():
    async with page(mission()) as served, program(served) as one:
        head = await one.ask("HEAD", PAYLOAD)
        assert (head.status, head.told) == (200, b"")
        assert (await one.ask("HEAD", f"{PAYLOAD}/events")).status == 405


# ------------------------------------------------------------------------------------------------ parameters


async def test_parameters_are_asked_for_once_somebody_does_and_set_until_they_are_read_back():
    station = Scripted()
    async with page(station) as served, program(served) as one:
        listed = (await one.get(f"{PAYLOAD}/parameters")).told
        assert listed["complete"]
        assert {each["name"]: each["value"] for each in listed["parameters"]} == {"EXP_UNIT": 3.0, "EXP_MAX_ROT": 12.0}
        put = await one.ask("PUT", f"{PAYLOAD}/parameters/EXP_UNIT", json={"value": 2.5})
        assert (put.status, put.told["value"], put.told["state"]) == (200, 2.5, "set")
        assert (await one.get(f"{PAYLOAD}/parameters/EXP_UNIT")).told["value"] == 2.5
        assert (await one.ask("POST", f"{PAYLOAD}/refresh")).told["complete"]
        lists = [each for each, _ in station.sent if each.get_type() == "PARAM_REQUEST_LIST"]
        assert len(lists) == 2
        assert (await one.get(PAYLOAD)).told["mission"]["expected"] is None


async def test_a_value_that_the_payload_refuses_is_a_problem_with_its_reason():
    station = Scripted(Result.ACCEPTED)
    station.refuses = True
    async with page(station) as served, program(served) as one:
        asking = one.ask("PUT", f"{PAYLOAD}/parameters/EXP_UNIT", json={"value": 99})
        told = await refused_meanwhile(station, asking)
        assert told.refused(409, "refused") == "EXP_UNIT = 99 was refused: expected 1 to 60, got 99"


async def refused_meanwhile(station, asking):
    """Let the payload refuse a value with a text, as soon as it is asked to set it."""
    task = asyncio.create_task(asking)
    await wait_for_async(lambda: any(each.get_type() == "PARAM_SET" for each, _ in station.sent))
    request = SetRequest(WHO, "EXP_UNIT", 99.0)
    station.say(error_message(request, ParamError.VALUE_OUT_OF_RANGE, ComponentId(254, 190)))
    station.say(v.Text(v.Severity.WARNING, "RoSS: EXP_UNIT: expected 1 to 60, got 99"))
    return await task


# ------------------------------------------------------------------------------------------------ files


async def test_recorded_sessions_are_listed_read_and_deleted(tmp_path):
    record(tmp_path, [input_of(index) for index in range(20)])
    (audio,) = tmp_path.glob("*/audio.wav")
    async with page(mission(), recordings=Catalog(SessionStore(tmp_path))) as served, program(served) as one:
        (known,) = (await one.get("/recordings")).told["recordings"]
        path = f"/recordings/{known['name']}"
        files = {each["name"]: each["bytes"] for each in (await one.get(path)).told["files"]}
        assert files["audio.wav"] == audio.stat().st_size
        told = await one.get(f"{path}/files/audio.wav")
        assert (told.told, told.headers["Cache-Control"]) == (audio.read_bytes(), "no-store")
        part = await one.get(f"{path}/files/audio.wav", headers={"Range": "bytes=0-3"})
        assert (part.status, part.told) == (206, b"RIFF")
        for wrong in ("bytes=9000000-", "bytes=5-2"):
            beyond = await one.get(f"{path}/files/audio.wav", headers={"Range": wrong})
            assert beyond.refused(416, "wrong-range")
            assert beyond.headers["Content-Range"] == f"bytes */{files['audio.wav']}"
        other = await one.get(f"{path}/files/audio.wav", headers={"If-Match": '"another"'})
        assert other.refused(412, "changed")
        assert (await one.get(f"{path}/archive")).told[:2] == b"PK"
        assert (await one.get(f"{path}/files/nothing")).refused(404, "not-found")
        assert (await one.ask("DELETE", path)).status == 204
        assert (await one.get(path)).refused(404, "not-found")
        assert not audio.exists()


async def test_a_flight_that_is_brought_is_listed(tmp_path):
    data = log_of(frames())
    async with page(mission(), FlightLibrary(None)) as served, program(served) as one:
        brought = await one.ask("POST", "/flights?name=one.tlog", data=data)
        assert (brought.status, brought.told) == (201, {"name": "one.tlog"})
        (flight,) = (await one.get("/flights")).told["flights"]
        assert (flight["name"], flight["sound"]) == ("one.tlog", [])
        assert (await one.get("/flights/one.tlog/sound/mixture")).refused(404, "not-found")


async def test_flights_whose_names_are_no_utf_8_are_listed_and_found_by_what_is_listed(tmp_path):
    (tmp_path / os.fsdecode(b"good \xff.tlog")).write_bytes(log_of(frames()))
    (tmp_path / os.fsdecode(b"bad \xff.tlog")).write_bytes(b"no frames")
    flights = FlightLibrary(tmp_path)
    async with page(mission(), flights) as served, program(served) as one:
        told = (await one.get("/flights")).told["flights"]
        assert {each["name"] for each in told} == {"good \\udcff.tlog", "bad \\udcff.tlog"}
        assert all(flights.path(each["name"]).is_file() for each in told)
