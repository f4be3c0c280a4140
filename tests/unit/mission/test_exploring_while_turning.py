"""Exploring without a pause, seen from the mission: what the joint is told, what the explorer is, and how it ends.

The turntable is simulated here: it turns at the rate that it is told, at once, and is settled where it was sent.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from mission_bench import HOP, RATE, SETTINGS, Likes, OneGroupEach, Rig, ThreeTalkers
from ross_payload.alignment.plan import plan
from ross_payload.angles import wrap
from ross_payload.config import Config, validated
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError, PluginError
from ross_payload.events import (
    Checked,
    Doubted,
    OrientationHeard,
    Outcome,
    SourcesEstimated,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import Attitude, Observation
from ross_payload.mission.heard_turning import HeardTurning
from ross_payload.mission.mission_sequence import mission
from ross_payload.mission.settings import Tools
from ross_payload.mission.sweep import sweep_from
from ross_payload.orders import Stop
from ross_payload.pointing import Pointing
from ross_payload.service.assemble import settings_of, tools_of

RATE_RAD_S = np.deg2rad(60.0)
TURNING = replace(SETTINGS, turn_rate=RATE_RAD_S, periods=5)


@dataclass
class HearsTurning(ThreeTalkers):
    """An explorer that writes down at which headings it was told to have heard."""

    swept: list = field(default_factory=list)

    def observe_turning(self, spectrogram, frequencies, headings, noise_psd, *, frame_period=None, skip=0):
        assert spectrogram.shape[-1] == len(headings)
        self.swept.append(headings[skip:])
        return Observation(float(headings.mean()), np.zeros(1), np.ones(1), 1.0)


@dataclass
class Turntable(Rig):
    """Turns at the rate that it is told; base and attitude as a test wants them."""

    rate: float = 10.0
    base: float = 0.0
    earth: bool = False

    def _obey(self, output):
        super()._obey(output)
        if output.goal is not None:
            self.rate = output.rate or 10.0
        if output.halt:
            self.goal = self.joint

    def _hear(self):
        was, self.moving = self.joint, 0
        most = self.rate * HOP / RATE
        self.joint += min(max(self.goal - self.joint, -most), most)
        heard = super()._hear()
        pointing = Pointing(joint=self.joint, base=self.base, earth=self.earth)
        settled = was == self.joint == self.goal
        attitude = Attitude(self.base, known=self.earth)
        return replace(heard, heading_start=was + self.base, pointing=pointing, settled=settled, attitude=attitude)


def table(explorer=None, settings=TURNING, **told):
    explorer, stft = explorer or HearsTurning(), Stft(RATE, 512, 128)
    tools = Tools(explorer, stft, OneGroupEach(), stft, Likes(1), plan, turning=explorer)
    return Turntable(mission(settings, tools, **told))


def test_the_array_turns_on_until_the_explorer_is_certain_and_then_brakes():
    explorer = HearsTurning()
    one = table(explorer)
    assert one.run().outcome is Outcome.TARGET_FOUND
    assert len(one.said(OrientationHeard)) == 3
    swept = np.rad2deg(np.concatenate(explorer.swept))
    assert swept[-1] == pytest.approx(60 * 3 * SETTINGS.unit, abs=4)
    assert np.diff(swept).min() >= 0  # nothing is left out, and nothing heard at rest
    halts = [output for output in one.outputs if output.halt]
    assert len(halts) == 1
    assert [event.final for event in one.said(SourcesEstimated)] == [False, False, True]


def test_unless_it_is_asked_for_the_array_turns_by_steps_and_listens_at_rest():
    explorer, stft = HearsTurning(), Stft(RATE, 512, 128)
    one = Turntable(mission(SETTINGS, Tools(explorer, stft, OneGroupEach(), stft, Likes(1), plan)))
    one.run()
    headings = np.rad2deg([event.heading for event in one.said(OrientationHeard)])
    assert headings == pytest.approx(np.rad2deg(SETTINGS.rotation) * np.arange(len(headings)))
    assert explorer.swept == []
    assert all(output.rate is None and not output.halt for output in one.outputs)


def test_it_is_sent_to_the_ends_at_the_rate_that_is_set():
    one = table(HearsTurning(certain=False), replace(TURNING, periods=12))
    one.run()
    sent = [(round(np.rad2deg(o.goal)), o.rate) for o in one.outputs if o.goal is not None and o.rate]
    assert sent[:3] == [(180, RATE_RAD_S), (0, RATE_RAD_S), (180, RATE_RAD_S)]
    reasons = [event.reason for event in one.said(TurnStarted)]
    assert reasons[:3] == ["turning while it listens"] * 3


def test_it_ends_after_the_whole_turn_when_never_certain():
    one = table(HearsTurning(certain=False))
    one.run()
    assert len(one.said(OrientationHeard)) == TURNING.periods
    assert [event.final for event in one.said(SourcesEstimated)] == [False] * 4 + [True]
    details = [event.detail for event in one.said(StateChanged) if event.state is State.EXPLORE_TURN]
    assert details[-1] == "turning at 60 deg/s, period 5 of 5"


def test_headings_are_those_of_a_base_that_turns_too():
    """The base turns against the joint: the array hardly turns, and the explorer is told so."""

    def against(one, heard):
        one.base = -one.joint / 2

    explorer = HearsTurning(certain=False)
    one = table(explorer)
    one.run(against, 800)
    swept = np.rad2deg(np.ptp(np.concatenate(explorer.swept)))
    assert swept == pytest.approx(90, abs=8)


def test_a_stop_ends_the_turn_within_a_hop():
    def stop(one, heard):
        if one.hops == 100:
            return replace(heard, orders=(Stop(),))
        return None

    one = table(HearsTurning(certain=False))
    assert one.run(stop).outcome is Outcome.STOPPED
    assert one.hops == 101
    assert one.outputs[-1].stop


def test_a_fault_ends_it():
    def break_down(one, heard):
        return replace(heard, fault="the motor burns") if one.hops == 100 else None

    result = table(HearsTurning(certain=False)).run(break_down)
    assert (result.outcome, result.reason) == (Outcome.FAULT, "the motor burns")


def test_an_attitude_that_is_lost_on_the_way_begins_it_again():
    def lose(one, heard):
        one.earth = one.hops < 170

    explorer = HearsTurning()
    one = table(explorer)
    one.earth = True
    one.run(lose)
    doubts = [event.reason for event in one.said(Doubted)]
    assert doubts == ["the vehicle's attitude is no longer known"]
    indices = [event.index for event in one.said(OrientationHeard)]
    assert indices == [0, 1, 0, 1, 2]


def test_a_pipelined_mission_visits_an_alignment_on_the_way_and_turns_on():
    one = table(HearsTurning(certain=False, patience=1), replace(TURNING, pipelined=True, periods=4))
    assert one.run().outcome is Outcome.TARGET_FOUND
    checked = one.said(Checked)[0].time
    assert checked < one.said(SourcesEstimated)[-1].time + 1e-9
    assert len(one.said(OrientationHeard)) < 4 + 3


def test_voices_are_recalled_from_what_was_heard_while_it_turned():
    likes = Likes(1)
    explorer, stft = HearsTurning(), Stft(RATE, 512, 128)
    tools = Tools(explorer, stft, OneGroupEach(), stft, likes, plan, turning=explorer)
    Turntable(mission(TURNING, tools)).run()
    assert likes.heard  # and the first was asked before anything was heard at rest
    assert Turntable(mission(replace(TURNING, check=3.0), tools)).run().outcome is Outcome.TARGET_FOUND


# ------------------------------------------------------------------------------------------ where it turns back


@pytest.mark.parametrize(
    ("joint", "lower", "upper", "ends"),
    [
        (0, -200, 200, (180, 0)),
        (150, -200, 200, (-30, 150)),
        (0, -60, 90, (90, -60)),
        (-200, -200, 200, (-20, -200)),
        (10, -90, 90, (-90, 90)),
        (0, -np.inf, np.inf, (180, 0)),
    ],
)
def test_the_ends_lie_inside_the_limits_and_half_a_turn_apart_where_there_is_room(joint, lower, upper, ends):
    settings = replace(TURNING, lower=np.deg2rad(lower), upper=np.deg2rad(upper))
    sweep = sweep_from(settings, np.deg2rad(joint))
    assert np.rad2deg(sweep.ends) == pytest.approx(ends)


@pytest.mark.parametrize(("joint", "ends"), [(-50, (50, 0)), (250, (50, 100))])
def test_who_stands_beyond_a_limit_sweeps_from_there(joint, ends):
    limited = replace(TURNING, lower=0.0, upper=np.deg2rad(100))
    sweep = sweep_from(replace(limited, turn_rate=np.deg2rad(5.0), longest_move=12.5), np.deg2rad(joint))
    assert np.rad2deg(sweep.ends) == pytest.approx(ends)


def test_a_way_to_the_nearer_limit_that_is_too_long_is_not_turned_at_the_rate_of_listening():
    settings = replace(TURNING, lower=np.deg2rad(60), upper=np.deg2rad(240), turn_rate=np.deg2rad(5), longest_move=12)
    one = table(settings=settings)
    one.run()
    sent = [(round(np.rad2deg(o.goal)), o.rate) for o in one.outputs if o.goal is not None]
    assert sent[:2] == [(60, None), (108, settings.turn_rate)]


def test_nor_is_a_way_back_from_an_alignment_that_was_visited():
    settings = replace(TURNING, turn_rate=np.deg2rad(10), longest_move=3, pipelined=True, periods=6)
    explorer, stft = HearsTurning(certain=False, patience=1), Stft(RATE, 512, 128)
    one = Turntable(mission(settings, Tools(explorer, stft, OneGroupEach(), stft, Likes(9), turning=explorer)))
    one.run()
    joint, slow = 0.0, []
    for output in one.outputs:
        if output.goal is not None:
            slow += [abs(output.goal - joint)] if output.rate else []
            joint = output.goal
    assert len(one.said(Checked)) > 1
    assert max(slow) <= np.deg2rad(10 * 3)


class Overshoots(Turntable):
    """Comes to rest a little beyond where it was sent."""

    def _obey(self, output):
        super()._obey(output)
        if output.goal is not None and output.goal != self.joint:
            self.goal += np.copysign(np.deg2rad(0.05), output.goal - self.joint)


def test_who_rests_a_little_beyond_an_end_turns_back_at_the_rate_of_listening():
    settings = replace(TURNING, turn_rate=np.deg2rad(10), longest_move=2.6, periods=12)
    explorer, stft = HearsTurning(certain=False), Stft(RATE, 512, 128)
    one = Overshoots(mission(settings, Tools(explorer, stft, OneGroupEach(), stft, Likes(1), turning=explorer)))
    one.run()
    explored = one.outputs[: next(place for place, output in enumerate(one.outputs) if output.halt)]
    assert {output.rate for output in explored if output.goal is not None} == {settings.turn_rate}


def test_no_move_takes_longer_than_the_guard_bears():
    sweep = sweep_from(replace(TURNING, turn_rate=np.deg2rad(5.0), longest_move=20.0), 0.0)
    assert abs(sweep.ends[0]) / sweep.rate <= 16.0 + 1e-9


def test_a_goal_is_sent_once_and_the_next_when_it_is_reached():
    sweep = sweep_from(TURNING, 0.0)
    assert sweep.next_goal() == pytest.approx(np.pi)
    sweep.update(settled=False)
    assert sweep.next_goal() is None
    sweep.update(settled=True)
    assert sweep.next_goal() == pytest.approx(0.0)


# ------------------------------------------------------------------------------------------ what is kept


def heard_over(degrees, hops, base=0.0):
    kept, one = HeardTurning(RATE), Turntable(None, rate=np.deg2rad(degrees) / (hops * HOP / RATE), base=base)
    one.joint, one.goal = 0.0, np.deg2rad(degrees)
    kept.begin()
    for _ in range(hops):
        kept.add(one._hear())
    return kept


def test_pieces_turn_by_one_step_each_and_hold_everything_once():
    kept = heard_over(90.0, 450)
    pieces = kept.pieces(np.deg2rad(15.0))
    assert len(pieces) == 6
    assert sum(piece.samples.shape[1] for piece in pieces) == 450 * HOP
    assert np.rad2deg([piece.heading for piece in pieces]) == pytest.approx(7.5 + 15.0 * np.arange(6), abs=0.3)
    assert max(piece.spread for piece in pieces) < np.deg2rad(8.0)
    before, after = pieces[2].around
    assert before.shape[1] == after.shape[1] == RATE // 2


def test_pieces_of_a_fast_turn_are_long_enough_to_be_separated():
    pieces = heard_over(180.0, 200).pieces(np.deg2rad(15.0))
    assert min(piece.samples.shape[1] for piece in pieces) >= RATE // 2


def test_the_next_period_knows_what_was_heard_right_before_it():
    kept = heard_over(30.0, 100)
    first = kept.period()
    kept.begin()
    one = Turntable(None, joint=np.deg2rad(30.0), goal=np.deg2rad(30.0))
    kept.add(one._hear())
    second = kept.period()
    assert first.before == 0
    assert second.before == 0.15 * RATE
    assert second.samples.shape[1] == second.before + HOP
    assert len(second.headings) == second.samples.shape[1] // HOP


def test_speeds_of_rotors_go_with_what_was_heard():
    kept, one = HeardTurning(RATE), Turntable(None, rate=RATE_RAD_S)
    one.goal = np.pi
    kept.begin()
    for number in range(100):
        heard = one._hear()
        kept.add(replace(heard, attitude=replace(heard.attitude, rotor_speeds=(90.0 + number,))))
    assert kept.period().rotor_speeds.ravel().tolist() == (90.0 + np.arange(100)).tolist()
    pieces = kept.pieces(np.deg2rad(15.0))
    assert len(pieces) > 1
    assert np.concatenate([piece.rotor_speeds for piece in pieces]).ravel().tolist() == (90.0 + np.arange(100)).tolist()
    assert heard_over(30.0, 100).period().rotor_speeds is None


def test_the_heading_aboard_leaves_out_the_vehicle():
    turned = heard_over(30.0, 100, base=1.0).period()
    np.testing.assert_allclose([wrap(each) for each in turned.headings - turned.aboard], 1.0)


# ------------------------------------------------------------------------------------------ the configuration


def config(**explore):
    return validated(Config, {"explore": {"continuous": True, **explore}}, "ross.toml")


def test_rate_and_turn_say_how_many_periods_there_are():
    settings = settings_of(config(rate_deg_s=30, turn_deg=360, unit_s=3), -3.0, 3.0)
    assert settings.turn_rate == pytest.approx(np.deg2rad(30))
    assert settings.periods == 4
    assert settings_of(Config(), -3.0, 3.0).periods == 0


def test_only_when_it_is_asked_for_the_explorer_hears_while_it_turns():
    assert tools_of(config(), None).turning is not None
    assert tools_of(Config(), None).turning is None


def test_an_explorer_that_needs_rest_is_refused():
    with pytest.raises(PluginError, match="expected an explorer that hears while turning, got 'markov'"):
        tools_of(config(method="markov"), None)


def test_limits_that_show_too_few_axes_are_refused():
    narrow = {"explore": {"continuous": True}, "guard": {"lower_deg": -40, "upper_deg": 40}}
    with pytest.raises(ConfigError, match="expected limits at least 90 deg apart, got 80"):
        validated(Config, narrow, "ross.toml")
