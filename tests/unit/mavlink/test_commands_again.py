"""Commands that come again, late, doubled or over a bad link: each is obeyed once."""

import math
from collections import Counter

import pytest

from command_bench import (
    ACCEPTED,
    DENIED,
    FAILED,
    HOME,
    IN_PROGRESS,
    REARM,
    RECORD,
    STOP,
    TEMPORARILY_REJECTED,
    TURN,
    Payload,
)
from examples import in_soak
from ross_payload.orders import (
    Cancel,
    Home,
    Rearm,
    Stop,
    TurnTo,
)
from ross_protocols.mavlink.commands import HEARD, cancel_message
from ross_protocols.mavlink.component_id import ComponentId


@pytest.fixture
def payload(sky):
    return Payload(sky())


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


def test_a_cancel_that_comes_late_does_not_end_the_task_that_its_sender_has_ordered_since(payload):
    payload.command(TURN, 60, seconds=0.2)
    payload.ground.send(cancel_message(TURN, ComponentId(1, 191)))
    frame = payload.ground.air.up[-1]
    payload.wait(0.3)
    payload.command(TURN, -60, seconds=0.2)
    payload.ground.air.up.append(frame)
    assert payload.results(TURN, 3.0)[-1] == ACCEPTED
    assert [type(order) for order in payload.given] == [TurnTo, Cancel, TurnTo]


@pytest.mark.parametrize("ahead", [50, 100])
def test_a_cancel_ends_what_a_station_with_the_same_ids_has_ordered_through_the_same_router(payload, ahead):
    """Each counts by itself: the frames of the one behind look like late ones of the other."""
    other = type(payload.ground)(payload.ground.air)
    other.mavlink.seq = ahead
    for _ in range(3):
        payload.ground.long(RECORD, 1)
        other.long(RECORD, 1)
        payload.wait(1.0)
    other.long(TURN, 170)
    payload.wait(0.6)
    payload.ground.send(cancel_message(TURN, ComponentId(1, 191)))
    payload.wait(0.3)
    assert [type(order) for order in payload.given] == [TurnTo, Cancel]


@pytest.mark.parametrize("sequence", [0, 7])
def test_a_cancel_of_a_sender_that_does_not_count_is_obeyed(payload, sequence):
    payload.ground.mavlink.seq = sequence
    payload.ground.long(TURN, 170)
    payload.wait(0.3)
    payload.ground.mavlink.seq = sequence
    payload.ground.send(cancel_message(TURN, ComponentId(1, 191)))
    payload.wait(0.3)
    assert [type(order) for order in payload.given] == [TurnTo, Cancel]


@pytest.mark.parametrize("seconds", [0.2, 2.0])
def test_a_script_that_begins_anew_can_cancel_at_once(payload, seconds):
    payload.ground.mavlink.seq = 100
    payload.command(TURN, 170, seconds=seconds)
    again = type(payload.ground)(payload.ground.air)
    again.mavlink.seq = 1  # the first frame was lost
    again.send(cancel_message(TURN, ComponentId(1, 191)))
    payload.wait(0.2)
    assert [type(order) for order in payload.given] == [TurnTo, Cancel]


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


def test_a_confirmation_of_an_order_like_the_last_but_one_is_obeyed_on_the_same_link(payload):
    for heading, confirmation in ((-20, 0), (20, 0), (-20, 1)):
        payload.command(TURN, heading, confirmation=confirmation, seconds=1.0)
    assert len(payload.given) == 3


def test_what_is_asked_for_after_another_of_its_kind_was_refused_is_answered_and_not_begun_again(payload):
    """Its end was lost, and the ground station still asks for it."""
    payload.command(TURN, -20, seconds=1.0)
    assert payload.command(TURN, 361, seconds=0.2) == [DENIED]
    assert payload.command(TURN, -20, confirmation=1, seconds=0.5) == [ACCEPTED]
    assert payload.command(TURN, 361, confirmation=1, seconds=0.2) == [DENIED]
    assert payload.command(TURN, -20, confirmation=2, seconds=0.5) == [ACCEPTED]
    assert len(payload.given) == 1


def test_a_doubled_frame_of_what_was_refused_is_not_obeyed_later(payload):
    """A slow copy of it comes when the payload is free again."""
    payload.command(TURN, -20, seconds=0.1)
    frames = []
    call, payload.ground.air.call = payload.ground.air.call, lambda frame: frames.append(frame) or call(frame)
    assert TEMPORARILY_REJECTED in payload.command(TURN, 20, seconds=1.0)
    call(frames[0])
    payload.wait(1.0)
    assert len(payload.given) == 1


def test_of_what_is_asked_for_again_and_again_while_the_mission_computes_two_are_remembered(payload):
    payload.computing = True
    for _ in range(20):
        payload.command(REARM, seconds=0.05)
    assert len(payload.given) == 20
    assert len(payload.server._recent.find(ComponentId(255, 190), REARM).remembered) == 2
    payload.computing = False
    assert payload.results(REARM, 1.0)[-1] == ACCEPTED


def lose(payload, frames):
    """Have the ground station send frames that nobody receives."""
    call, payload.ground.air.call = payload.ground.air.call, lambda frame: None
    for _ in range(frames):
        payload.ground.long(HOME)
    payload.ground.air.call = call


def homed(payload):
    """How often the zero was looked for."""
    return sum(isinstance(order, Home) for order in payload.given)


def test_a_lost_command_is_not_answered_with_the_result_of_an_earlier_one(payload):
    assert payload.command(HOME, seconds=0.5)[-1] == ACCEPTED
    payload.wait(3.5)
    lose(payload, 1)
    assert payload.command(HOME, confirmation=1, seconds=0.5)[-1] == ACCEPTED
    assert homed(payload) == 2


def test_a_confirmation_that_counts_from_zero_again_is_a_new_command(payload):
    payload.command(HOME, confirmation=2, seconds=0.5)
    lose(payload, 1)
    assert payload.command(HOME, confirmation=1, seconds=0.5)[-1] == ACCEPTED
    assert homed(payload) == 2


def test_a_lost_answer_is_given_again_within_the_patience_of_a_sender(payload):
    """No frame was lost on the way up, so the confirmation can only mean the command that was heard."""
    payload.command(HOME, seconds=0.5)
    payload.wait(4.0)
    assert payload.command(HOME, confirmation=1, seconds=0.5) == [ACCEPTED]
    assert homed(payload) == 1


@pytest.mark.parametrize("lost", [1, 2], ids=["its first frame is lost", "its first two are lost"])
def test_a_computer_that_has_rebooted_is_obeyed_though_its_numbers_start_again(payload, lost):
    for _ in range(5):
        payload.command(RECORD, 0, seconds=0.1)
    assert payload.command(HOME, seconds=0.5)[-1] == ACCEPTED
    payload.wait(8.0)
    payload.ground = type(payload.ground)(payload.ground.air)
    lose(payload, lost)
    assert payload.command(HOME, confirmation=lost, seconds=0.5)[-1] == ACCEPTED
    assert homed(payload) == 2


def test_a_rebooted_computer_is_obeyed_though_it_is_never_silent(payload):
    """Its frames come at once, with lower numbers than before."""
    for _ in range(60):
        payload.command(RECORD, 0, seconds=0.05)
    payload.command(HOME, seconds=0.5)
    payload.ground = type(payload.ground)(payload.ground.air)
    lose(payload, 1)
    assert payload.command(HOME, confirmation=1, seconds=0.5)[-1] == ACCEPTED
    assert homed(payload) == 2


@pytest.mark.parametrize("confirmation", [0, 1, 2])
def test_a_stop_that_is_sent_again_is_obeyed_again(payload, confirmation):
    payload.command(STOP, seconds=0.3)
    payload.command(REARM, seconds=0.3)
    assert payload.command(STOP, confirmation=confirmation, seconds=0.3)[-1] == ACCEPTED
    assert [type(order) for order in payload.given] == [Stop, Rearm, Stop]
    assert payload.stopped


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
    {"loss": 0.2},
    {"loss": 0.2, "doubled": 0.2, "delayed": 0.2, "damaged": 0.1},
    *in_soak({"loss": 0.01}, {"doubled": 0.3}, {"delayed": 0.3}, {"damaged": 0.2}),
]


@pytest.mark.parametrize("odds", ODDS, ids="+".join)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.soak)])
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


def test_the_confirmation_of_what_was_refused_is_not_answered_with_the_end_of_its_like_before(payload):
    assert payload.command(TURN, 40, seconds=1.0)[-1] == ACCEPTED
    payload.command(STOP, seconds=0.1)
    assert payload.command(TURN, 40, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert payload.command(TURN, 40, seconds=0.1, confirmation=1) == [TEMPORARILY_REJECTED]


def test_the_highest_confirmation_may_come_any_number_of_times(payload):
    """A task of hours on a bad link is asked for more often than a byte can count."""
    payload.command(TURN, 40, seconds=0.1)
    payload.command(TURN, 40, seconds=0.1, confirmation=255)
    payload.wait(3.0)
    assert payload.command(TURN, 40, seconds=0.1, confirmation=255) == [ACCEPTED]
    assert len(payload.given) == 1


@pytest.mark.parametrize("frames", [3, 4], ids=["an outage of 3 s", "an outage of 4 s"])
def test_an_end_that_was_lost_with_seconds_of_frames_is_told_again(payload, frames):
    """The ground station has heard nothing, says it once a second, and counts; its heartbeats are lost, too."""
    payload.command(HOME, seconds=0.2)
    payload.wait(frames - 0.2)
    lose(payload, 2 * frames)
    assert payload.command(HOME, confirmation=frames, seconds=0.3) == [ACCEPTED]
    assert homed(payload) == 1


@pytest.mark.parametrize("seconds", [0.5, 6.0])
def test_the_end_of_what_its_sender_knows_to_have_arrived_is_told_whatever_was_lost(payload, seconds):
    payload.command(HOME, seconds=0.5)
    payload.wait(seconds)
    lose(payload, 200)
    assert payload.command(HOME, confirmation=HEARD + 1, seconds=0.3) == [ACCEPTED]
    assert homed(payload) == 1


def test_what_another_payload_was_told_is_not_begun(payload):
    """It has restarted, and its sender only asks for the end of what it had begun."""
    assert payload.command(HOME, confirmation=HEARD + 1, seconds=0.3) == [FAILED]
    assert payload.texts == ["home refused: not known any longer: has the payload restarted?"]
    assert payload.given == []
    assert payload.command(HOME, confirmation=1, seconds=0.5)[-1] == ACCEPTED


def test_what_is_asked_for_after_the_same_was_refused_is_answered_with_its_own_end(payload):
    """Somebody has clicked twice."""
    payload.command(TURN, 40, seconds=0.2)
    assert payload.command(TURN, 40, seconds=0.2) == [TEMPORARILY_REJECTED]
    assert payload.results(TURN, 2.0)[-1] == ACCEPTED
    assert payload.command(TURN, 40, confirmation=HEARD + 1, seconds=0.3) == [ACCEPTED]
    assert len(payload.given) == 1


@pytest.mark.parametrize(("seconds", "told"), [(1.0, [ACCEPTED]), (6.0, [])])
def test_a_cancel_of_what_never_arrived_is_not_answered_with_the_end_of_what_is_long_over(payload, seconds, told):
    payload.command(HOME, seconds=0.5)
    payload.wait(seconds)
    payload.ground.send(cancel_message(HOME, ComponentId(1, 191)))
    assert payload.results(HOME, 0.3) == told
