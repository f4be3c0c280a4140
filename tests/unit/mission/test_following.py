"""A vehicle that yaws is followed: by the Outputs for given Inputs; the rig is that of mission_bench."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import mission_bench as base
from examples import in_soak
from ross_payload.actuators.motion import Trapezoid
from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.angles import wrap, wrap_axis
from ross_payload.events import Checked, Doubted, OrientationHeard, Outcome, Separated, SourcesEstimated, TurnStarted
from ross_payload.interfaces import Attitude
from ross_payload.mission.heading_control import Follower
from ross_payload.pointing import Pointing
from ross_sim.autopilot.yaw import Yaw

DT = base.HOP / base.RATE  # [s]
STILL = Yaw()
SWINGING = Yaw(mean=0.3, amplitude=np.deg2rad(15), speed=np.deg2rad(10))
ALWAYS = ((0.0, np.inf),)


@dataclass
class Vehicle(base.Rig):
    """A turntable of the paper's acceleration on a vehicle that yaws; its attitude is known at some times."""

    yaw: Yaw = SWINGING
    known: tuple = ALWAYS
    plan: Trapezoid = field(default_factory=lambda: Trapezoid(0.0, 0.0, 3.9, 1.96))
    since: float = 0.0
    inputs: list = field(default_factory=list)

    def _obey(self, output):
        self.outputs.append(output)
        self.events += output.events
        if output.goal is not None:
            now = self.hops * DT
            place, speed = self.plan.at(now - self.since)
            self.plan, self.since = Trapezoid(place, output.goal, 3.9, 1.96, speed), now

    def _hear(self):
        begin, end = self.hops * DT, (self.hops + 1) * DT
        heard = super()._hear()
        known = any(first <= begin < last for first, last in self.known)
        yaws = [self.yaw.at(time) if known else 0.0 for time in (begin, end)]
        joints = [self.plan.at(time - self.since)[0] for time in (begin, end)]
        settled = self.outputs[-1].goal is None and begin >= self.since + self.plan.duration
        start = yaws[0] + joints[0]
        attitude = Attitude(yaws[0], known=known)
        rate = wrap(self.yaw.at(end) - self.yaw.at(end - 0.1)) / 0.1 if known else 0.0
        pointing = Pointing(end, joints[1], yaws[1], earth=known, base_rate=rate)
        heard = replace(heard, heading_start=start, pointing=pointing, settled=settled)
        self.inputs.append(replace(heard, attitude=attitude))
        return self.inputs[-1]

    def heard_between(self, begin, end):
        return [heard for heard in self.inputs if begin - 1e-9 <= heard.block.time < end - 1e-9]


def vehicle(yaw=SWINGING, known=ALWAYS, settings=base.SETTINGS, **others):
    return Vehicle(base.rig(settings=settings, **others).brain, yaw=yaw, known=known)


def off(headings, wanted):
    return np.rad2deg([abs(wrap_axis(heading - wanted)) for heading in headings])


# ------------------------------------------------------------------------------------------------ headings


def test_on_a_vehicle_at_rest_nothing_is_corrected():
    """The same Outputs as on a fixed mount: one goal for every turn, in the same hops."""
    one, plain = vehicle(yaw=STILL), vehicle(yaw=STILL, known=())
    assert one.run() == plain.run()
    assert [output.goal for output in one.outputs] == [output.goal for output in plain.outputs]
    goals = [output.goal for output in one.outputs if output.goal is not None]
    assert len(goals) == len(one.said(TurnStarted))


def test_the_exploration_steps_by_headings_and_not_by_joint_angles():
    one = vehicle(explorer=base.ThreeTalkers(certain=False))
    one.run()
    headings = np.array([event.heading for event in one.said(OrientationHeard)])
    steps = np.rad2deg(headings - headings[0])
    np.testing.assert_allclose(steps, [0, 15, 30, 45, 60], atol=2.0)


def test_a_yawing_vehicle_is_followed_while_listening():
    one = vehicle(settings=replace(base.SETTINGS, run=12.0))
    assert one.run().outcome is Outcome.TARGET_FOUND
    event = one.said(Separated)[-1]
    begin = event.start / base.RATE
    during = one.heard_between(begin, begin + 12.0)
    apart = off([heard.pointing.heading for heard in during], one.said(TurnStarted)[-1].heading)
    assert apart.max() < 4.0  # the joint's acceleration bounds it where the vehicle reverses
    assert np.sqrt(np.mean(apart**2)) < 1.5
    assert np.ptp([heard.pointing.joint for heard in during]) > np.deg2rad(25)  # the vehicle's 30 degrees


def test_a_run_that_is_followed_is_not_broken():
    """What is separated is one stretch of T_run, right up to its end."""
    one = vehicle()
    one.run()
    event = one.said(Separated)[-1]
    assert event.voices.shape[1] == 1.5 * base.RATE
    assert event.start + event.voices.shape[1] == round(event.time * base.RATE)


def test_what_is_told_as_the_heading_is_the_mean_of_what_was_heard():
    one = vehicle()
    one.run()
    for event in one.said(OrientationHeard):
        during = one.heard_between(event.time - base.SETTINGS.unit, event.time)
        true = np.mean([(heard.heading_start + heard.pointing.heading) / 2 for heard in during])
        assert event.heading == pytest.approx(true, abs=1e-4)  # a circular mean


def test_an_alignment_is_reached_although_the_actuator_never_settles():
    fast = replace(SWINGING, speed=np.deg2rad(20))
    one = vehicle(yaw=fast, planner=paper_plan)
    assert one.run().outcome is Outcome.TARGET_FOUND
    ended = one.said(Separated)[-1].time
    during = one.heard_between(ended - base.SETTINGS.run, ended)
    assert off([during[0].pointing.heading], one.said(Checked)[-1].candidate.heading)[0] < 2.5


def test_the_sources_stay_where_they_are_in_the_earth_frame():
    """Every listening period of a mission is near the heading that was faced, whenever it is visited."""
    one = vehicle(likes=7)  # nobody: all candidates are visited, one after the other
    one.run()
    for checked in one.said(Checked):
        during = one.heard_between(checked.time - base.SETTINGS.check, checked.time)
        mean = np.mean([heard.pointing.heading for heard in during])
        assert off([mean], checked.candidate.heading)[0] < 3.0


# ------------------------------------------------------------------------------------------------ limits


NARROW = {"lower": np.deg2rad(-100), "upper": np.deg2rad(100)}


@pytest.mark.parametrize("degrees", [89, *in_soak(80, 97)])
def test_near_a_limit_the_axis_is_turned_half_round_and_no_period_is_cut(degrees):
    """The vehicle drifts on, so a joint that stands near its limit cannot follow to the end."""
    away = Yaw(amplitude=np.deg2rad(170), speed=np.deg2rad(10))
    settings = replace(base.SETTINGS, run=10.0, **NARROW)
    one = vehicle(yaw=away, settings=settings)
    one.plan = Trapezoid(-np.deg2rad(degrees), -np.deg2rad(degrees), 3.9, 1.96)
    one.run()
    goals = [output.goal for output in one.outputs if output.goal is not None]
    assert all(settings.lower <= goal <= settings.upper for goal in goals)
    periods = [(event.time, settings.unit, event.heading) for event in one.said(OrientationHeard)]
    periods += [(event.time, settings.run, event.heading) for event in one.said(Separated)]
    for time, seconds, heading in periods:
        during = one.heard_between(time - seconds, time)
        assert len(during) == pytest.approx(seconds / DT, abs=1)
        assert off([heard.pointing.heading for heard in during], heading).max() < 8.0
    assert any("limit" in event.reason for event in one.said(TurnStarted))


def test_a_heading_that_no_limit_lets_through_is_faced_as_far_as_it_goes():
    """A travel of 20 degrees and a yaw of 30: the mission ends, no goal is outside, no period lasts for ever."""
    tight = replace(base.SETTINGS, lower=np.deg2rad(-10), upper=np.deg2rad(10))
    one = vehicle(settings=tight)
    one.run()
    goals = [output.goal for output in one.outputs if output.goal is not None]
    assert goals
    assert all(tight.lower <= goal <= tight.upper for goal in goals)


# ------------------------------------------------------------------------------------------------ frames


def test_an_attitude_that_is_lost_while_exploring_begins_the_exploration_again():
    one = vehicle(known=((0.0, 1.5),), explorer=base.ThreeTalkers(patience=1, certain=False))
    one.run()
    lost = one.said(Doubted)
    assert [event.reason for event in lost] == ["the vehicle's attitude is no longer known"]
    before = [event for event in one.said(OrientationHeard) if event.time < lost[0].time]
    after = [event for event in one.said(OrientationHeard) if event.time > lost[0].time]
    assert before
    assert [event.index for event in after] == [0, 1, 2, 3, 4]


def test_no_estimate_mixes_two_frames():
    """Between the first orientation of an estimate and its last one the frame is the same."""
    one = vehicle(known=((0.0, 1.2), (2.5, np.inf)))
    assert one.run().outcome is Outcome.TARGET_FOUND
    begin = 0.0
    for event in one.said(OrientationHeard):
        begin = event.time - base.SETTINGS.unit if event.index == 0 else begin
        frames = {heard.pointing.earth for heard in one.heard_between(begin, event.time)}
        assert len(frames) == 1
    assert len(one.said(Doubted)) == 2


def test_what_was_told_in_another_frame_is_explored_instead():
    told = base.ThreeTalkers(patience=1).estimate([None])
    one = vehicle(known=((0.0, 0.8),), informed=told)
    one.run()
    assert [event.informed for event in one.said(SourcesEstimated)][:2] == [True, False]
    assert len(one.said(Doubted)) == 1


def test_an_attitude_that_comes_and_goes_for_ever_ends_the_mission_with_the_reason():
    flicker = tuple((second, second + 0.5) for second in range(100))
    result = vehicle(known=flicker).run()
    assert result.outcome is Outcome.FAULT
    assert "attitude" in result.reason


def test_attitude_found_before_anything_turns_costs_nothing():
    one = vehicle(known=((0.05, np.inf),))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert not one.said(Doubted)


# ------------------------------------------------------------------------------------------------ the law


def held(tolerance_deg, seconds=24.0):
    """Rms of the heading's error [deg] and goals a second, for a joint of the paper's acceleration."""
    follower = Follower(0.0, 0.0, np.deg2rad(tolerance_deg), -np.inf, np.inf)
    plan, since, errors, goals = Trapezoid(0.0, 0.0, 3.9, 1.96), 0.0, [], 0
    swing = replace(SWINGING, mean=0.0)
    for time in np.arange(0.0, seconds, DT):
        joint = plan.at(time - since)[0]
        errors.append(swing.at(time) + joint)
        rate = (swing.at(time) - swing.at(time - 0.1)) / 0.1
        follower.update(time, Pointing(time, joint, swing.at(time), base_rate=rate))
        goal = follower.next_goal()
        if goal is not None:
            place, speed = plan.at(time - since)
            plan, since, goals = Trapezoid(place, goal, 3.9, 1.96, speed), time, goals + 1
    return float(np.rad2deg(np.std(errors[200:]))), goals / seconds


def test_the_joint_follows_fifteen_degrees_to_and_fro_within_one_degree_rms():
    error, goals = held(2.0)
    assert error < 1.0
    assert goals < 6


def test_a_wider_tolerance_moves_less_often():
    assert held(4.0)[1] < held(2.0)[1] < held(0.5)[1]


def test_a_yaw_that_passes_south_is_no_jump():
    follower = Follower(3.0, 0.0, 0.035, -4.0, 4.0)
    for time, yaw in enumerate((3.0, 3.1, 3.1 + 0.1 - 2 * np.pi)):
        follower.update(time * DT, Pointing(time * DT, follower.goal, yaw, base_rate=0.1 / DT))
        goal = follower.next_goal()
        assert goal is None or abs(goal) < 2.0


def test_a_vehicle_that_spins_faster_than_the_joint_does_not_hold_the_mission_up():
    spinning = Yaw(amplitude=np.deg2rad(3600), speed=np.deg2rad(400))
    settings = replace(base.SETTINGS, min_rotations=1, max_rotations=1)
    one = vehicle(yaw=spinning, explorer=base.ThreeTalkers(certain=False), settings=settings)
    one.run()
    assert len(one.said(OrientationHeard)) == 2
    assert one.hops * DT < 21 * len(one.said(TurnStarted)) + 30


@pytest.mark.parametrize("degrees", [0.1, 45])
def test_any_tolerance_of_the_configuration_ends_its_turns(degrees):
    one = vehicle(settings=replace(base.SETTINGS, follow=np.deg2rad(degrees)))
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert one.hops * DT < 30


def test_a_correction_stays_due_until_it_is_sent():
    """Also over the end of a listening period: the next one must not believe in a goal that nobody was given."""
    follower = Follower(0.0, 0.0, 0.035, -4.0, 4.0)
    follower.update(0.0, Pointing(base=0.1))
    follower.update(0.01, Pointing(base=0.1))
    assert not follower.there(10.0, Pointing(base=0.1), settled=False)
    assert follower.next_goal() == pytest.approx(-0.1)
    assert follower.next_goal() is None
