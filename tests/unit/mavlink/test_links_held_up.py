"""A program that stood still, on a computer that swaps or was suspended: what waited meanwhile is not obeyed late."""

import pytest

from command_bench import ACCEPTED, IN_PROGRESS, TEMPORARILY_REJECTED, Payload
from links_bench import Bench
from ross_payload.clock import suspended_time
from ross_payload.config import Link
from ross_payload.mavlink.router import CATCHING_UP, HELD_UP
from ross_protocols.mavlink.commands import COMMAND_LONG, cancel_message, long_message
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.params import set_message

URL = "udpout:127.0.0.1:14550"
US = ComponentId(1, 191)
TURN = long_message(ross.MAV_CMD_ROSS_TURN, (30.0,), US)
STOP = long_message(ross.MAV_CMD_ROSS_STOP, (), US)


@pytest.fixture
def bench():
    bench = Bench(Link(url=URL))
    bench.links.poll()
    return bench


def after(bench, seconds, *messages):
    """Stand still, then hear what was sent meanwhile; tell of each whether it may order something."""
    bench.clock.time += seconds
    bench.heard.clear()
    for message in messages:
        bench.say(URL, message, 255, 190)
    return [each.may_order for each in bench.heard]


def test_what_waited_is_not_obeyed_and_the_reason_is_told(bench):
    assert after(bench, 12.0, TURN, set_message("EXP_UNIT", 2.0, US), cancel_message(54000, US)) == [False] * 3
    assert bench.heard[0].refusal == "the payload stood still for 12 s: send it again"


def test_what_waited_while_the_computer_was_suspended_is_not_obeyed_either(bench):
    """Linux's monotonic clock stands still meanwhile."""
    bench.suspended = 600.0
    assert after(bench, 0.01, TURN, STOP) == [False, True]
    assert bench.heard[0].refusal == "the payload stood still for 600 s: send it again"
    assert after(bench, CATCHING_UP + 0.01, TURN) == [True]
    assert suspended_time() == pytest.approx(suspended_time(), abs=0.1)


def test_a_stop_that_waited_is_obeyed(bench):
    assert after(bench, 12.0, STOP) == [True]


def test_what_is_ordered_afterwards_is_obeyed(bench):
    after(bench, 12.0)
    bench.links.poll()
    assert after(bench, CATCHING_UP + 0.01, TURN) == [True]


def test_what_waited_no_longer_than_senders_do_is_obeyed(bench):
    assert after(bench, HELD_UP - 0.1, TURN) == [True]


def test_the_first_that_is_heard_is_obeyed():
    assert after(Bench(Link(url=URL)), 12.0, TURN) == [True]


def test_who_may_not_order_is_told_no_other_reason():
    bench = Bench(Link(url=URL, accept=(250,)))
    bench.links.poll()
    assert after(bench, 12.0, TURN) == [False]
    assert (bench.heard[0].packet.message.get_msgId(), bench.heard[0].refusal) == (COMMAND_LONG, "")


def test_what_is_under_way_is_not_refused_when_it_waited_to_be_said_again(sky):
    """Its sender would take it for refused, and the array would turn all the same."""
    payload = Payload(sky())
    payload.command(ross.MAV_CMD_ROSS_TURN, 40, seconds=0.1)
    payload.clock.sleep(HELD_UP + 2.0)
    assert payload.command(ross.MAV_CMD_ROSS_TURN, 40, confirmation=1) == [IN_PROGRESS, ACCEPTED]
    assert len(payload.given) == 1


def test_a_new_command_that_waited_is_refused_for_the_moment(sky):
    payload = Payload(sky())
    payload.command(ross.MAV_CMD_ROSS_TURN, 40)
    payload.clock.sleep(HELD_UP + 9.0)
    assert payload.command(ross.MAV_CMD_ROSS_TURN, -40) == [TEMPORARILY_REJECTED]
    assert payload.texts == ["turn refused: the payload stood still for 12 s: send it again"]
    assert len(payload.given) == 1
