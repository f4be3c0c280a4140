"""How much a room draws delays to 0 is heard from talkers whose azimuths were told: theory makes the phases here."""

import math

import numpy as np
import pytest

from examples import in_soak
from heard_phases import SPACING, SPEED, STEP, phases
from ross_payload.angles import difference
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.localization import tracking
from ross_payload.localization.room_amplitude import HEARD, UNTOLD
from ross_payload.mission.source_tracking import SourceTracker

HEADING = 0.6  # [rad]
RESTING = (80.0, 320.0, 205.0)  # [deg]


def told(*degrees, directness=None):
    sources = (SourceEstimate(math.radians(a), math.radians(1.0), 1.0, resolved=True) for a in degrees)
    return Estimate(tuple(sources), certain=True, directness=directness)


def heard(anchor, amplitude, seconds, path=lambda time: RESTING, seed=0):
    """Let a tracker hear talkers at a path [deg] for so many seconds."""
    rng = np.random.default_rng(seed)
    tracker = SourceTracker(anchor, 0, Stft(16000, 1024, 256), SPACING, SPEED, None, None)
    for time in np.arange(STEP, seconds + STEP / 2, STEP):
        tracker.tracks = tracking.step(tracker.tracks, phases(path(time), HEADING, rng, amplitude=amplitude, wet=True))
        tracker.corrected(time)
    return tracker


@pytest.mark.parametrize("amplitude", [0.87, *in_soak(0.985, 0.77)])
def test_the_factor_of_a_room_is_heard_within_seconds(amplitude):
    found = heard(told(*RESTING), amplitude, HEARD[1]).tracks
    assert found.amplitude == pytest.approx(amplitude, abs=0.02)


@pytest.mark.parametrize("seed", in_soak(0, 1, 2))
def test_nobody_seems_to_move_in_a_room_that_nobody_has_explored(seed):
    tracker = heard(told(*RESTING), 0.77, 8.0, seed=seed)
    assert not tracker.acts


def test_once_it_is_known_it_stays():
    tracker = heard(told(*RESTING), 0.87, HEARD[1])
    assert tracker.tracks.room is None
    rng, before = np.random.default_rng(5), tracker.tracks
    after = tracking.step(before, phases(RESTING, HEADING, rng, amplitude=0.7, wet=True))
    assert after.amplitude == before.amplitude


def test_what_an_exploration_tells_of_the_room_is_believed():
    tracks = heard(told(*RESTING, directness=0.8), 0.77, 2.0).tracks
    assert tracks.amplitude == pytest.approx(1 - tracking.DRAWN * 0.2)


def test_somebody_alone_who_walks_is_not_taken_for_a_room():
    """To broadside: the delay falls as it would in a room with reflections."""
    tracker = heard(told(60.0), 1.0, 4.0, path=lambda time: (60.0 + 12 * time,))
    assert tracker.tracks.amplitude == UNTOLD
    assert tracker.acts


@pytest.mark.soak
def test_somebody_who_walks_beside_others_is_not_taken_for_a_room():
    tracker = heard(told(*RESTING), 1.0, 5.0, path=lambda time: (80.0 + 12 * time, *RESTING[1:]))
    assert tracker.tracks.amplitude > 0.95
    assert tracker.moved == [True, False, False]
    assert abs(difference(tracker.azimuths[0], math.radians(140.0))) < math.radians(10)
