"""How high the array is above those who talk: what it bounds, what it lets the explorer find, and who is told."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from recording_bench import input_of
from ross_payload.config import Config, load
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Attitude, Input, Observation
from ross_payload.localization import below, itd_mixture, model_order
from ross_payload.localization.joint import Joint, height_of
from ross_payload.sessions import input_log
from ross_sim.study.above_study import observed
from ross_sim.study.scenes import above_scenes
from ross_sim.study.scenes.above_scenes import AboveScene, scene
from ross_sim.study.scenes.exploration import matched
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND

JOINT = Joint(SPACING, SPEED_OF_SOUND)
HEADINGS, GRID = np.deg2rad(15.0) * np.arange(9), np.linspace(-1.5, 1.5, 61)


def bursts(seed: int) -> np.ndarray:
    """Noise in syllables with pauses, as long as nothing repeats."""
    rng = np.random.default_rng(seed)
    syllables = np.repeat(rng.exponential(size=300) * (rng.random(300) < 0.5), 1600)
    return (rng.standard_normal(syllables.size) * syllables).astype(np.float32)


VOICES = [bursts(seed) for seed in range(3)]


@pytest.fixture(scope="module")
def below_20_m() -> tuple[AboveScene, list[Observation]]:
    """Two who stand 20 m below an array, 3 to 8 m from the point below it, and nothing but the noise of microphones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(above_scenes, "noise_of", lambda *_: None)  # nobody hears it without a ratio, but it is made
        made = scene(2, 20.0, None, VOICES, key=[1, 2, 0])
    return made, observed(made)


# ------------------------------------------------------------------------------------------------ what it bounds


def test_nobody_on_the_ground_is_nearer_to_the_horizon_than_who_is_just_still_heard() -> None:
    """30 m above the mouths and 60 m away: 30 degrees below, by the sine."""
    least, greatest = below.amplitudes(30.0)
    assert greatest == pytest.approx(math.cos(math.radians(30)))
    assert least == pytest.approx(math.cos(below.STEEPEST))
    assert below.amplitudes(500.0)[1] > least  # higher than anybody is heard from: still a range


@pytest.mark.parametrize("degrees", [10.0, 45.0, 80.0])
def test_an_elevation_is_that_of_its_cosine_and_below(degrees: float) -> None:
    angle, sigma = below.elevation(math.cos(math.radians(degrees)), 0.01)
    assert math.degrees(angle) == pytest.approx(-degrees)
    assert sigma == pytest.approx(0.01 / math.sin(math.radians(degrees)), rel=0.2)


def test_the_height_is_the_median_where_most_headings_have_one_and_none_near_the_ground() -> None:
    one = Observation(0.0, GRID, np.zeros_like(GRID), 0.0)
    assert height_of([replace(one, height=height) for height in (20.0, 90.0, 22.0)]) == 22.0
    assert height_of([replace(one, height=height) for height in (20.0, None, None, 22.0)]) is None
    assert height_of([replace(one, height=0.5)] * 3) is None


# ------------------------------------------------------------------------------------------------ what it lets find


def test_who_is_far_below_is_found_by_one_who_knows_the_height_and_by_no_other(
    below_20_m: tuple[AboveScene, list[Observation]],
) -> None:
    made, seen = below_20_m
    azimuths, elevations = made.walks.azimuths(0.0), made.walks.elevations(0.0)
    assert np.rad2deg(elevations).max() < -66  # amplitudes of 0.4 or less: short of what is looked for elsewhere
    knowing = JOINT.estimate([replace(each, height=20.0) for each in seen])
    assert knowing.k == 2
    errors, _ = matched(azimuths, knowing)
    assert np.asarray(errors).max() < 6  # at an amplitude of 0.16 delays are six times shorter than at the horizon
    told = {round(source.azimuth, 9): source.elevation for source in knowing.sources}
    for azimuth, elevation in zip(azimuths, elevations, strict=True):
        nearest = min(told, key=lambda each: abs(np.angle(np.exp(1j * (each - azimuth)))))
        assert told[nearest] == pytest.approx(elevation, abs=math.radians(2))
    guessing = JOINT.estimate(seen)
    found = [source.elevation or 0.0 for source in guessing.sources]
    assert guessing.k != 2 or min(np.abs(np.subtract.outer(found, elevations)).max(axis=0)) > math.radians(10)


def test_at_the_height_of_the_talkers_nothing_changes(below_20_m: tuple[AboveScene, list[Observation]]) -> None:
    _, seen = below_20_m
    assert JOINT.estimate([replace(each, height=1.0) for each in seen]) == JOINT.estimate(seen)


def test_a_steep_source_is_reached_by_the_mixture_only_where_amplitudes_may_be_small() -> None:
    truth = itd_mixture.Mixture(np.array([0.7]), np.array([0.2]), np.array([0.06]), np.tile([0.9, 0.05, 0.05], (9, 1)))
    plain = itd_mixture.Data(GRID, HEADINGS, np.zeros((9, GRID.size)))
    counts = 50 * itd_mixture.densities(plain, truth)
    steep = itd_mixture.Data(GRID, HEADINGS, counts, below.amplitudes(20.0), below.ALIKE)
    level = itd_mixture.Data(GRID, HEADINGS, counts)
    reached, missed = (model_order.search(data, model_order.Penalty(), 1) for data in (steep, level))
    assert reached is not None
    assert reached.model.amplitudes[0] == pytest.approx(0.2, abs=0.02)
    assert reached.model.azimuths[0] == pytest.approx(0.7, abs=0.05)
    assert missed is None or missed.model.amplitudes[0] >= itd_mixture.AMPLITUDE[0]


# ------------------------------------------------------------------------------------------------ who is told


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("height_m = -1", "mount.height_m"),
        ("height_m = 501", "mount.height_m"),
        ("height_m = nan", "mount.height_m"),
        ("height_m = 'high'", "mount.height_m"),
        ("height_m = 'autopilot'", "expected source = 'autopilot' beside it, got 'fixed'"),
    ],
)
def test_a_height_that_cannot_be_is_refused_in_one_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "ross.toml"
    path.write_text(f"[mount]\n{text}\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=said) as refused:
        load(path)
    assert "\n" not in str(refused.value)


def test_a_height_is_a_number_or_the_autopilots_or_unknown() -> None:
    assert Config().mount.height_m is None
    assert Config.model_validate({"mount": {"height_m": 12}}).mount.height_m == 12.0
    autopilots = Config.model_validate({"mount": {"source": "autopilot", "height_m": "autopilot"}})
    assert autopilots.mount.height_m == "autopilot"


def hop(height: float | None) -> Input:
    return input_of(0, attitude=Attitude(0.3, 0.01, -0.02, 0.001, 0.04, True, height))


def test_a_log_holds_the_height_and_without_one_is_as_it_always_was() -> None:
    low, high = hop(None), hop(17.5)
    written = input_log.line(high)
    assert input_log.input_of(input_log.parsed(written.encode()), high.block.samples, None).attitude == high.attitude
    without = json.loads(input_log.line(low))
    assert "height" not in without
    assert len(without["attitude"]) == 6
    assert without == {name: value for name, value in json.loads(written).items() if name != "height"}
    assert input_log.input_of(without, low.block.samples, None).attitude == low.attitude


def test_a_line_whose_height_is_no_number_is_damaged() -> None:
    broken = json.loads(input_log.line(hop(17.5))) | {"height": "high"}
    assert input_log.parsed((json.dumps(broken) + "\n").encode()) is None


def test_two_at_one_azimuth_are_two_when_one_is_further_below() -> None:
    centres = np.array([0.4, 0.95])[:, None, None] * np.cos(0.7 - HEADINGS)[:, None]
    kernels = np.exp(-0.5 * ((GRID - centres) / 0.05) ** 2)
    counts = 20 * (kernels / kernels.sum(axis=-1, keepdims=True)).sum(axis=0) + 0.01
    data = itd_mixture.Data(GRID, HEADINGS, counts, below.amplitudes(10.0), below.ALIKE)
    largest = next(model_order.steps(data, model_order.Penalty())).model
    np.testing.assert_allclose(np.sort(largest.amplitudes), [0.4, 0.95], atol=0.03)
    np.testing.assert_allclose(largest.azimuths, 0.7, atol=0.01)
