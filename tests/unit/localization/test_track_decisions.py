"""What follows from tracks while the mission listens: who has moved, whose track is lost, and when the array turns."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.localization import tracking
from ross_payload.localization.talker_motion import RATES, around
from ross_payload.mission.source_tracking import AGAIN, DWELL, SHORT, UPDATE, SourceTracker
from ross_payload.pointing import Pointing

SPACING, SPEED = 0.05, 343.0
LASTING = 2  # corrections that must say so: half a second, half of it where the delay has changed by far
FAR = 9.0  # a limit of the joint that limits nothing [rad]


def estimate(*degrees, sigma=0.01):
    sources = tuple(SourceEstimate(math.radians(azimuth), sigma, 0.9, resolved=True) for azimuth in degrees)
    return Estimate(sources, certain=True, directness=1.0)


def tracker_of(*degrees, now=None, sigma=0.01):
    """A tracker of sources that were explored at azimuths [deg] and are tracked at others, all heard just now."""
    tracker = SourceTracker(estimate(*degrees), 0, Stft(16000, 1024, 256), SPACING, SPEED, None, None)
    there = estimate(*(now or degrees), sigma=sigma)
    tracker.tracks = tracking.begin(there, SPACING, SPEED)
    return tracker


def test_the_sigma_of_a_track_has_no_nominal_one_of_the_exploration():
    explored = estimate(30, 120)
    wide = replace(explored, sources=tuple(replace(each, nominal_sigma=1e-3) for each in explored.sources))
    tracker = SourceTracker(wide, 0, Stft(16000, 1024, 256), SPACING, SPEED, None, None)
    assert [source.nominal for source in tracker.estimate.sources] == tracker.tracks.sigmas.tolist()


def turn(tracker, *, joint=0.0, base=0.0, lower=-FAR, upper=FAR, time=10.0):
    """To which joint angle the array is to turn [deg], None: it stays."""
    here = Pointing(joint=math.radians(joint), base=math.radians(base))
    heading = tracker.heading_for(time, here, lower, upper, settled=True)
    return None if heading is None else math.degrees(heading) - base


def test_two_sources_with_one_delay_are_parted_by_the_longest_short_turn():
    tracker = tracker_of(40, -40)
    tracker.moved = [True, False]
    assert abs(turn(tracker)) == pytest.approx(math.degrees(SHORT))


@pytest.mark.parametrize("base", [0.0, 70.0])
def test_no_turn_goes_beyond_the_limits_of_the_joint(base):
    def turned(lower, upper):
        tracker = tracker_of(base + 40, base - 40)
        tracker.moved = [True, False]
        return turn(tracker, base=base, lower=lower, upper=upper)

    near = math.radians(10.0)
    assert turned(-FAR, near) == pytest.approx(-30.0)
    assert turned(-near, FAR) == pytest.approx(30.0)
    assert abs(turned(-near, near)) == pytest.approx(10.0)


def test_where_hardly_anything_is_gained_the_array_stays():
    tracker = tracker_of(40, -40)
    tracker.moved = [True, False]
    assert turn(tracker, joint=60.0) is None


def test_nothing_turns_before_somebody_has_moved():
    still, stirred = tracker_of(40, -40), tracker_of(40, -40)
    assert turn(still) is None
    stirred.stirred = True  # it is not known who
    assert turn(stirred) is not None


def test_the_array_turns_to_look_when_it_is_not_known_whether_somebody_has_moved():
    """Source 0 is 15 degrees off the axis and unclear: from there it can walk far with hardly another delay."""
    clear, unclear = tracker_of(15, 120), tracker_of(15, 120, sigma=math.radians(9.0))
    assert turn(clear) is None
    heading = turn(unclear)
    assert heading is not None
    assert abs(math.sin(math.radians(15 - heading))) > 2 * math.sin(math.radians(15))


@pytest.mark.parametrize("rested", [0.0, 20.0])
def test_a_look_comes_the_later_the_longer_all_have_rested(rested):
    """Heard from 10 s on; the last turn ended at 20 s."""
    tracker = tracker_of(15, 120, sigma=math.radians(9.0))
    tracker.rested, tracker._began = rested, 10.0
    tracker.heading_for(20.0, Pointing(), -FAR, FAR, settled=False)
    waited = next(seconds for seconds in np.arange(0.0, 20.0, 0.25) if turns_after(tracker, 20.0 + seconds))
    assert waited == pytest.approx(AGAIN * (rested + 10.0 + waited), abs=0.25)
    tracker.turned, tracker.stirred = 20.0, True
    assert turns_after(tracker, 20.0 + DWELL), "somebody has moved"


def turns_after(tracker, time):
    tracker._planned = -1
    return turn(tracker, time=time) is not None


def test_a_track_is_told_for_the_present_and_not_for_the_middle_of_what_was_heard():
    tracker = tracker_of(100, -60, now=(130, -60))
    still = tracker.tracks.hypotheses[0]
    place = around(math.radians(130), math.radians(2))
    walks = np.outer(np.arange(len(RATES)) == np.abs(RATES - math.radians(9.5)).argmin(), place)
    tracker.tracks = replace(tracker.tracks, hypotheses=(replace(still, left={0: walks}),))
    tracker.moved = [True, False]
    assert tracker.behind == pytest.approx((UPDATE + 1024 / 16000) / 2)
    assert math.degrees(tracker.azimuths[0]) == pytest.approx(130 + 9.5 * tracker.behind, abs=0.3)


def test_between_two_turns_the_array_rests():
    tracker = tracker_of(40, -40)
    tracker.moved = [True, False]
    assert tracker.heading_for(10.0, Pointing(), -FAR, FAR, settled=False) is None
    assert turn(tracker, time=10.0 + 0.9 * DWELL) is None
    assert turn(tracker, time=10.0 + 1.1 * DWELL) is not None


@pytest.mark.parametrize(("sigma_deg", "lost"), [(15.0, False), (45.0, True)])
def test_a_track_is_lost_when_it_is_not_known_any_more_where_the_source_is(sigma_deg, lost):
    tracker = tracker_of(40, -40, sigma=math.radians(sigma_deg))
    assert not tracker.lost, "nobody has moved: the exploration holds"
    tracker.moved = [False, True]
    assert tracker.lost is lost


@pytest.mark.parametrize(("azimuth", "corrections"), [(108.5, LASTING), (111, 1), (140, 1)])
def test_who_has_left_for_long_has_moved_and_not_before(azimuth, corrections):
    tracker = tracker_of(100, -60, now=(azimuth, -60))
    seen = []
    for step in range(corrections + 1):
        tracker.corrected(UPDATE * step)
        seen.append(tuple(tracker.moved))
    assert seen == [(False, False)] * (corrections - 1) + [(True, False)] * 2
    assert tracker.azimuths == pytest.approx(np.radians([azimuth, -60]), abs=0.02)


def test_what_reflections_may_do_to_a_delay_is_no_move():
    """23 degrees away at broadside: beyond what echoes do in the open, not where they draw delays to 0 by a fifth."""
    open_air = tracker_of(90, -150, now=(113, -150))
    room = tracker_of(90, -150, now=(113, -150))
    room.tracks = replace(room.tracks, wet=True, amplitude=0.6)
    for tracker in (open_air, room):
        for step in range(2 * LASTING):
            tracker.corrected(10.0 + step * UPDATE)
    assert open_air.moved == [True, False]
    assert room.moved == [False, False]


def test_who_is_silent_has_not_moved_however_likely_it_is():
    tracker = tracker_of(100, -60, now=(140, -60))
    tracker.tracks = replace(tracker.tracks, ages=np.array([2.0, 0.0]))
    for step in range(3 * LASTING):
        tracker.corrected(UPDATE * step)
    assert tracker.moved == [False, False]


def test_when_all_turn_out_to_be_shifted_alike_nobody_has_moved():
    tracker = tracker_of(100, -60, now=(112, -48))
    tracker.moved, tracker.stirred = [True, False], True
    tracker.corrected(1.0)
    assert (tracker.moved, tracker.stirred) == ([False, False], False)


def mirrored(sigma_deg):
    """Source 0 is in the mirror image of its place in the axis, at 120 degrees: its delay has not changed."""
    tracker = tracker_of(100, -60)
    there = tracking.begin(estimate(140, -60, sigma=math.radians(sigma_deg)), SPACING, SPEED)
    tracker.tracks = replace(there, heading=math.radians(120))
    return tracker


@pytest.mark.parametrize(("sigma_deg", "moved"), [(10.0, True), (25.0, False)])
def test_who_has_the_delay_of_its_place_has_moved_where_it_is_clear_that_it_is_elsewhere(sigma_deg, moved):
    tracker = mirrored(sigma_deg)
    for step in range(LASTING):
        assert tracker.moved == [False, False]
        tracker.corrected(UPDATE * step)
    assert tracker.moved == [moved, False]


@pytest.mark.parametrize(("now", "moved"), [(121, False), (140, True)])
def test_a_delay_that_is_as_long_as_on_the_axis_is_no_move(now, moved):
    """At 105 degrees, 15 from the axis, a room draws the delay to 0 a little less than was told of it."""
    tracker = tracker_of(105, 20)
    there = tracking.begin(estimate(now, 20, sigma=math.radians(3.0)), SPACING, SPEED)
    tracker.tracks = replace(there, heading=math.radians(120))
    for step in range(3 * LASTING):
        tracker.corrected(UPDATE * step)
    assert tracker.moved == [moved, False]


def test_who_may_be_on_either_side_of_the_axis_has_not_moved():
    tracker = mirrored(2.0)
    sides = [tracking.begin(estimate(azimuth, -60), SPACING, SPEED).home_densities[0] for azimuth in (100, 140)]
    walks = np.outer(np.arange(len(RATES)) == 8, 0.2 * sides[0] + 0.8 * sides[1])
    still = tracker.tracks.hypotheses[0]
    tracker.tracks = replace(tracker.tracks, hypotheses=(replace(still, left={0: walks}),))
    for step in range(3 * LASTING):
        tracker.corrected(UPDATE * step)
    assert math.degrees(tracker.tracks.azimuths[0]) == pytest.approx(140, abs=1)
    assert tracker.moved == [False, False]
