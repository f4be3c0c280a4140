import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from examples import in_soak
from ross_payload.errors import ConfigError
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.room import SINC, RoomSpec, respond
from ross_sim.cache import cache_folder, cached

RATE = 16000


def spec(**changes):
    values = {
        "size": (10.0, 10.0),
        "t60": 0.0,
        "rate": RATE,
        "array_centre": (5.0, 5.0),
        "spacing": 0.05,
        "sources": ((7.0, 5.0),),
    }
    return RoomSpec(**{**values, **changes})


def tdoa(response):
    """How much earlier microphone 2 hears [s], from the phase slope of the cross-spectrum up to 3 kHz."""
    first, second = np.fft.rfft(response[:, 0], 8192)
    frequencies = np.fft.rfftfreq(8192, 1 / RATE)
    band = (frequencies > 300) & (frequencies < 3000)
    phase = np.angle(second * first.conj())[band]
    return np.sum(phase * frequencies[band]) / np.sum(2 * np.pi * frequencies[band] ** 2)


@pytest.mark.parametrize("heading_deg", [0, 35, 90, 144.3, 180, 300])
def test_tdoa_is_spacing_over_speed_times_cosine(heading_deg):
    heading, azimuth = math.radians(heading_deg), math.radians(20)
    source = (5 + 3 * math.cos(azimuth), 5 + 3 * math.sin(azimuth))
    response = respond(spec(sources=(source,)), [heading])[0]
    assert tdoa(response) == pytest.approx(0.05 / 343 * math.cos(azimuth - heading), abs=5e-7)


def test_source_ahead_reaches_microphone_2_first():
    assert tdoa(respond(spec(), [0.0])[0]) > 1e-4


def test_elevation_shortens_the_tdoa_in_three_dimensions():
    room = spec(size=(8.0, 8.0, 4.0), array_centre=(4.0, 4.0, 1.0), sources=((6.0, 4.0, 3.0),))
    assert tdoa(respond(room, [0.0])[0]) == pytest.approx(0.05 / 343 * math.cos(math.pi / 4), abs=5e-7)


def test_open_air_falls_off_with_distance():
    near, far = respond(spec(sources=((6.0, 5.0), (9.0, 5.0))), [math.pi / 2])[0, 0]
    assert np.sum(near) / np.sum(far) == pytest.approx(4.0, rel=0.01)


def test_speed_of_sound_sets_the_arrival():
    response = respond(spec(speed_of_sound=320.0, spacing=0.02, sources=((9.0, 5.0),)), [math.pi / 2])[0, 0, 0]
    assert np.abs(response).argmax() - SINC // 2 == pytest.approx(4.0 / 320 * RATE, abs=1)


@pytest.mark.parametrize("size", [(10.0, 10.0), *in_soak((5.0, 4.0, 3.0))])
def test_energy_decays_by_thirty_db_in_about_half_of_t60(size):
    centre = tuple(side / 2 for side in size)
    source = (centre[0] + 1.5, *centre[1:])
    response = respond(RoomSpec(size, 0.4, RATE, centre, 0.05, (source,)), [0.0])[0, 0, 0].astype(float)
    decay = 10 * np.log10(np.cumsum(response[::-1] ** 2)[::-1] / np.sum(response**2))
    begin, end = np.argmax(decay < -5), np.argmax(decay < -35)
    assert 2 * (end - begin) / RATE == pytest.approx(0.4, rel=0.3)


def test_one_heading_does_not_depend_on_the_others():
    room = spec(t60=0.4)
    assert np.array_equal(respond(room, [0.1, 0.2, 0.3])[1], respond(room, [0.2])[0])


def test_a_room_that_was_heard_before_sounds_as_one_that_is_new():
    room, other = spec(t60=0.4), spec(t60=0.3)
    first = respond(room, [0.2, 0.7])
    for place in (room, other):
        respond(place, [1.0])
    assert np.array_equal(respond(room, [0.7])[0], first[1])


def test_no_source_gives_no_response():
    assert respond(spec(sources=()), [0.0, 1.0]).shape[:3] == (2, 2, 0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sources": ((11.0, 5.0),)}, "source 0: expected a place inside the room of 10 x 10 m, got 11 x 5 m"),
        (
            {"sources": ((7.0, 5.0), (5.1, 5.0))},
            "source 1: expected at least 0.2 m from the centre of the array, got 0.10 m",
        ),
        ({"sources": ((7.0, 5.0, 1.0),)}, "source 0: expected 2 coordinates"),
        ({"array_centre": (0.01, 5.0)}, "the array: expected a place inside the room"),
        ({"spacing": 0.0}, "spacing: expected more than 0 and less than 0.4 m, got 0 m"),
        ({"t60": -1.0}, "t60: expected at least 0, got -1"),
        ({"t60": math.nan}, "t60: expected at least 0, got nan"),
        ({"rate": 0}, "rate: expected a positive rate, got 0"),
        ({"size": (10.0,)}, "two or three positive sides"),
        ({"sources": ((math.nan, 5.0),)}, "inside the room"),
    ],
)
def test_impossible_room_is_refused_in_words(changes, message):
    with pytest.raises(ConfigError, match=message):
        spec(**changes)


def test_t60_too_short_for_any_wall_is_refused():
    with pytest.raises(ConfigError, match="too short for a room"):
        spec(t60=0.01)


def test_responses_come_back_from_disk_unchanged(tmp_path):
    first = Responses(spec(), tmp_path).at(0.3)
    again = Responses(spec(), tmp_path).at(0.3)
    assert np.array_equal(first, respond(spec(), [0.3])[0])
    assert np.array_equal(first, again)


def test_headings_a_whole_turn_apart_are_one_file(tmp_path):
    responses = Responses(spec(), tmp_path)
    responses.at(-0.5)
    responses.at(2 * math.pi - 0.5)
    assert len(list(tmp_path.rglob("*.npz"))) == 1


def test_another_room_is_another_folder(tmp_path):
    Responses(spec(), tmp_path).at(0.0)
    Responses(spec(spacing=0.06), tmp_path).at(0.0)
    assert len(list((tmp_path / "rooms").iterdir())) == 2


def _halve(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _empty(path):
    path.write_bytes(b"")


def _garble(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(bytes(content))


@pytest.mark.parametrize("damage", [_halve, _empty, _garble])
def test_damaged_file_is_made_again(tmp_path, damage):
    whole = Responses(spec(), tmp_path).at(0.3)
    (path,) = tmp_path.rglob("*.npz")
    damage(path)
    assert np.array_equal(Responses(spec(), tmp_path).at(0.3), whole)
    with np.load(path) as mended:
        assert np.array_equal(mended["responses"], whole)


def test_what_is_used_was_read_back(tmp_path):
    made = []

    def make():
        made.append({"numbers": np.arange(3)})
        return made[0]

    found = cached(tmp_path / "a.npz", make)
    assert np.array_equal(found["numbers"], np.arange(3))
    assert found["numbers"] is not made[0]["numbers"]


def test_failed_maker_leaves_nothing_behind(tmp_path):
    def fail():
        raise RuntimeError("no")

    with pytest.raises(RuntimeError):
        cached(tmp_path / "a.npz", fail)
    assert list(tmp_path.iterdir()) == []


def test_cache_that_cannot_be_written_says_so(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ConfigError, match="set ROSS_CACHE"):
        Responses(spec(), tmp_path / "file").at(0.0)


def test_two_processes_may_fill_one_cache(tmp_path):
    program = (
        "import sys\nfrom pathlib import Path\nfrom ross_sim.acoustics.impulse_responses import Responses\n"
        "from ross_sim.acoustics.room import RoomSpec\n"
        "room = RoomSpec((10.0, 10.0), 0.4, 16000, (5.0, 5.0), 0.05, ((7.0, 5.0),))\n"
        "[Responses(room, Path(sys.argv[1])).at(0.1 * i) for i in range(20)]"
    )
    writers = [subprocess.Popen([sys.executable, "-c", program, str(tmp_path)]) for _ in range(2)]
    assert [writer.wait(60) for writer in writers] == [0, 0]
    room = spec(t60=0.4)
    files = list(tmp_path.rglob("*"))
    assert not [path for path in files if ".part" in path.name]
    assert len([path for path in files if path.suffix == ".npz"]) == 20
    assert np.array_equal(Responses(room, tmp_path).at(0.7), respond(room, [0.7])[0])


def test_cache_folder_follows_the_environment(monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", "/a")
    monkeypatch.delenv("ROSS_CACHE", raising=False)
    assert cache_folder() == Path("/a/ross")
    monkeypatch.setenv("ROSS_CACHE", "/b")
    assert cache_folder() == Path("/b")
    assert cache_folder(Path("/c")) == Path("/c")


def test_a_room_that_the_memory_cannot_hold_is_refused_in_one_line(monkeypatch):
    def full(_):
        raise MemoryError("std::bad_alloc")

    monkeypatch.setattr("pyroomacoustics.ShoeBox.image_source_model", full)
    with pytest.raises(
        ConfigError, match=r"^t60 = 1 s in a room of 10 x 9 m: its reflections do not fit into the memory"
    ):
        respond(spec(size=(10.0, 9.0), t60=1.0), [0.0])
