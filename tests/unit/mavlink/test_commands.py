"""Commands over the air: a ground station, the server on the pump, and a real session on the mission's side."""

import math

import pytest

from command_bench import (
    ACCEPTED,
    CANCEL,
    CANCELLED,
    DENIED,
    EXPLORE,
    FAILED,
    HOME,
    IN_PROGRESS,
    INFORM,
    LISTEN,
    NOISE,
    PARK,
    REARM,
    RECORD,
    STOP,
    TEMPORARILY_REJECTED,
    TURN,
    Believer,
    Payload,
    near,
)
from ross_payload.events import Answer, Answered, SourcesEstimated, State, StateChanged
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
from ross_protocols.mavlink.dialect import ross

NAN = math.nan


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
    assert near(given, order)


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
    assert payload.texts == ["listen refused: no target voice is enrolled"]


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


def test_a_cancel_is_accepted_when_it_is_in_effect_and_another_task_is_welcome_at_once(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.computing = True
    assert payload.command(CANCEL, seconds=0.3) == [IN_PROGRESS]
    payload.computing = False
    while not (ends := [m.result for m in payload.wait(0.01) if m.get_type() == "COMMAND_ACK" and m.command == CANCEL]):
        pass
    assert ends == [ACCEPTED]
    assert payload.command(TURN, -10)[-1] == ACCEPTED


def test_who_cancels_once_more_while_the_first_cancel_waits_goes_on_hearing_of_it(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.computing = True
    payload.command(CANCEL, seconds=0.5)
    payload.command(CANCEL, seconds=0.5)
    assert payload.results(CANCEL, 1.2) == [IN_PROGRESS]
    assert payload.command(CANCEL, seconds=0.05, confirmation=1) == [IN_PROGRESS]
    payload.computing = False
    assert payload.results(CANCEL) == [ACCEPTED]


def test_who_asks_again_hears_of_the_second_of_two_that_waited_and_not_of_the_first(payload):
    payload.command(STOP)
    payload.computing = True
    payload.command(REARM, seconds=0.3)
    payload.command(REARM, seconds=0.3)
    payload.computing, payload.fault = False, "the motor is off"
    assert payload.results(REARM, 1.0) == [DENIED]
    assert payload.command(REARM, seconds=0.5, confirmation=1) == [DENIED]
    assert payload.command(REARM, seconds=0.5, confirmation=2) == [DENIED]


def test_a_cancelled_task_can_be_followed_by_another(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.command(CANCEL, seconds=0.1)
    assert payload.command(TURN, -10)[-1] == ACCEPTED


def test_a_new_listener_takes_the_place_of_the_old_one_while_it_listens(payload):
    payload.server.on_event(SourcesEstimated(0.0, Believer().estimate([0] * 3), 3, final=True))
    payload.computing = True  # the test speaks for the mission
    payload.command(LISTEN, 1, 0, seconds=0.05)
    first = payload.given[-1]
    assert first == ListenTo(0, number=first.number)
    assert payload.command(LISTEN, 1, 1, seconds=0.05)[0] == TEMPORARILY_REJECTED
    payload.server.on_event(_answered(first, "ACCEPTED"))
    payload.server.on_event(StateChanged(0.0, State.RUN))
    payload.command(LISTEN, 1, 1, seconds=0.05)
    second = payload.given[-1]
    assert second == ListenTo(1, number=second.number)
    payload.server.on_event(_answered(first, "CANCELLED"))
    assert CANCELLED not in payload.results(LISTEN, 0.1)  # it would look like the end of the second one
    payload.server.on_event(_answered(second, "ACCEPTED"))
    payload.server.on_event(_answered(second, "DONE"))
    assert payload.results(LISTEN, 0.1)[-1] == ACCEPTED


@pytest.fixture
def replacing(payload):
    """A payload that is asked for another source while it listens to one; the test speaks for its mission."""
    payload.server.on_event(SourcesEstimated(0.0, Believer().estimate([0] * 3), 3, final=True))
    payload.computing = True
    payload.command(LISTEN, 1, 0, seconds=0.05)
    payload.server.on_event(_answered(payload.given[0], "ACCEPTED"))
    payload.server.on_event(StateChanged(0.0, State.RUN))
    payload.wait(0.1)
    payload.ground.long(LISTEN, 1, 1)
    return payload


def test_until_the_mission_has_accepted_what_replaces_its_task_one_answer_says_that_it_waits(replacing):
    replacing.ground.heard.clear()
    replacing.results(LISTEN, 1.0)
    replacing.command(LISTEN, 1, 1, confirmation=1, seconds=2.0)
    assert [m.result for m in replacing.ground.heard if m.get_type() == "COMMAND_ACK"] == [IN_PROGRESS]
    replacing.server.on_event(_answered(replacing.given[1], "ACCEPTED"))
    replacing.ground.heard.clear()
    replacing.command(LISTEN, 1, 1, confirmation=2, seconds=2.0)
    assert len([m for m in replacing.ground.heard if m.get_type() == "COMMAND_ACK"]) >= 3


@pytest.mark.parametrize("answer", ["DONE", "CANCELLED"])
def test_what_was_not_replaced_after_all_goes_on_and_its_end_is_told(replacing, answer):
    replacing.wait(0.05)
    replacing.server.on_event(_answered(replacing.given[1], "REFUSED"))
    assert replacing.results(LISTEN, 2.0) == [DENIED, IN_PROGRESS]
    assert replacing.command(LISTEN, 1, 0, confirmation=1, seconds=0.5) == [IN_PROGRESS]
    assert len(replacing.given) == 2, "it is not begun anew"
    replacing.server.on_event(_answered(replacing.given[0], answer))
    assert replacing.results(LISTEN, 1.0) == [ACCEPTED if answer == "DONE" else CANCELLED]
    assert replacing.command(LISTEN, 1, 0, confirmation=2, seconds=0.5) == [ACCEPTED if answer == "DONE" else CANCELLED]
    assert len(replacing.given) == 2


def test_what_has_ended_while_another_waited_in_vain_is_told_after_that(replacing):
    replacing.wait(0.05)
    replacing.server.on_event(_answered(replacing.given[0], "CANCELLED"))
    assert CANCELLED not in replacing.results(LISTEN, 0.05)
    replacing.server.on_event(_answered(replacing.given[1], "REFUSED"))
    assert replacing.results(LISTEN, 1.0)[-2:] == [DENIED, CANCELLED]
    assert replacing.command(LISTEN, 1, 0, confirmation=1, seconds=0.5) == [CANCELLED]
    assert len(replacing.given) == 2


def test_one_cancel_ends_what_goes_on_and_what_waits_to_replace_it(replacing):
    replacing.wait(0.05)
    replacing.ground.send(ross.MAVLink_command_cancel_message(1, 191, LISTEN))
    replacing.wait(0.1)
    assert [type(order).__name__ for order in replacing.given] == ["ListenTo", "ListenTo", "Cancel"]


def test_a_source_must_be_known_to_be_listened_to(payload):
    assert payload.command(LISTEN, 1, 0, seconds=0.1) == [TEMPORARILY_REJECTED]
    assert payload.texts == ["listen refused: no source is known: explore first"]
    assert payload.command(EXPLORE, seconds=6.0)[-1] == ACCEPTED
    assert payload.command(LISTEN, 1, 2, seconds=0.1) == [DENIED]
    assert payload.texts[-1] == "listen refused: source: expected 0 to 1, got 2"


def _answered(order, answer):
    return Answered(0.0, order.number, Answer[answer])
