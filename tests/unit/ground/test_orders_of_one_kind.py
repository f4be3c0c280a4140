"""Several orders of one kind: an acknowledgement does not say which of them it means (decision 47)."""

import pytest

from client_bench import WHO
from ross_payload.ground.client.command_types import Cancel, Explore, Listen, Park, Rearm, Record, Turn
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.dialect import ross

TURN, LISTEN = ross.MAV_CMD_ROSS_TURN, ross.MAV_CMD_ROSS_LISTEN


def test_listening_to_another_one_takes_the_place_of_listening(script):
    for source in (0, 1):
        script.orders.order(WHO, Listen(source=source))
        script.ack(LISTEN, Result.IN_PROGRESS)
    assert script.states() == ["acknowledged", "acknowledged"]
    script.wait(1.05)
    assert script.heard[-1][1].param2 == 1, "the answer may have been to the first: it asks once more"
    script.ack(LISTEN, Result.IN_PROGRESS)
    assert script.states() == ["cancelled", "in_progress"]
    script.ack(LISTEN, Result.CANCELLED)
    assert script.states() == ["cancelled", "cancelled"]


def test_a_refusal_right_after_the_end_of_its_like_that_was_done_is_none_of_that(script):
    script.orders.order(WHO, Turn(20.0))
    script.ack(TURN, Result.IN_PROGRESS)
    script.ack(TURN, Result.ACCEPTED)
    script.orders.order(WHO, Turn(-20.0))
    script.ack(TURN, Result.TEMPORARILY_REJECTED)
    assert script.states() == ["done", "refused"]


def test_progress_that_may_be_late_of_its_like_does_not_say_that_an_order_was_heard(script):
    """Were it asked for as one that the payload has, the payload would begin nothing: it has never heard of it."""
    script.orders.order(WHO, Turn(20.0))
    script.ack(TURN, Result.IN_PROGRESS)
    script.ack(TURN, Result.ACCEPTED)
    script.wait(0.5)
    script.orders.order(WHO, Turn(-20.0))
    script.wait(0.8)
    script.ack(TURN, Result.IN_PROGRESS)
    script.wait(2.5)
    confirmations = [message.confirmation for _, message in script.heard if message.param1 == -20.0]
    assert len(confirmations) > 1
    assert max(confirmations) < 128


def test_what_another_of_its_kind_has_replaced_is_not_asked_for_again(script):
    """The payload would take it for a new order, and do it in the place of the later one or refuse it."""
    script.orders.order(WHO, Listen(source=0))
    script.ack(LISTEN, Result.IN_PROGRESS)
    script.wait(0.9)
    script.orders.order(WHO, Listen(source=1))
    for _ in range(100):
        script.ack(LISTEN, Result.IN_PROGRESS)
        script.wait(0.1)
    assert [message.param2 for _, message in script.heard] == [0, 1, 1]
    assert [doing.reason for doing in script.orders.doing] == ["replaced by another command", ""]


def test_with_the_end_of_what_may_have_replaced_an_order_that_is_over_too(script):
    """A third one, which nobody has answered, leaves open which of the two has ended; asked for, it would begin."""
    for source in range(3):
        script.orders.order(WHO, Listen(source=source))
        if source < 2:
            script.ack(LISTEN, Result.IN_PROGRESS)
            script.wait(0.5)
    script.ack(LISTEN, Result.CANCELLED)
    script.ack(LISTEN, Result.TEMPORARILY_REJECTED)
    script.wait(6)
    assert script.states()[:2] == ["cancelled", "cancelled"]
    assert [message.param2 for _, message in script.heard if message.param2 < 2] == [0, 1]


def test_what_may_have_been_replaced_by_an_order_that_is_forgotten_is_not_asked_for_again(script):
    """The second one was never answered; the others were refused."""
    script.orders.order(WHO, Listen(source=0))
    script.ack(LISTEN, Result.IN_PROGRESS)
    script.wait(1)
    script.orders.order(WHO, Listen(source=1))
    for source in (2, 3):
        script.orders.order(WHO, Listen(source=source))
        script.ack(LISTEN, Result.TEMPORARILY_REJECTED)
        script.wait(0.9)
    script.ack(LISTEN, Result.TEMPORARILY_REJECTED)
    script.wait(6)
    assert [message.param2 for _, message in script.heard if message.param2 < 2] == [0, 1]


def test_an_order_is_asked_for_again_when_the_later_one_of_its_kind_was_refused(script):
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, Result.IN_PROGRESS)
    script.orders.order(WHO, Turn(50))
    script.ack(TURN, Result.TEMPORARILY_REJECTED)
    script.wait(2.1)
    assert [message.param1 for _, message in script.heard] == [40, 50, 40]
    script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done", "refused"]


def test_a_doubled_refusal_of_an_order_is_not_one_of_the_order_before_it(script):
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, Result.IN_PROGRESS)
    script.wait(2)
    script.orders.order(WHO, Turn(50))
    for _ in range(2):
        script.ack(TURN, Result.TEMPORARILY_REJECTED)
    assert script.states() == ["acknowledged", "refused"]
    script.wait(1.1)
    assert script.heard[-1][1].param1 == 40, "it is asked for"
    script.ack(TURN, Result.IN_PROGRESS)
    assert script.states() == ["in_progress", "refused"]


@pytest.mark.parametrize("end", [None, Result.ACCEPTED, Result.CANCELLED])
def test_what_the_payload_says_of_the_first_after_a_silence_is_not_believed_of_the_second(script, end):
    """The link was away while the second was sent, and sent again: an answer after that may be to the first."""
    script.orders.order(WHO, Listen(source=0))
    script.ack(LISTEN, Result.IN_PROGRESS)
    script.orders.order(WHO, Listen(source=1))
    script.wait(2.3)
    script.ack(LISTEN, Result.IN_PROGRESS)
    if end is not None:
        script.ack(LISTEN, end)
        script.ack(LISTEN, end)  # doubled on its way
    assert script.states()[1] == "acknowledged"
    assert script.orders.doing[0].reason != "replaced by another command"
    said = len(script.heard)
    script.wait(1.0)
    assert [message.param2 for _, message in script.heard[said:]][:1] == [1]
    script.ack(LISTEN, Result.IN_PROGRESS)
    assert script.states()[1] == "in_progress"


def test_what_was_given_up_is_not_revived_by_what_the_payload_says_of_the_first(script):
    """It would be said again in the place of what was ordered after it."""
    for order in (Listen(source=0), Listen(source=1), Park()):
        script.orders.order(WHO, order)
        script.ack(order.number, Result.IN_PROGRESS) if order != Listen(source=1) else None
    for _ in range(8):
        script.ack(LISTEN, Result.IN_PROGRESS)
        script.wait(0.5)
    script.wait(3.0)
    assert sum(message.command == LISTEN for _, message in script.heard) == 2
    assert script.orders.doing[1].reason == "another command was sent before it was answered"


def test_the_end_of_the_first_is_not_that_of_the_second_which_was_not_heard_yet(script):
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, Result.IN_PROGRESS)
    script.wait(0.5)
    script.orders.order(WHO, Turn(50))
    script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done", "sent"]


@pytest.mark.parametrize("later", [Turn(60), Park(), Cancel()])
def test_a_task_that_was_not_answered_is_not_said_again_after_a_later_one(script, later):
    script.orders.order(WHO, Turn(40))
    script.wait(0.5)
    script.orders.order(WHO, later)
    script.wait(6)
    assert [message.param1 for _, message in script.heard if message.command == TURN][1:] != [40.0]
    assert sum(message.command == TURN and message.param1 == 40.0 for _, message in script.heard) == 1
    assert script.orders.doing[0].reason == "another command was sent before it was answered"


def test_a_task_that_was_heard_after_all_is_followed_though_another_came(script):
    script.orders.order(WHO, Explore())
    script.orders.order(WHO, Park())
    script.ack(Explore.number, Result.IN_PROGRESS, progress=0.5)
    assert script.states()[0] == "in_progress"


def test_a_turn_that_was_heard_after_all_is_done_though_another_turn_was_refused(script):
    script.orders.order(WHO, Turn(40))
    script.wait(0.2)
    script.orders.order(WHO, Turn(60))
    script.ack(TURN, Result.TEMPORARILY_REJECTED)
    script.ack(TURN, Result.ACCEPTED)
    assert script.states() == ["done", "refused"]


def test_of_start_and_stop_recording_the_later_one_is_meant(script):
    script.orders.order(WHO, Record(True))
    script.wait(0.9)
    script.orders.order(WHO, Record(False))
    script.wait(3)
    assert {message.param1 for at, message in script.heard if at > 0.5} == {0.0}
    assert script.states()[0] == "cancelled"


def cancels_twice(script):
    """The second cancel waits for a computation, and its end is lost."""
    script.orders.order(WHO, Cancel())
    script.ack(Cancel.number, Result.ACCEPTED)
    script.wait(5.0)
    script.orders.order(WHO, Cancel())
    script.ack(Cancel.number, Result.IN_PROGRESS)
    script.wait(1.0)


def test_a_cancel_that_was_heard_is_asked_for_as_the_same_one(script):
    """It may have been the last of what the payload had to end: somebody else may have begun something since."""
    cancels_twice(script)
    script.wait(2.0)
    assert [message.confirmation for _, message in script.heard][:2] == [0, 0]
    assert all(message.confirmation for _, message in script.heard[2:])
    script.ack(Cancel.number, Result.ACCEPTED)
    assert script.states() == ["done", "done"]


def test_a_cancel_that_was_heard_is_not_said_again_after_what_was_ordered_since(script):
    cancels_twice(script)
    script.orders.order(WHO, Explore())
    for _ in range(60):
        script.ack(Explore.number, Result.IN_PROGRESS)
        script.wait(0.1)
    assert [message.command for _, message in script.heard][2:] == [Explore.number]


@pytest.mark.parametrize("order", [Cancel(), Rearm()])
def test_what_was_answered_so_soon_that_it_may_be_late_is_asked_for_as_the_same_one(script, order):
    """Said as a new one a second later it would cancel, or undo the stop, of somebody else."""
    for _ in range(2):
        script.orders.order(WHO, order)
        script.ack(order.number, Result.ACCEPTED)
        script.wait(0.3)
    script.wait(2.0)
    first, second, *asked = [message.confirmation for _, message in script.heard]
    assert (first, second) == (0, 0)
    assert asked
    assert all(asked)
    script.ack(order.number, Result.ACCEPTED)
    assert script.states() == ["done", "done"]


def test_the_second_cancel_of_two_that_waited_is_asked_for_as_the_same_one(script):
    script.orders.order(WHO, Cancel())
    script.ack(Cancel.number, Result.IN_PROGRESS)
    script.wait(0.3)
    script.orders.order(WHO, Cancel())
    script.ack(Cancel.number, Result.ACCEPTED)
    script.wait(2.0)
    assert [message.confirmation > 0 for _, message in script.heard] == [False, False, True, True]
