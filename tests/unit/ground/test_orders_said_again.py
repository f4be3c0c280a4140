"""An order that is said again must not be done after what was ordered since: no motion that nobody asked for."""

import math
from types import SimpleNamespace

import pytest

from client_bench import US, WHO, Served, Station
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_types import Cancel, Explore, Listen, Park, Rearm, Stop, Turn
from ross_payload.ground.model.payload_state import PayloadState as Known
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.dialect import common, ross
from scripted_payload import Script

TURN, LISTEN, CANCEL = ross.MAV_CMD_ROSS_TURN, ross.MAV_CMD_ROSS_LISTEN, ross.MAV_CMD_ROSS_CANCEL
STOP, REARM = ross.MAV_CMD_ROSS_STOP, ross.MAV_CMD_ROSS_REARM
BEAT = common.MAVLink_heartbeat_message(common.MAV_TYPE_GCS, common.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3)


class Deaf:
    """A client that misses one final acknowledgement."""

    def __init__(self, orders, number, result):
        self._orders, self._missed = orders, (number, result)

    def on_packet(self, packet, now):
        if packet.name != "COMMAND_ACK" or (packet.message.command, packet.message.result) != self._missed:
            self._orders.on_packet(packet, now)

    def tick(self, now):
        self._orders.tick(now)


@pytest.fixture
def rig(sky):
    payload = Served(sky())
    station = Station(payload)
    orders = CommandProtocol(station.send, *US)
    station.clients.append(orders)

    def done(order):
        orders.order(WHO, order)
        return station.wait(10, lambda: orders.doing[-1].state == "done")

    def given():
        return [type(order).__name__ for order in payload.given]

    return SimpleNamespace(payload=payload, station=station, orders=orders, done=done, given=given)


def nothing_comes_down(rig, seconds):
    rig.payload.ground.air.odds.loss = 1.0
    rig.station.wait(seconds)
    rig.payload.ground.air.odds.loss = 0.0


def nothing_goes_up(rig, seconds):
    rig.station.lose = lambda message: True
    for _ in range(round(seconds * 10)):
        if rig.station.steps % 100 < 10:
            rig.station.send(BEAT, WHO)
        rig.station.wait(0.1)
    rig.station.lose = lambda message: False


def test_an_arming_that_is_said_again_does_not_undo_the_stop_after_it(rig):
    """The mission computes; the end of the arming is lost."""
    assert rig.done(Rearm())
    rig.payload.computing = True
    rig.orders.order(WHO, Stop())
    rig.station.wait(0.3)
    rig.orders.order(WHO, Rearm())
    rig.station.wait(0.3)
    rig.orders.order(WHO, Stop())
    rig.station.wait(0.1)
    rig.payload.computing = False
    nothing_comes_down(rig, 0.5)
    rig.station.wait(6)
    assert rig.payload.stopped
    assert rig.orders.doing[-1].state == "done"


@pytest.mark.parametrize("times", [1, 2])
def test_a_cancel_that_is_said_again_does_not_end_the_task_after_it(rig, times):
    """The mission computes; the end of the cancel is lost."""
    assert rig.done(Cancel())
    rig.orders.order(WHO, Turn(150))
    rig.station.wait(0.5)
    rig.payload.computing = True
    for _ in range(times):
        rig.orders.order(WHO, Cancel())
        rig.station.wait(0.5)
    rig.payload.computing = False
    nothing_comes_down(rig, 0.5)
    assert rig.done(Turn(-100))
    assert rig.payload.joint == pytest.approx(math.radians(100), abs=1e-6)


@pytest.mark.parametrize("seconds", [2.0, 2.5, 2.9, 3.3])
def test_a_turn_whose_end_was_lost_is_not_done_again_after_another_task(rig, seconds):
    rig.station.clients[0] = Deaf(rig.orders, TURN, Result.ACCEPTED)
    rig.orders.order(WHO, Turn(5))
    rig.station.wait(0.4)
    assert rig.done(Park())
    nothing_goes_up(rig, seconds)
    rig.station.wait(5)
    assert rig.given() == ["TurnTo", "Park"]
    assert rig.payload.joint == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("seconds", [2.0, 2.5, 2.9, 3.3])
def test_listening_whose_end_was_lost_does_not_begin_again_after_it_was_cancelled(rig, seconds):
    assert rig.done(Explore())
    rig.orders.order(WHO, Listen(source=0))
    rig.station.wait(4)
    rig.station.clients[0] = Deaf(rig.orders, LISTEN, Result.CANCELLED)
    assert rig.done(Cancel())
    nothing_goes_up(rig, seconds)
    rig.station.wait(5)
    assert rig.given() == ["Explore", "ListenTo", "Cancel"]


def test_a_stop_is_obeyed_as_soon_as_an_outage_of_twelve_seconds_is_over_and_a_later_arming_stays(rig):
    rig.orders.on_state(Known(WHO, 0.0, 0.0))
    rig.station.lose = lambda message: True
    rig.orders.order(WHO, Stop())
    rig.station.wait(12)
    assert not rig.payload.stopped
    assert rig.orders.doing[-1].state == "no_answer"
    rig.station.lose = lambda message: False
    rig.station.wait(0.5)
    assert rig.payload.stopped
    assert rig.orders.doing[-1].state == "done"
    assert rig.done(Rearm())
    rig.station.wait(40)
    assert not rig.payload.stopped


def test_a_stop_of_an_outage_is_not_obeyed_after_the_arming_that_was_ordered_in_it(rig):
    rig.orders.on_state(Known(WHO, 0.0, 0.0))
    assert rig.done(Stop())
    rig.station.lose = lambda message: True
    rig.orders.order(WHO, Stop())
    rig.station.wait(3)
    rig.orders.order(WHO, Rearm())
    rig.station.wait(0.5)
    rig.station.lose = lambda message: False
    rig.station.wait(40)
    assert not rig.payload.stopped


@pytest.mark.parametrize("seconds", [0.2, 0.9])
def test_a_cancel_that_was_lost_does_not_end_the_listening_that_was_ordered_after_it(rig, seconds):
    assert rig.done(Explore())
    number = rig.orders.order(WHO, Listen(source=0))
    rig.station.wait(3.0)
    rig.station.lose = lambda message: message.get_type() == "COMMAND_CANCEL"
    rig.orders.cancel(number)
    rig.station.wait(seconds)
    rig.station.lose = lambda message: False
    rig.orders.order(WHO, Listen(source=1))
    rig.station.wait(8.0)
    assert rig.given() == ["Explore", "ListenTo", "ListenTo"]
    assert [doing.state for doing in rig.orders.doing] == ["done", "cancelled", "in_progress"]


def test_a_cancel_that_was_lost_is_said_again_when_what_was_ordered_after_it_was_refused(rig):
    number = rig.orders.order(WHO, Turn(90))
    rig.station.wait(0.2)
    rig.station.lose = lambda message: message.get_type() == "COMMAND_CANCEL"
    rig.orders.cancel(number)
    rig.orders.order(WHO, Turn(-90))
    rig.station.wait(0.3)
    rig.station.lose = lambda message: False
    rig.station.wait(5.0)
    assert rig.given() == ["TurnTo", "Cancel"]
    assert [doing.state for doing in rig.orders.doing] == ["cancelled", "refused"]


def test_of_turns_refused_while_it_was_stopped_none_is_done_when_it_is_armed(rig):
    assert rig.done(Stop())
    for heading in (20, 30, 40):
        rig.orders.order(WHO, Turn(heading))
    rig.station.wait(0.3)
    assert rig.done(Rearm())
    rig.station.wait(6)
    assert rig.given() == ["Stop", "Rearm"]


def test_what_is_refused_soon_after_its_like_was_done_is_refused(rig):
    assert rig.done(Explore())
    assert rig.done(Stop())
    rig.orders.order(WHO, Explore())
    rig.station.wait(2)
    assert (rig.orders.doing[-1].state, rig.orders.doing[-1].reason) == ("refused", "stopped: re-arm first")


def test_what_goes_on_beside_a_refused_one_is_heard_of_after_an_outage(rig):
    rig.orders.order(WHO, Turn(170))
    rig.station.wait(0.5)
    rig.orders.order(WHO, Park())
    assert rig.station.wait(1, lambda: rig.orders.doing[-1].state == "refused")
    rig.payload.computing = True  # the turn takes longer
    nothing_comes_down(rig, 7)
    assert rig.orders.doing[0].state == "no_answer"
    rig.payload.computing = False
    assert rig.station.wait(10, lambda: rig.orders.doing[0].state == "done")


def test_the_refusal_of_what_a_stop_has_overtaken_is_none_of_what_goes_on(rig):
    rig.orders.order(WHO, Turn(40))
    rig.station.wait(0.2)
    rig.orders.order(WHO, Turn(-40))
    rig.orders.order(WHO, Stop())
    rig.station.wait(3)
    assert [doing.state for doing in rig.orders.doing] == ["cancelled", "cancelled", "done"]


def test_a_turn_that_nobody_answered_is_not_told_as_done_with_a_later_one():
    script = Script()
    for heading in (10, 20, 30):
        script.orders.order(WHO, Turn(heading))
    for result in (Result.TEMPORARILY_REJECTED, Result.TEMPORARILY_REJECTED, Result.IN_PROGRESS):
        script.ack(TURN, result)  # the first was begun, and the acknowledgements do not say so
    script.wait(2)
    script.orders.order(WHO, Turn(40))
    script.ack(TURN, Result.IN_PROGRESS)
    script.ack(TURN, Result.ACCEPTED)
    assert "done" not in script.states()[:3]


def test_what_the_payload_has_is_asked_for_with_a_confirmation_beyond_what_it_may_have_missed():
    script = Script()
    script.orders.order(WHO, Turn(10))
    script.ack(TURN, Result.IN_PROGRESS)
    script.wait(4)
    assert [message.confirmation for _, message in script.heard] == [0, 129, 130, 131, 132, 133]


def test_a_turn_that_never_arrived_is_not_told_as_done_when_it_is_cancelled(rig):
    """The payload answers a cancel with the end of the turn before."""
    assert rig.done(Turn(5))
    rig.station.lose = lambda message: True
    number = rig.orders.order(WHO, Turn(40))
    rig.station.wait(0.5)
    rig.station.lose = lambda message: False
    rig.orders.cancel(number)
    rig.station.wait(0.5)
    assert rig.orders.doing[-1].state == "no_answer"
    assert rig.given() == ["TurnTo"]


def test_an_answer_to_the_stop_before_is_none_to_a_stop_after_an_arming():
    """A stop is sent five times a second, and where an answer takes a second five are on their way when it is over."""
    script = Script()
    script.orders.order(WHO, Stop())
    script.wait(1.0)
    script.ack(STOP, Result.ACCEPTED)
    script.wait(0.8)
    script.ack(STOP, Result.ACCEPTED)
    script.orders.order(WHO, Rearm())
    script.ack(REARM, Result.ACCEPTED)
    script.wait(0.4)
    script.orders.order(WHO, Stop())
    script.ack(STOP, Result.ACCEPTED)
    before = len(script.heard)
    script.wait(0.4)
    assert len(script.heard) > before  # it is sent until it is answered
    script.wait(0.4)
    script.ack(STOP, Result.ACCEPTED)
    assert script.states() == ["done", "done", "done"]


def test_the_answer_to_a_stop_that_comes_after_an_arming_is_none_to_the_next_stop():
    script = Script()
    for order in (Stop(), Rearm(), Stop()):
        script.orders.order(WHO, order)
        script.wait(0.2)
    script.ack(STOP, Result.ACCEPTED)
    before = len(script.heard)
    script.wait(0.6)
    assert script.states()[-1] == "sent"
    assert len(script.heard) > before  # it is sent until it is answered
    script.wait(0.6)
    script.ack(STOP, Result.ACCEPTED)
    assert script.states()[-1] == "done"
