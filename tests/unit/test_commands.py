"""Commands over the air: a ground station, the server on the pump, and a real session on the mission's side."""

import math
import struct
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ross_payload.config import Config
from ross_payload.dsp.stft import Stft
from ross_payload.events import Answer, Answered, Estimate, SourceEstimate, SourcesEstimated, State, StateChanged
from ross_payload.interfaces import Attitude, AudioBlock, Input, Observation
from ross_payload.mission.context import Tools
from ross_payload.mission.session import Kit, Session
from ross_payload.orders import (
    Cancel,
    Explore,
    Home,
    Informed,
    ListenAt,
    ListenTo,
    MeasureNoise,
    Park,
    Rearm,
    Seek,
    Stop,
    TurnTo,
)
from ross_payload.parameters import Parameters
from ross_payload.service.assemble import settings_of
from ross_payload.telemetry.commands import CommandServer
from ross_payload.telemetry.files import FileServer
from ross_payload.telemetry.identity import Endpoint
from ross_payload.telemetry.params import ParameterServer
from ross_payload.telemetry.requests import Requests
from ross_protocols.codec import Decoder
from ross_protocols.dialect import MESSAGES, ross

EXPLORE, LISTEN, INFORM, TURN, STOP, CANCEL, PARK, NOISE, RECORD, REARM, HOME = range(54000, 54011)
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED, IN_PROGRESS, CANCELLED, LONG_ONLY = range(8)
NAN = math.nan
RATE, HOP = 16000, 160


class Believer:
    """An explorer that knows two sources after three orientations."""

    name = "believer"

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return Observation(heading, np.zeros(1), np.ones(1), 1.0)

    def estimate(self, observations):
        sources = tuple(SourceEstimate(azimuth, 0.01, 0.9, True) for azimuth in (1.0, -1.0))
        return Estimate(sources if len(observations) > 2 else (), certain=len(observations) > 2)


def kit(config):
    stft = Stft(RATE, 1024, 256)
    numbers = replace(settings_of(config, -3.5, 3.5), lead_in=0.1, unit=0.1, min_rotations=2, max_rotations=4)
    return Kit(numbers, Tools(Believer(), stft, None, stft, None))


class Streams:
    """Nothing is streamed."""

    def request(self, link, message_id):
        return False

    def period(self, link, message_id):
        return None

    def set_period(self, link, message_id, period):
        return False


class Payload:
    """Server, session and a turntable of 1 rad/s whose guard latches stops; time moves in hops of 10 ms."""

    def __init__(self, sky):
        self.clock, self.links, self.ground = sky.clock, sky.links, sky.ground
        self.given, self.recorded, self.texts, self.waiting = [], [], [], []
        self.disk_full = self.computing = self.stopped = False
        self.fault, self.joint, self.goal, self.hops = "", 0.0, None, 0
        endpoint = Endpoint(self.links, 191)
        self.server = CommandServer(endpoint, self.give, self.record, self.say, Requests(endpoint, Streams()))
        self.links.component(191).subscribe(self.server.heard)
        self.mission = Session(Config(), kit).mission()
        self.output = next(self.mission)

    def give(self, order):
        self.given.append(order)
        self.waiting.append(order)
        if isinstance(order, Stop):
            self.stopped, self.goal = True, None

    def record(self, on):
        self.recorded.append(on)
        return "the disk is full" if self.disk_full else ""

    def say(self, severity, text):
        self.texts.append(text)

    def wait(self, seconds):
        """Let time pass; return what the ground station hears meanwhile."""
        heard = []
        for _ in range(round(seconds * 100)):
            self.clock.advance()
            self.links.poll()
            self.server.tick(self.clock.now())
            if not self.computing:
                self.hop()
            heard += self.ground.listen()
        return heard

    def hop(self):
        output = self.output
        for event in output.events:
            self.server.said(event)
        self.stopped = (self.stopped or output.stop) and not output.rearm
        self.goal = None if output.stop or output.halt or self.stopped else output.goal or self.goal
        begin, step = self.joint, 0.01
        if self.goal is not None:
            self.joint += float(np.clip(self.goal - self.joint, -step, step))
        block = AudioBlock(np.zeros((2, HOP), np.float32), self.hops * HOP, self.hops * HOP / RATE)
        self.hops += 1
        settled = self.goal is None or abs(self.goal - self.joint) < 1e-9
        orders, self.waiting = tuple(self.waiting), []
        heard = Input(block, begin, self.joint, self.joint, settled, Attitude(0.0), self.fault, orders)
        self.output = self.mission.send(heard)

    def results(self, number, seconds=3.0):
        """The results of a command that come within some seconds, without repetitions in a row."""
        acks = [m for m in self.wait(seconds) if m.get_type() == "COMMAND_ACK" and m.command == number]
        found = [ack.result for ack in acks]
        return [result for place, result in enumerate(found) if place == 0 or found[place - 1] != result]

    def command(self, number, *numbers, seconds=3.0, **how):
        self.ground.long(number, *numbers, **how)
        return self.results(number, seconds)


@pytest.fixture
def payload(sky):
    return Payload(sky())


# ------------------------------------------------------------------------------------------- what is asked for


@pytest.mark.parametrize(
    ("command", "order"),
    [
        ((EXPLORE,), Explore()),
        ((LISTEN, 0), Seek()),
        ((LISTEN, 2, NAN, 90), ListenAt(-math.pi / 2)),
        ((INFORM, -1, 90, NAN, NAN, NAN, NAN, NAN), Informed((-math.pi / 2,))),
        ((INFORM, 1, -45, 45, 0, NAN, NAN, NAN), Informed((math.pi / 4, -math.pi / 4, 0.0), first=1)),
        ((TURN, 90), TurnTo(-math.pi / 2)),
        ((TURN, 270), TurnTo(math.pi / 2)),
        ((PARK,), Park()),
        ((NOISE, 1.5), MeasureNoise(1.5)),
        ((REARM,), Rearm()),
        ((HOME,), Home()),
        ((STOP,), Stop()),
    ],
)
def test_a_command_becomes_its_order_with_angles_counter_clockwise(payload, command, order):
    payload.command(*command, seconds=0.05)
    (given,) = payload.given
    assert _near(given, order)


def _near(given, order):
    numbers = {name: getattr(given, name) for name in order.__dataclass_fields__ if name != "number"}
    wanted = {name: getattr(order, name) for name in numbers}
    return type(given) is type(order) and all(numbers[n] == pytest.approx(wanted[n]) for n in numbers)


def test_orders_have_numbers_of_their_own(payload):
    for command in (STOP, REARM, PARK):
        payload.command(command, seconds=0.1)
    assert len({order.number for order in payload.given} - {0}) == 3


@pytest.mark.parametrize(
    "command",
    [
        (TURN, NAN),
        (TURN, math.inf),
        (TURN, 361),
        (LISTEN, 3),
        (LISTEN, NAN),
        (LISTEN, 1, NAN),
        (LISTEN, 1, -1),
        (LISTEN, 1, 0.5),
        (LISTEN, 2, 0, NAN),
        (INFORM, -1, NAN, NAN, NAN, NAN, NAN, NAN),
        (INFORM, -1, 10, NAN, 20, NAN, NAN, NAN),
        (INFORM, 2, 10, 20, NAN, NAN, NAN, NAN),
        (INFORM, -1, 0, 0, 0, 0, 0, 0),
        (INFORM, NAN, 10, NAN, NAN, NAN, NAN, NAN),
        (NOISE, -1),
        (NOISE, 1e9),
        (RECORD, 2),
        (RECORD, NAN),
    ],
)
def test_numbers_that_cannot_be_meant_are_denied_with_the_reason(payload, command):
    assert payload.command(*command, seconds=0.05) == [DENIED]
    assert payload.given == payload.recorded == []
    (text,) = payload.texts
    assert "refused: " in text


# ------------------------------------------------------------------------------------------- acknowledgements


def test_a_task_is_in_progress_at_once_and_accepted_when_done(payload):
    payload.ground.long(TURN, 40)
    assert payload.results(TURN, seconds=0.05) == [IN_PROGRESS]
    assert payload.results(TURN) == [ACCEPTED]
    assert payload.joint == pytest.approx(math.radians(-40), abs=1e-6)


def test_the_acknowledgement_names_its_addressee(payload):
    payload.ground.long(STOP)
    (ack,) = [m for m in payload.wait(0.1) if m.get_type() == "COMMAND_ACK"]
    assert (ack.target_system, ack.target_component) == (255, 190)


def test_progress_of_an_exploration_grows_to_its_end(payload):
    payload.ground.long(EXPLORE)
    acks = [m for m in payload.wait(5.0) if m.get_type() == "COMMAND_ACK"]
    known = [ack.progress for ack in acks if ack.result == IN_PROGRESS and ack.progress != 255]
    assert known == sorted(known)
    assert 0 < known[-1] <= 100
    assert acks[-1].result == ACCEPTED


def test_who_waits_long_hears_about_once_a_second_that_it_goes_on(payload):
    payload.ground.long(NOISE, 8)
    acks = [m for m in payload.wait(7.5) if m.get_type() == "COMMAND_ACK"]
    assert {ack.result for ack in acks} == {IN_PROGRESS}
    assert 7 <= len(acks) <= 10


def test_an_answer_comes_within_150_ms_though_the_mission_computes(payload):
    payload.computing = True
    payload.ground.long(TURN, 40)
    assert payload.results(TURN, seconds=0.15) == [IN_PROGRESS]


def test_what_the_mission_refuses_is_denied_with_its_reason(payload):
    assert payload.command(LISTEN, 0) == [DENIED]
    assert payload.texts == ["listen refused: no voice is enrolled to be sought"]


def test_what_fails_is_failed(payload):
    payload.ground.long(TURN, 90)
    payload.wait(0.2)
    payload.fault = "the motor is gone"
    assert payload.results(TURN) == [FAILED]


# ------------------------------------------------------------------------------------------- busy, cancel, stop


def test_the_same_command_while_busy_is_rejected_for_now_and_disturbs_nothing(payload):
    payload.command(TURN, 90, seconds=0.1)
    assert payload.command(TURN, 90, seconds=0.1)[0] == TEMPORARILY_REJECTED
    assert payload.results(TURN)[-1] == ACCEPTED
    assert len(payload.given) == 1


def test_another_task_while_busy_is_rejected_for_now_with_the_reason(payload):
    payload.command(TURN, 90, seconds=0.1)
    assert payload.command(EXPLORE, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert payload.texts == ["explore refused: busy: cancel first"]


def test_arming_again_in_the_middle_of_a_task_is_rejected_for_now(payload):
    payload.command(TURN, 90, seconds=0.1)
    assert payload.command(REARM, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert [type(order) for order in payload.given] == [TurnTo]


def test_another_sender_is_busy_too_and_hears_nothing_of_the_first_ones_end(payload):
    payload.command(TURN, 90, seconds=0.1)
    other = type(payload.ground)(payload.ground.air, system_id=254)
    other.long(TURN, 10)
    acks = [m for m in payload.wait(3.0) if m.get_type() == "COMMAND_ACK"]
    assert [a.result for a in acks if a.target_system == 254] == [TEMPORARILY_REJECTED]
    assert [a.result for a in acks if a.target_system == 255][-1] == ACCEPTED


def test_command_cancel_cancels_the_one_in_progress(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.ground.send(ross.MAVLink_command_cancel_message(1, 191, TURN))
    assert payload.results(TURN) == [CANCELLED]
    assert abs(payload.joint) < math.radians(20)


def test_a_cancel_that_is_sent_again_is_one_cancel(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.computing = True
    for _ in range(5):
        payload.ground.send(ross.MAVLink_command_cancel_message(1, 191, TURN))
    payload.wait(0.1)
    assert [type(order) for order in payload.given] == [TurnTo, Cancel]
    payload.computing = False
    assert payload.results(TURN)[-1] == CANCELLED
    payload.ground.send(ross.MAVLink_command_cancel_message(1, 191, TURN))  # as if the answer was lost
    assert payload.results(TURN) == [CANCELLED]
    assert len(payload.given) == 2


def test_command_cancel_of_something_else_is_ignored(payload):
    payload.command(TURN, 40, seconds=0.1)
    payload.ground.send(ross.MAVLink_command_cancel_message(1, 191, EXPLORE))
    payload.ground.send(ross.MAVLink_command_cancel_message(1, 190, TURN))
    assert payload.results(TURN)[-1] == ACCEPTED


def test_cancel_as_a_command_cancels_whatever_is_in_progress(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.ground.long(CANCEL)
    acks = [(m.command, m.result) for m in payload.wait(0.2) if m.get_type() == "COMMAND_ACK"]
    assert sorted(acks) == [(TURN, CANCELLED), (CANCEL, ACCEPTED)]


def test_a_cancelled_task_can_be_followed_by_another(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.command(CANCEL, seconds=0.1)
    assert payload.command(TURN, -10)[-1] == ACCEPTED


def test_a_new_listener_takes_the_place_of_the_old_one_while_it_listens(payload):
    payload.server.said(SourcesEstimated(0.0, Believer().estimate([0] * 3), 3, final=True))
    payload.computing = True  # the test speaks for the mission
    payload.command(LISTEN, 1, 0, seconds=0.05)
    first = payload.given[-1]
    assert first == ListenTo(0, number=first.number)
    assert payload.command(LISTEN, 1, 1, seconds=0.05)[0] == TEMPORARILY_REJECTED
    payload.server.said(_answered(first, "ACCEPTED"))
    payload.server.said(StateChanged(0.0, State.RUN))
    payload.command(LISTEN, 1, 1, seconds=0.05)
    second = payload.given[-1]
    assert second == ListenTo(1, number=second.number)
    payload.server.said(_answered(first, "CANCELLED"))
    assert CANCELLED not in payload.results(LISTEN, 0.1)  # it would look like the end of the second one
    payload.server.said(_answered(second, "ACCEPTED"))
    payload.server.said(_answered(second, "DONE"))
    assert payload.results(LISTEN, 0.1)[-1] == ACCEPTED


def _answered(order, answer):
    return Answered(0.0, order.number, Answer[answer])


def test_a_stop_is_given_and_accepted_with_the_poll_that_hears_it(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.computing = True
    payload.ground.long(STOP)
    heard = payload.wait(0.01)
    assert payload.stopped
    assert [m.result for m in heard if m.get_type() == "COMMAND_ACK" and m.command == STOP] == [ACCEPTED]


@pytest.mark.parametrize("state", list(State))
def test_a_stop_is_obeyed_in_every_state(payload, state):
    payload.server.said(StateChanged(0.0, state))
    assert payload.command(STOP, seconds=0.05) == [ACCEPTED]
    assert isinstance(payload.given[-1], Stop)


def test_a_task_that_is_stopped_is_cancelled(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.ground.long(STOP)
    assert payload.results(TURN, 0.2)[-1] == CANCELLED


def test_nothing_moves_after_a_stop_until_it_is_armed_again(payload):
    payload.command(STOP, seconds=0.1)
    assert payload.command(TURN, 40, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert payload.texts == ["turn refused: stopped: re-arm first"]
    assert payload.command(REARM, seconds=0.1) == [ACCEPTED]
    assert payload.command(TURN, 40)[-1] == ACCEPTED


def test_a_task_after_a_stop_is_refused_though_the_mission_has_not_heard_the_stop(payload):
    payload.computing = True
    payload.command(STOP, seconds=0.05)
    assert payload.command(PARK, seconds=0.05) == [TEMPORARILY_REJECTED]


def test_a_fault_must_be_cleared_before_anything_moves(payload):
    payload.fault = "the motor is gone"
    payload.wait(0.05)
    assert payload.command(TURN, 40, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert payload.texts == ["turn refused: fault, re-arm first: the motor is gone"]
    assert payload.command(REARM, seconds=0.2) == [DENIED]
    payload.fault = ""
    assert payload.command(REARM, seconds=0.2, confirmation=0) == [ACCEPTED]


def test_a_source_must_be_known_to_be_listened_to(payload):
    assert payload.command(LISTEN, 1, 0, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert payload.texts == ["listen refused: no source is known: explore first"]
    assert payload.command(EXPLORE, seconds=6.0)[-1] == ACCEPTED
    assert payload.command(LISTEN, 1, 2, seconds=0.1) == [DENIED]
    assert payload.texts[-1] == "listen refused: there is no source 2 of 2, counted from 0"


# ------------------------------------------------------------------------------------------- not ours, not yours


@pytest.mark.parametrize("number", [400, 185, 22, 54011, 65535, 0])
def test_what_we_do_not_do_is_unsupported_and_for_all_components_not_even_answered(payload, number):
    assert payload.command(number, 1, 21196, seconds=0.1) == [UNSUPPORTED]
    assert payload.command(number, 1, 21196, seconds=0.1, target=(1, 0)) == []
    assert payload.command(number, 1, 21196, seconds=0.1, target=(0, 0)) == []
    assert payload.given == []


def test_a_restart_by_command_is_denied(payload):
    assert payload.command(246, 1, 1, seconds=0.1) == [DENIED]
    assert payload.command(246, 1, 1, seconds=0.1, target=(0, 0)) == []


@pytest.mark.parametrize("target", [(2, 191), (1, 1), (1, 154), (255, 190)])
def test_commands_for_others_pass_by(payload, target):
    assert payload.command(STOP, seconds=0.1, target=target) == []
    assert payload.given == []


@pytest.mark.parametrize("target", [(1, 0), (0, 191), (0, 0)])
def test_commands_for_all_are_for_us_too(payload, target):
    assert payload.command(STOP, seconds=0.1, target=target) == [ACCEPTED]


def test_a_command_int_is_obeyed_like_a_long_one(payload):
    payload.ground.int(TURN, 40.0)
    assert payload.results(TURN) == [IN_PROGRESS, ACCEPTED]
    assert _near(payload.given[0], TurnTo(math.radians(-40)))


def test_what_needs_seven_numbers_needs_the_long_command(payload):
    payload.ground.int(INFORM, -1.0, 10.0, 60.0, NAN)
    assert payload.results(INFORM, 0.1) == [LONG_ONLY]
    assert payload.given == []


def test_who_may_not_order_is_denied_and_nothing_happens(sky):
    payload = Payload(sky(accept=(250,)))
    payload.command(TURN, 90, seconds=0.1)
    for number in (STOP, TURN, RECORD, 512):
        assert payload.command(number, 1, seconds=0.1) == [DENIED]
    payload.ground.send(ross.MAVLink_command_cancel_message(1, 191, TURN))
    payload.wait(0.1)
    assert payload.given == payload.recorded == []


def test_a_recording_is_started_and_stopped_and_says_why_not(payload):
    assert payload.command(RECORD, 1, seconds=0.1) == [ACCEPTED]
    assert payload.command(RECORD, 0, seconds=0.1) == [ACCEPTED]
    payload.disk_full = True
    assert payload.command(RECORD, 1, seconds=0.1) == [FAILED]
    assert payload.recorded == [True, False, True]
    assert payload.texts == ["record refused: the disk is full"]


# ------------------------------------------------------------------------------------------- said again


def test_a_confirmation_is_answered_again_and_not_obeyed_again(payload):
    payload.command(TURN, 40, seconds=0.1)
    assert payload.command(TURN, 40, seconds=0.05, confirmation=1) == [IN_PROGRESS]
    payload.wait(2.0)
    assert payload.command(TURN, 40, seconds=0.05, confirmation=2) == [ACCEPTED]
    assert len(payload.given) == 1


def test_a_confirmation_of_what_was_never_heard_is_obeyed(payload):
    assert payload.command(TURN, 40, confirmation=1)[-1] == ACCEPTED
    assert len(payload.given) == 1


def test_a_confirmation_with_other_numbers_is_another_command(payload):
    payload.command(TURN, 40)
    assert payload.command(TURN, -40, confirmation=1)[-1] == ACCEPTED
    assert len(payload.given) == 2


def test_a_confirmation_long_after_the_end_is_a_new_command(payload):
    payload.command(TURN, 40)
    payload.wait(10.0)
    payload.command(TURN, 40, confirmation=1)
    assert len(payload.given) == 2


def test_another_senders_confirmation_is_its_own(payload):
    payload.command(RECORD, 1, seconds=0.1)
    other = type(payload.ground)(payload.ground.air, system_id=254)
    other.long(RECORD, 1, confirmation=1)
    payload.wait(0.1)
    assert payload.recorded == [True, True]


def test_a_doubled_frame_is_obeyed_once(sky):
    payload = Payload(sky(doubled=1.0))
    payload.command(RECORD, 1, seconds=0.1)
    assert payload.recorded == [True]


def test_what_was_asked_before_a_stop_is_not_obeyed_after_it(payload):
    """The network delivers a stop before the re-arming that its sender had sent earlier."""
    payload.command(STOP, seconds=0.1)
    frames = []
    payload.ground.air.call = frames.append
    payload.ground.long(REARM)
    payload.ground.long(STOP)
    payload.ground.air.up = frames[::-1]
    assert payload.results(REARM, 0.2) == [TEMPORARILY_REJECTED]
    assert payload.stopped
    assert not any(isinstance(order, Rearm) for order in payload.given)


def test_a_script_that_is_run_again_is_obeyed_again(payload):
    """Every run of a script counts its frames from 0."""
    for number in (REARM, STOP, REARM, TURN):
        payload.ground = type(payload.ground)(payload.ground.air)
        assert payload.command(number, seconds=1.0)[-1] == ACCEPTED
    assert [type(order) for order in payload.given] == [Rearm, Stop, Rearm, TurnTo]
    assert not payload.stopped


def test_a_doubled_first_frame_is_no_new_start(payload):
    """A frame with the number 0 that comes twice within half a second."""
    payload.command(RECORD, 1, seconds=0.3)
    payload.ground = type(payload.ground)(payload.ground.air)
    payload.command(RECORD, 1, seconds=0.3)
    assert payload.recorded == [True]


class Patient:
    """A client as MAVLink wants it: sends again with a growing confirmation until it is answered."""

    def __init__(self, payload):
        self.payload = payload

    def command(self, number, *numbers):
        """Return the final result, None when all was lost."""
        for confirmation in range(30):
            acks = self.payload.command(number, *numbers, seconds=0.7, confirmation=confirmation)
            while acks and acks[-1] == IN_PROGRESS:
                acks = self.payload.results(number, 2.0)
            if acks:
                return acks[-1]
        return None


ODDS = [
    {"loss": 0.01},
    {"loss": 0.2},
    {"doubled": 0.3},
    {"delayed": 0.3},
    {"damaged": 0.2},
    {"loss": 0.2, "doubled": 0.2, "delayed": 0.2, "damaged": 0.1},
]


@pytest.mark.parametrize("odds", ODDS, ids="+".join)
@pytest.mark.parametrize("seed", [1, 2])
def test_on_a_bad_link_every_command_is_obeyed_once_and_its_end_is_told(sky, odds, seed):
    payload = Payload(sky(**odds, seed=seed))
    client = Patient(payload)
    wanted = Counter()
    for turn in range(8):
        heading = 10.0 * (turn % 3 - 1)
        assert client.command(TURN, heading) == ACCEPTED
        assert client.command(RECORD, turn % 2) == ACCEPTED
        wanted += Counter({("turn", round(heading)): 1, ("record", turn % 2): 1})
        payload.wait(6.0)  # so that a confirmation cannot be taken for the last but one command
    done = Counter(("turn", round(-math.degrees(order.heading))) for order in payload.given)
    assert done + Counter(("record", int(on)) for on in payload.recorded) == wanted


# ------------------------------------------------------------------------------------------- anything at all

ORDERS = {
    EXPLORE: Explore, LISTEN: (Seek, ListenTo, ListenAt), INFORM: Informed, TURN: TurnTo, STOP: Stop, CANCEL: Cancel,
    PARK: Park, NOISE: MeasureNoise, REARM: Rearm, HOME: Home,
}  # fmt: skip
SERVED = [75, 76, 80, 20, 21, 23, 110]  # messages that somebody here answers

floats = st.floats(width=32, allow_nan=True, allow_infinity=True)
small = st.integers(-3, 3).map(float)
numbers = st.one_of(st.integers(EXPLORE - 2, HOME + 2), st.sampled_from([80, 246, 400, 510, 511, 512, 520]))
octets = st.integers(0, 255)
targets = st.tuples(st.sampled_from([0, 1]) | octets, st.sampled_from([0, 191]) | octets)
commands = st.tuples(targets, numbers | st.integers(0, 65535), octets, st.tuples(*[small | floats] * 7), st.booleans())


def only_what_was_asked_for(given, message):
    """Whether the orders that follow a message are those that it may lead to."""
    if not given:
        return True
    number, target = message.command, (message.target_system, message.target_component)
    may = Cancel if message.get_msgId() == 80 else ORDERS.get(number, ())
    return target[0] in (0, 1) and target[1] in (0, 191) and len(given) == 1 and isinstance(given[0], may)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(commands, octets, octets), min_size=1, max_size=30))
def test_of_random_commands_none_raises_and_none_is_obeyed_that_was_not_asked_for(sky, frames):
    payload = Payload(sky())
    for (target, number, confirmation, values, long), system, component in frames:
        if long:
            message = ross.MAVLink_command_long_message(*target, number, confirmation, *values)
        else:
            message = ross.MAVLink_command_int_message(*target, 0, number, 0, 0, *values[:4], 7, -7, values[6])
        before = len(payload.given)
        payload.ground.air.call(message.pack(ross.MAVLink(None, srcSystem=system, srcComponent=component)))
        payload.wait(0.01)
        assert only_what_was_asked_for(payload.given[before:], message)


def random_frame(rng):
    """A frame of any message with a good checksum and random content; half of them nearly make sense."""
    served = rng.random() < 0.5
    kind = MESSAGES[int(rng.choice(SERVED if served else list(MESSAGES)))]
    content = bytearray(rng.bytes(kind.unpacker.size))
    if served:
        for name, choices in (
            ("target_system", (0, 1)),
            ("target_component", (0, 191)),
            ("command", range(54000, 54011)),
        ):
            if name in kind.ordered_fieldnames:
                _put(content, kind, name, int(rng.choice(choices)))
        if kind.id == 76 and rng.random() < 0.5:
            content[:28] = struct.pack("<7f", *rng.integers(-2, 91, 7))
    head = struct.pack("<BBBBBBHB", len(content), 0, 0, *rng.integers(0, 256, 3), kind.id & 0xFFFF, kind.id >> 16)
    checksum = ross.x25crc(head + content + bytes([kind.crc_extra])).crc
    return b"\xfd" + head + content + struct.pack("<H", checksum)


def _put(content, kind, name, value):
    layout = kind.unpacker.format.lstrip("<")
    before = "<" + layout[: kind.ordered_fieldnames.index(name)]
    struct.pack_into("<" + layout[kind.ordered_fieldnames.index(name)], content, struct.calcsize(before), value)


def flood(sky, count, seed):
    """Send random frames; return how many of them became orders and how many changed a parameter."""
    rng, sky = np.random.default_rng(seed), sky()
    payload, parameters, orders = Payload(sky), Parameters(Config()), 0
    server = ParameterServer(Endpoint(sky.links, 191), parameters, lambda name, value: None, payload.say)
    readable = FileServer(Endpoint(sky.links, 191), {"general.json": b"{}"})
    for part in (server, readable):
        sky.links.component(191).subscribe(part.heard)
    decoder = Decoder()
    for index in range(count):
        frame = random_frame(rng)
        sky.air.up.append(frame)
        sky.links.poll()
        orders += len(payload.given)
        if payload.given:
            (packet,) = decoder.feed(frame)
            assert only_what_was_asked_for(payload.given, packet.message)
        payload.given.clear()
        payload.texts.clear()
        if index % 20 == 0:
            server.tick(sky.clock.now())
            readable.tick(sky.clock.now())
            payload.wait(0.01)
    assert parameters.config == Config()  # no random name is a parameter's
    parameters.close()
    return orders


def test_ten_thousand_random_frames_do_nothing_that_was_not_asked_for(sky):
    assert flood(sky, 10_000, seed=1) > 100  # else nothing was tested


@pytest.mark.soak
def test_a_million_random_frames_do_nothing_that_was_not_asked_for(sky):
    assert flood(sky, 1_000_000, seed=2) > 10_000


def test_what_is_remembered_of_senders_is_bounded(payload):
    for system in range(1, 256):
        for component in (1, 2, 3):
            other = type(payload.ground)(payload.ground.air, system, component)
            other.long(RECORD, 1)
        payload.wait(0.01)
    sizes = [len(v) for v in vars(payload.server).values() if hasattr(v, "__len__")]
    assert max(sizes) <= 256


def test_five_thousand_commands_a_second_are_not_all_answered(payload):
    """The answers to a flood stay a trickle, and another sender still gets its own."""
    other = type(payload.ground)(payload.ground.air, system_id=254)
    acks = Counter()
    for _ in range(100):
        for _ in range(50):
            other.long(EXPLORE, 1)
        acks += Counter(m.target_system for m in payload.wait(0.01) if m.get_type() == "COMMAND_ACK")
    assert acks[254] <= 80
    assert payload.command(STOP, seconds=0.05)[-1] == ACCEPTED


def test_of_a_flood_of_stops_the_mission_hears_a_few_and_the_last_one_counts(payload):
    for _ in range(100):
        for _ in range(50):
            payload.ground.long(STOP)
        payload.wait(0.01)
    assert 1 <= len(payload.given) <= 12
    payload.wait(3.0)
    assert payload.command(REARM, seconds=0.1) == [ACCEPTED]
    payload.ground.long(STOP)
    payload.wait(0.01)
    assert payload.stopped


def test_a_stop_right_after_a_re_arming_is_not_taken_for_the_one_before(payload):
    payload.ground.long(STOP)
    payload.ground.long(REARM)
    payload.ground.long(STOP)
    payload.wait(0.1)
    assert [type(order) for order in payload.given] == [Stop, Rearm, Stop]
    assert payload.stopped
