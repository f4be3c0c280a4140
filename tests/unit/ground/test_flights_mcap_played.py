"""MCAP files with sound on the page: ours play as the flights that they were, those of others without telemetry."""

import base64
import json
import os
import shutil
import stat
from io import BytesIO

import aiohttp
import numpy as np
import pytest
import soundfile
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from flight_sound import CLICK, HEARD_FROM, RATE, mixture, session, simulated
from ground_page import browser, page
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.mcap_import import APART_S, MOST_BYTES, AudioAssembly, Room, unpacked
from ross_payload.ground.flights.playback import Playback
from ross_payload.ground.flights.raw_audio import audio_part
from ross_payload.ground.flights.reading import open_flight
from ross_payload.ground.flights.sound import tracks_of
from ross_payload.ground.web.flight_library import FlightLibrary

pytest.importorskip("foxglove", reason="needs the extra 'mcap'")

ALIGNED_S = 0.02  # that is wanted, of sound and telemetry
EXACT_S = 0.0002  # of what we write ourselves
START_NS = 1_790_000_000 * 10**9


def exported(folder, path):
    from ross_payload.ground.flights.mcap import export

    flight = open_flight(folder)
    export(flight, flight.payloads, path)
    return flight


@pytest.fixture(params=["session", "simulation"])
def ours(request, tmp_path):
    """A flight, and the MCAP file that we make of it, alone in a folder."""
    folder = (session if request.param == "session" else simulated)(tmp_path / "flown")
    (tmp_path / "flights").mkdir()
    return exported(folder, tmp_path / "flights" / "flown.mcap"), tmp_path / "flights" / "flown.mcap"


def test_the_file_is_for_its_owner_alone_as_the_recording_is(tmp_path):
    before = os.umask(0o022)
    try:
        exported(session(tmp_path / "flown"), tmp_path / "flown.mcap")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "flown.mcap").stat().st_mode) == 0o600


def click(samples, rate):
    return int(np.argmax(np.abs(samples))) / rate


async def told_and_served(served, name):
    """What the page tells of a flight that it opens, and the tracks that it serves: samples, rate."""
    async with browser(served.url) as one, aiohttp.ClientSession() as client:
        await one.say(type="flight", slot="a", open=name)
        told = await one.next("flight")
        tracks = {}
        for each in told["sound"]:
            async with client.get(f"{served.url}flights/{name}/sound/{each['track']}") as answer:
                assert (answer.status, answer.content_type) == (200, "audio/wav")
                tracks[each["track"]] = soundfile.read(BytesIO(await answer.read()), always_2d=True)
        return told, tracks


def check_aligned(flight, told, tracks):
    """Clicks lie where they did in the flight, to the sample; begin and telemetry are those of the flight."""
    true = {each.name: each for each in tracks_of(flight)}
    begins = {each["track"]: each["begin"] for each in told["sound"]}
    assert set(tracks) == set(begins) == {"mixture", "target"}
    moments = {name: begins[name] + click(samples[:, 0], rate) for name, (samples, rate) in tracks.items()}
    assert abs(moments["mixture"] - moments["target"]) < EXACT_S < ALIGNED_S
    assert moments["mixture"] == pytest.approx(true["mixture"].begin + CLICK, abs=EXACT_S)
    assert told["duration"] == pytest.approx(flight.duration, abs=EXACT_S)
    assert (told["start"], told["simulated"]) == (flight.start, flight.simulated)
    assert told["payloads"] == [str(who) for who in flight.payloads]


async def test_a_file_of_ours_in_the_folder_plays_beside_its_telemetry(ours):
    flight, path = ours
    async with page(None, FlightLibrary(path.parent)) as served:
        check_aligned(flight, *await told_and_served(served, "flown.mcap"))
        rows = served.state.flights.known()
        assert rows[0]["sound"] == ["mixture", "target"]
    assert list(path.parent.iterdir()) == [path], "nothing is left beside it"


async def test_a_file_of_ours_that_is_uploaded_plays_beside_its_telemetry(ours):
    flight, path = ours
    async with page(None, FlightLibrary(None)) as served:
        async with (
            aiohttp.ClientSession() as client,
            client.post(f"{served.url}flights?name=flown.mcap", data=path.read_bytes()) as answer,
        ):
            assert await answer.json() == {"name": "flown.mcap"}
        check_aligned(flight, *await told_and_served(served, "flown.mcap"))


def test_telemetry_is_that_of_the_flight_at_every_moment(ours, tmp_path):
    flight, path = ours
    (tmp_path / "out").mkdir()
    again = open_flight(unpacked(path, tmp_path / "out"))
    one, other = Playback(flight), Playback(again)
    for at in np.linspace(0, flight.duration, 20):
        one.seek(at)
        other.seek(at)
        assert one.fleet.payloads == other.fleet.payloads
    assert again.marks == flight.marks


def test_sound_before_the_first_frame_is_not_moved_behind_it(tmp_path):
    flight = exported(simulated(tmp_path / "flown"), tmp_path / "flown.mcap")
    (tmp_path / "out").mkdir()
    tracks = {each.name: each for each in tracks_of(open_flight(unpacked(tmp_path / "flown.mcap", tmp_path / "out")))}
    true = {each.name: each for each in tracks_of(flight)}
    assert true["mixture"].begin < 0 <= tracks["mixture"].begin <= 1 / RATE, "the format has no time before 0"
    end = true["mixture"].begin + true["mixture"].duration
    assert tracks["mixture"].begin + tracks["mixture"].duration == pytest.approx(end, abs=EXACT_S)
    assert tracks["target"].begin == pytest.approx(HEARD_FROM + true["mixture"].begin, abs=EXACT_S)


def foreign(path, parts, *, schema="foxglove.RawAudio", form="pcm-s16", compression="ZSTD", topics=("/robot/ear",)):
    """Write samples as another program does: (time [s], samples)."""
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType[compression], chunk_size=20_000)
        writer.start()
        about = writer.register_schema(schema, "jsonschema", b"{}")
        channels = [writer.register_channel(topic, "json", about) for topic in topics]
        for time, samples in parts:
            stamp = START_NS + round(time * 1e9)
            message = {
                "timestamp": {"sec": stamp // 10**9, "nsec": stamp % 10**9},
                "data": base64.b64encode((samples * 32767).astype("<i2").tobytes()).decode(),
                "format": form,
                "sample_rate": RATE,
                "number_of_channels": 1,
            }
            late = stamp + 30_000_000  # it was logged behind the end of the sound
            for channel in channels:
                writer.add_message(channel, late, json.dumps(message).encode(), late)
        writer.finish()
    return path


def parts_of(samples, size=800, jitter=0.0, first=0.0):
    rng = np.random.default_rng(0)
    for begin in range(0, len(samples), size):
        yield first + begin / RATE + rng.uniform(-jitter, jitter), samples[begin : begin + size]


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
async def test_a_file_of_others_is_heard_without_telemetry(tmp_path, compression):
    foreign(tmp_path / "robot.mcap", parts_of(mixture(), jitter=0.004), compression=compression)
    async with page(None, FlightLibrary(tmp_path)) as served:
        told, tracks = await told_and_served(served, "robot.mcap")
    assert (told["payloads"], told["start"]) == ([], pytest.approx(START_NS / 1e9, abs=0.01))
    assert "no telemetry in it: sound alone" in told["notes"]
    samples, rate = tracks["robot-ear"]
    assert told["sound"][0]["begin"] == 0
    assert click(samples[:, 0], rate) == pytest.approx(CLICK, abs=ALIGNED_S / 2)
    assert told["duration"] == pytest.approx(len(mixture()) / RATE, abs=ALIGNED_S)


async def test_sound_alone_has_a_time_that_goes_on(tmp_path):
    foreign(tmp_path / "robot.mcap", parts_of(mixture()))
    async with page(None, FlightLibrary(tmp_path)) as served, browser(served.url) as one:
        await one.say(type="flight", slot="a", open="robot.mcap")
        await one.next("flight")
        await one.say(type="flight", slot="a", seek=2)
        await one.say(type="flight", slot="a", play=True)
        told = await one.next("flight", lambda message: message["at"] > 2.2)
        assert told["playing"]


def test_gaps_are_silence_and_what_comes_twice_is_left_out(tmp_path):
    voice = 0.5 * np.ones(RATE)
    assembly = AudioAssembly(tmp_path / "raw", RATE, 1, Room(MOST_BYTES))
    for time, samples in [*parts_of(voice, first=0.5), *parts_of(voice, first=2.0), (2.2, voice[:1600])]:
        assert assembly.add(round(time * 1e9), RATE, (samples * 32767).astype("<i2")[:, None])
    assert not assembly.add(0, 8000, np.zeros((10, 1), np.int16))
    begin, end = assembly.write(tmp_path / "voice.wav")
    assembly.close()
    assert (begin, end) == (0.5, 3.0)
    heard = soundfile.read(tmp_path / "voice.wav")[0]
    assert len(heard) == 2.5 * RATE
    loud = np.abs(heard) > 0.4
    assert loud[:RATE].all()
    assert not loud[RATE : round(1.5 * RATE)].any()
    assert loud[round(1.5 * RATE) :].all()
    assert [path.name for path in tmp_path.iterdir()] == ["voice.wav"]


def test_a_clock_that_drifts_never_takes_sound_far_from_its_time(tmp_path):
    assembly = AudioAssembly(tmp_path / "raw", RATE, 1, Room(MOST_BYTES))
    block, fast = 800, 1.002  # the stamps' clock, 2 parts in a thousand
    for number in range(400):
        samples = np.full((block, 1), number, np.int16)
        assembly.add(round(number * block / RATE * fast * 1e9), RATE, samples)
    assembly.write(tmp_path / "a.wav")
    assembly.close()
    heard = soundfile.read(tmp_path / "a.wav", dtype="int16")[0]
    for number in range(1, 400):
        place = int(np.argmax(heard == number)) / RATE
        assert abs(place - number * block / RATE * fast) <= APART_S + 1 / RATE


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"form": "pcm-f32"}, r"/robot/ear is not played: format: expected pcm-s16, got pcm-f32"),
        (
            {"schema": "foxglove.RawImage"},
            r"expected an MCAP file with a telemetry log or foxglove\.Raw.*, got neither",
        ),
    ],
)
async def test_what_cannot_be_played_is_refused_in_one_line_and_leaves_nothing(tmp_path, change, why):
    path = foreign(tmp_path / "robot.mcap", parts_of(mixture()), **change)
    (tmp_path / "out").mkdir()
    with pytest.raises(GroundError, match=why):
        unpacked(path, tmp_path / "out")
    assert not list((tmp_path / "out").iterdir())
    library = FlightLibrary(None)
    with library:
        async with page(None, library) as served, aiohttp.ClientSession() as client:
            for name, data in [("robot.mcap", path.read_bytes()), ("text.mcap", b"hello"), ("empty.mcap", b"")]:
                async with client.post(f"{served.url}flights?name={name}", data=data) as answer:
                    assert answer.status == 422
                    said = (await answer.json())["error"]
                    assert said.startswith(f"{name}: expected an MCAP file")
            assert library.known() == []


def test_a_file_that_is_cut_off_is_played_as_far_as_it_goes(tmp_path):
    path = foreign(tmp_path / "robot.mcap", parts_of(mixture()))
    os.truncate(path, path.stat().st_size * 2 // 3)
    (tmp_path / "out").mkdir()
    flight = open_flight(unpacked(path, tmp_path / "out"))
    assert 1.0 < flight.duration < 3.9
    assert flight.notes[0].startswith("the file is damaged")


def test_of_sound_without_end_only_as_much_is_kept_as_a_recording_may_have(tmp_path, monkeypatch):
    """Compressed, the same second a million times is a small file."""
    path = foreign(tmp_path / "robot.mcap", [(0.0, np.zeros(RATE))] * 50)
    most = 4 * RATE
    monkeypatch.setattr("ross_payload.ground.flights.mcap_import.MOST_BYTES", most)
    kept = []
    write = AudioAssembly.write
    monkeypatch.setattr(
        AudioAssembly, "write", lambda self, to: kept.append(to.with_suffix(".raw").stat().st_size) or write(self, to)
    )
    (tmp_path / "out").mkdir()
    flight = open_flight(unpacked(path, tmp_path / "out"))
    assert max(kept) <= most
    assert any("only the first" in note for note in flight.notes)


@pytest.mark.parametrize("apart", [1.0, 2.5], ids=["sound", "gaps"])
def test_all_tracks_of_a_file_together_take_no_more_than_a_recording_may(tmp_path, monkeypatch, apart):
    """Every topic has two seconds of sound: 12 s of six topics, and 9 s of silence with gaps."""
    most = 2 * RATE * (6 if apart == 1.0 else 15)
    monkeypatch.setattr("ross_payload.ground.flights.mcap_import.MOST_BYTES", most)
    parts = [(0.0, np.ones(RATE)), (apart, np.ones(RATE))]
    foreign(tmp_path / "robot.mcap", parts, topics=[f"/ear/{number}" for number in range(6)])
    (tmp_path / "out").mkdir()
    tracks = tracks_of(open_flight(unpacked(tmp_path / "robot.mcap", tmp_path / "out")))
    assert len(tracks) == 6
    frames = [soundfile.info(path).frames for path in (tmp_path / "out").glob("*.wav")]
    assert most / 2 < 2 * sum(frames) <= most


def test_a_chunk_that_grows_beyond_what_it_says_is_not_inflated(tmp_path, monkeypatch):
    path = foreign(tmp_path / "robot.mcap", parts_of(mixture()))
    monkeypatch.setattr("ross_payload.ground.flights.mcap_import.LARGEST_RECORD", 15_000)
    (tmp_path / "out").mkdir()
    with pytest.raises(GroundError, match="expected chunks up to"):
        unpacked(path, tmp_path / "out")


@settings(max_examples=examples(300))
@given(st.binary(max_size=200), st.sampled_from(["protobuf", "json", "cdr"]))
def test_no_bytes_do_more_than_be_refused(data, encoding):
    try:
        part = audio_part(data, encoding)
    except ValueError:
        return
    assert part.samples.dtype == np.int16


@settings(max_examples=examples(60))
@given(st.data())
def test_no_damage_does_more_than_be_refused(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("damaged")
    content = bytearray(foreign(folder / "a.mcap", parts_of(mixture()[:8000]), compression="NONE").read_bytes())
    for place in data.draw(st.lists(st.integers(8, len(content) - 1), min_size=1, max_size=5)):
        content[place] = data.draw(st.integers(0, 255))
    (folder / "a.mcap").write_bytes(content)
    (folder / "out").mkdir()
    try:
        tracks_of(open_flight(unpacked(folder / "a.mcap", folder / "out")))
    except GroundError as error:
        assert "\n" not in error.message
    finally:
        shutil.rmtree(folder)


async def test_without_the_package_it_is_told_how_to_install_it(ours, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "mcap.stream_reader", None)
    monkeypatch.setitem(sys.modules, "mcap.records", None)
    monkeypatch.setitem(sys.modules, "mcap.exceptions", None)
    async with page(None, FlightLibrary(ours[1].parent)) as served, browser(served.url) as one:
        await one.say(type="flight", slot="a", open="flown.mcap")
        refused = await one.next("refused")
    assert "an MCAP file needs the package mcap: " in refused["reason"]
    assert "install" in refused["reason"]
