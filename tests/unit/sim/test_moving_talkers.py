"""Talkers on a path: what is heard of them, and what a scenario says of it."""

import math
from itertools import pairwise

import numpy as np
import pytest

from examples import in_soak
from ross_payload.errors import ConfigError
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.moving_talker import MixedTalkers, MovingTalker
from ross_sim.acoustics.render import Microphones, TalkerSignals
from ross_sim.acoustics.room import n_taps, respond
from ross_sim.live_world.world_session import later
from ross_sim.scenario import Scenario, load
from ross_sim.talkers.path import GRID, Path
from ross_sim.talkers.timeline import Timeline

RATE, QUANTUM, SPACING = 16000, 160, 0.05


def scenario(t60=0.0, path=((1.0, 20.0), (2.0, 30.0)), **talker):
    points = [{"at_s": at, "azimuth_deg": azimuth} for at, azimuth in path]
    return Scenario.model_validate(
        {
            "title": "walk",
            "payload": {"audio": {"rate_hz": RATE}},
            "room": {"size_m": (10.0, 10.0), "t60_s": t60},
            "talkers": [{"azimuth_deg": 20.0, "path": points, **talker}, {"azimuth_deg": -70.0}],
        }
    )


def noise(seconds=3):
    return np.random.default_rng(1).standard_normal(seconds * RATE).astype(np.float32)


def tone(seconds=3):
    return np.sin(2 * np.pi * 200 * np.arange(seconds * RATE) / RATE).astype(np.float32)


def moving(staged, speech):
    walk = staged.walks()[0]
    said, taps = Timeline.of(speech, RATE), n_taps(staged.spec_of(walk))
    return MovingTalker(said, 1.0, walk, lambda node: staged.spec_of(walk, node), n_taps=taps, rate=RATE)


def hear(talker, seconds, heading=0.3):
    ears = Microphones(talker, SPACING, heading)
    parts = [ears.render(k * QUANTUM, (k + 1) * QUANTUM, heading, heading) for k in range(round(seconds * 100))]
    return np.concatenate(parts, axis=-1)


@pytest.mark.parametrize("t60", [0.0, *in_soak(0.4)])
def test_a_talker_who_has_arrived_is_heard_through_the_response_of_that_place(t60):
    staged, speech = scenario(t60), noise()
    heard = hear(moving(staged, speech), 3.0)
    walk = staged.walks()[0]
    dry = Timeline.of(speech, RATE).between(0, heard.shape[-1]).astype(float)
    for node, samples in ((0, slice(0, RATE)), (walk.n_nodes - 1, slice(2 * RATE, None))):
        (response,) = respond(staged.spec_of(walk, node), [0.3])
        truth = np.array([np.convolve(dry, taps[0])[: dry.size] for taps in response])
        assert np.abs(heard[:, 0] - truth)[:, samples].max() < 1e-5 * np.abs(truth).max()


@pytest.mark.parametrize("t60", [0.0, *in_soak(0.4)])
def test_walking_does_not_click(t60):
    heard = hear(moving(scenario(t60, path=((1.0, 20.0), (2.0, 50.0))), tone()), 2.5)[:, 0, RATE // 2 :]
    bend = np.abs(np.diff(heard, n=2, axis=-1)).max(axis=0)
    assert bend[RATE // 2 : 3 * RATE // 2].max() < 1.3 * bend[: RATE // 2 - QUANTUM].max()


def test_the_delay_follows_the_path():
    staged = scenario(path=((1.0, 20.0), (2.0, 90.0)))
    heard = hear(moving(staged, noise()), 2.4, heading=math.radians(20.0))[:, 0]
    for middle in (0.5, 1.5, 2.2):
        piece = slice(round((middle - 0.05) * RATE), round((middle + 0.05) * RATE))
        spectra = np.fft.rfft(heard[:, piece] * np.hanning(piece.stop - piece.start))
        band = np.arange(spectra.shape[1]) * RATE / (piece.stop - piece.start)
        use = (band > 500) & (band < 3000)
        phase = np.angle(spectra[1, use] * spectra[0, use].conj())
        delay = np.sum(phase * band[use]) / np.sum(2 * np.pi * band[use] ** 2)
        azimuth = staged.azimuths_at(np.array([middle]))[0, 0]
        assert delay == pytest.approx(SPACING / 343 * math.cos(azimuth - math.radians(20.0)), abs=4e-6)


def test_talkers_at_rest_and_walking_keep_their_order():
    staged = scenario()
    walking = moving(staged, tone())

    class Resting:
        def at(self, heading, first, last):
            return np.stack([np.full((2, last - first), value, np.float32) for value in (7, 8)], axis=1)

    heard = MixedTalkers(Resting(), [walking, walking], [0, 2]).at(0.0, 0, 1600)
    assert heard.shape == (2, 4, 1600)
    assert (heard[:, 1] == 7).all()
    assert (heard[:, 3] == 8).all()
    assert np.array_equal(heard[:, 0], walking.at(0.0, 0, 1600)[:, 0])


def test_a_sample_does_not_depend_on_how_it_is_asked_for():
    staged, speech = scenario(), noise()
    whole = moving(staged, speech).at(0.1, RATE, 2 * RATE)
    halves = moving(staged, speech)
    parts = [halves.at(0.1, first, first + RATE // 2) for first in (RATE + RATE // 2, RATE)]
    assert np.array_equal(np.concatenate(parts[::-1], axis=-1), whole)


def test_positions_on_the_grid_are_the_same_on_the_way_back():
    staged = scenario(path=((1.0, 20.0), (2.0, 30.0), (5.0, 30.0), (7.0, 20.0)))
    walk = staged.walks()[0]
    places = [staged.spec_of(walk, node).sources[0] for node in range(walk.n_nodes)]
    assert places == places[::-1]
    assert max(math.dist(one, other) for one, other in pairwise(places)) <= GRID + 1e-6


def test_who_stays_has_one_position_and_does_not_move():
    walk = scenario().walks()[1]
    assert (walk.moves, walk.n_nodes) == (False, 1)
    assert walk.place([0.0, 99.0])[:, 0].tolist() == [math.radians(-70.0)] * 2


@pytest.mark.parametrize(
    ("path", "talker", "complaint"),
    [
        (((2.0, 20.0), (1.0, 30.0)), {}, "path: expected at_s to rise, got 1 after 2"),
        (((1.0, 200.0),), {"distance_m": 4.995}, "expected a place inside the room"),
        (((0.0, 30.0),), {}, "greater than 0"),
    ],
)
def test_an_impossible_path_is_refused(path, talker, complaint):
    with pytest.raises(ValueError, match=complaint):
        scenario(path=path, **talker)


def test_a_height_needs_a_room_with_three_sides(tmp_path):
    text = 'title = "x"\n[[talkers]]\nazimuth_deg = 1\npath = [{ at_s = 1, azimuth_deg = 2, height_m = 1.0 }]\n'
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(ConfigError, match="three sides"):
        load(tmp_path / "x.toml")


def test_a_world_that_begins_later_walks_later():
    staged = scenario()
    delayed = later(staged, 5.0).walks()[0]
    times = np.linspace(0, 4, 41)
    assert np.allclose(delayed.place(times + 5.0), staged.walks()[0].place(times))
    assert later(staged, 5.0).walks()[1].moves is False


def test_a_scenario_without_paths_is_told_as_before():
    assert "path" not in load("demo").talkers[0].model_dump(mode="json")
    assert len(load("walker").model_dump(mode="json")["talkers"][2]["path"]) == 5


def test_a_walk_of_two_turns_is_not_wrapped():
    walk = Path.through([(0.0, 0.0, 1.0, 0.0), (10.0, 4 * math.pi, 1.0, 0.0)])
    assert walk.place(7.5)[0] == pytest.approx(3 * math.pi)


def test_signals_of_one_place_are_those_of_a_talker_at_rest(tmp_path):
    """A path that leads nowhere sounds as no path does."""
    staged = scenario(path=((1.0, 20.0), (2.0, 20.0)))
    speech = noise()
    spec = staged.spec_of(staged.walks()[0])
    still = TalkerSignals([Timeline.of(speech, RATE)], [1.0], Responses(spec, tmp_path), RATE)
    assert np.allclose(moving(staged, speech).at(0.2, 0, RATE), still.at(0.2, 0, RATE), atol=1e-6)
