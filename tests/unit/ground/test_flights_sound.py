"""The sound of recorded flights: where it begins in the flight, who gets it, and what an MCAP export has of it."""

import json
import os

import aiohttp
import numpy as np
import pytest

from flight_sound import CLICK, CLOCK_AT_START, HEARD_FROM, LATE_S, PERIOD, RATE, SECONDS, session, simulated
from ground_page import browser, page
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.reading import open_flight
from ross_payload.ground.flights.sound import sound_files, tracks_of
from ross_payload.ground.web.flight_library import FlightLibrary

FIRST_FRAME = 2 * PERIOD + LATE_S[2]  # after the first sample [s]


@pytest.fixture
def folder(tmp_path):
    simulated(tmp_path / "flights")
    session(tmp_path / "flights" / "0001")
    return tmp_path / "flights"


def test_tracks_of_a_simulation_begin_where_the_report_says(folder):
    tracks = {each.name: each for each in tracks_of(open_flight(folder / "mission.tlog"))}
    earliest = min(LATE_S)  # what came soonest tells the clocks apart
    assert tracks["mixture"].begin == pytest.approx(earliest - FIRST_FRAME, abs=1e-5)
    assert tracks["target"].begin == pytest.approx(HEARD_FROM + earliest - FIRST_FRAME, abs=1e-5)
    assert tracks["target"].duration == SECONDS - HEARD_FROM
    assert (tracks["mixture"].rate, tracks["mixture"].channels) == (RATE, 2)


def test_tracks_of_a_session_have_the_payloads_clock(folder):
    tracks = {each.name: each for each in tracks_of(open_flight(folder / "0001"))}
    assert tracks["mixture"].begin == tracks["target"].begin == pytest.approx(min(LATE_S) - FIRST_FRAME, abs=1e-5)
    assert CLOCK_AT_START > 1.0


def test_tracks_of_a_session_whose_telemetry_has_unix_time_begin_where_they_were_heard(tmp_path):
    tracks = {each.name: each for each in tracks_of(open_flight(session(tmp_path / "0001", unix=True)))}
    assert tracks["mixture"].begin == tracks["target"].begin == pytest.approx(min(LATE_S) - FIRST_FRAME, abs=1e-3)


def test_the_voices_of_a_session_are_heard_though_its_mixture_is_damaged(tmp_path):
    session(tmp_path / "0001", unix=True)
    (tmp_path / "0001" / "audio.wav").write_bytes(b"\0" * 100)
    assert [each.name for each in tracks_of(open_flight(tmp_path / "0001"))] == ["target"]


@pytest.mark.parametrize("damage", ["report.json", "mixture.wav", "target.wav"])
def test_what_is_damaged_is_left_out(folder, damage):
    (folder / damage).write_bytes(b"\0" * 100)
    left = {each.name for each in tracks_of(open_flight(folder / "mission.tlog"))}
    assert left == {"mixture", "target"} - {"target" if damage == "report.json" else damage.removesuffix(".wav")}


def test_a_log_without_its_folder_has_no_sound(folder):
    log = (folder / "mission.tlog").rename(folder / "renamed.tlog")
    assert sound_files(log) == {}
    assert tracks_of(open_flight(log)) == ()


def test_a_session_without_its_first_input_has_no_sound(folder):
    (folder / "0001" / "inputs.jsonl").write_text("{")
    assert tracks_of(open_flight(folder / "0001")) == ()


@pytest.mark.parametrize("time", ["NaN", "-Infinity", "1e300", "1e12", "1" + 400 * "0"])
def test_a_session_whose_first_input_came_at_no_time_has_no_sound(folder, tmp_path, time):
    (folder / "0001" / "inputs.jsonl").write_text(f'{{"time": {time}, "index": 0}}\n')
    flight = open_flight(folder / "0001")
    assert tracks_of(flight) == ()
    exported(flight, tmp_path)


@pytest.mark.parametrize("started", ["00010101T000000Z", "99991231T235959Z"])
def test_a_session_of_a_clock_that_no_calendar_has_is_exported(folder, tmp_path, started):
    (folder / "mission.tlog").replace(folder / "0001" / "telemetry.tlog")  # which does not know the time
    (folder / "0001" / "session.json").write_text(json.dumps({"format": "ross-session", "started": started}))
    flight = open_flight(folder / "0001")
    assert flight.start is None
    exported(flight, tmp_path)


def test_a_folder_whose_name_is_not_utf_8_has_sound(folder, tmp_path):
    odd = (folder / "0001").rename(folder / os.fsdecode(b"fl\xffight"))
    flight = open_flight(odd)
    assert {each.name for each in tracks_of(flight)} == {"mixture", "target"}
    exported(flight, tmp_path)


def test_a_voice_whose_name_is_not_utf_8_is_left_out(folder):
    (folder / "0001" / "target.flac").rename(folder / "0001" / os.fsdecode(b"t\xffarget.flac"))
    assert {each.name for each in tracks_of(open_flight(folder / "0001"))} == {"mixture"}


async def test_a_flight_tells_its_tracks_and_gives_them_out(folder):
    async with page(None, FlightLibrary(folder)) as served, browser(served.url) as one:
        known = (await one.next("flights", lambda message: message["known"]))["known"]
        assert {each["name"]: each["sound"] for each in known} == {
            "0001": ["mixture", "target"],
            "mission.tlog": ["mixture", "target"],
        }
        await one.say(type="flight", slot="a", open="0001")
        told = await one.next("flight")
        assert [each["track"] for each in told["sound"]] == ["mixture", "target"]
        async with aiohttp.ClientSession() as client:
            async with client.get(f"{served.url}flights/0001/sound/mixture") as answer:
                assert answer.content_type == "audio/wav"
                assert answer.headers["Cache-Control"] == "no-store"
                assert await answer.read() == (folder / "0001" / "audio.wav").read_bytes()
            part = {"Range": "bytes=100-199"}
            async with client.get(f"{served.url}flights/mission.tlog/sound/target", headers=part) as answer:
                assert (answer.status, await answer.read()) == (206, (folder / "target.wav").read_bytes()[100:200])


@pytest.mark.parametrize("path", ["0001/sound/config", "0001/sound/..%2Fsession", "nobody/sound/mixture"])
async def test_nothing_else_is_given_out(folder, path):
    async with (
        page(None, FlightLibrary(folder)) as served,
        aiohttp.ClientSession() as client,
        client.get(f"{served.url}flights/{path}") as answer,
    ):
        assert answer.status == 404
    with pytest.raises(GroundError, match="no sound 'config'"):
        FlightLibrary(folder).sound("0001", "config")


async def test_sound_needs_the_token(folder):
    async with (
        page(None, FlightLibrary(folder), token="t" * 20) as served,
        aiohttp.ClientSession() as client,
        client.get(f"{served.url}flights/0001/sound/mixture") as answer,
    ):
        assert answer.status == 401


@pytest.mark.parametrize("name", ["mission.tlog", "0001"])
def test_mixture_and_target_are_aligned_in_an_export(folder, tmp_path, name):
    pytest.importorskip("foxglove", reason="needs the extra 'mcap'")
    from mcap.reader import make_reader

    from ross_payload.ground.flights.mcap import export

    flight = open_flight(folder / name)
    export(flight, flight.payloads, tmp_path / "flight.mcap")
    with (tmp_path / "flight.mcap").open("rb") as file:
        messages = list(make_reader(file).iter_messages(log_time_order=False))
    times = [message.log_time for _, _, message in messages]
    assert sorted(times) == times
    clicks = {}
    for schema, channel, message in messages:
        if channel.topic.startswith("/sound/"):
            assert schema.name == "foxglove.RawAudio"
            samples, rate, channels = raw_audio(message.data)
            heard = np.abs(samples[::channels])
            if heard.max() > 0.9:
                clicks[channel.topic] = message.log_time / 1e9 + np.argmax(heard) / rate
    assert set(clicks) == {"/sound/mixture", "/sound/target"}
    assert abs(clicks["/sound/mixture"] - clicks["/sound/target"]) < 0.001
    begin = next(each.begin for each in tracks_of(flight) if each.name == "mixture")
    assert clicks["/sound/mixture"] - (flight.start or 0.0) - begin == pytest.approx(CLICK, abs=0.02)


def exported(flight, folder):
    """Export a flight, where that can be."""
    pytest.importorskip("foxglove", reason="needs the extra 'mcap'")
    from ross_payload.ground.flights.mcap import export

    export(flight, flight.payloads, folder / "flight.mcap")


def raw_audio(data):
    """Read samples, rate and channels of foxglove.RawAudio with nothing of ours: fields 2, 4 and 5 of protobuf."""
    place, fields = 0, {}

    def number():
        nonlocal place
        value = shift = 0
        while True:
            byte, place = data[place], place + 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while place < len(data):
        tag = number()
        if tag & 7 == 2:
            size = number()
            fields[tag >> 3], place = data[place : place + size], place + size
        else:
            fields[tag >> 3] = int.from_bytes(data[place : place + 4], "little") if tag & 7 == 5 else number()
            place += 4 if tag & 7 == 5 else 0
    assert fields[3] == b"pcm-s16"
    return np.frombuffer(fields[2], "<i2") / 32768, fields[4], fields[5]
