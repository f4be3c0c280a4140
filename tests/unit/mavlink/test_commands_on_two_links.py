"""Commands that a router sends on two links to the payload: each is obeyed once, however much later the other is."""

import math

import pytest

from command_bench import ACCEPTED, IN_PROGRESS, REARM, STOP, TURN, Payload
from ross_payload.config import Link
from ross_payload.orders import Cancel, Rearm, TurnTo
from ross_protocols.mavlink.commands import cancel_message
from ross_protocols.mavlink.component_id import ComponentId


@pytest.fixture
def two_links(sky):
    """A payload, and its ground station as it speaks on a second link."""
    air = sky()
    radio = type(air.air)()
    air.links.attach(Link(url="udpout:127.0.0.1:14551"), radio)
    return Payload(air), type(air.ground)(radio)


def copied(payload, radio, number, *numbers, later=0.05):
    """Send the same frame on both links, on the second one a little later; return the results."""
    payload.ground.long(number, *numbers)
    frame = payload.ground.air.up[-1]
    heard = payload.wait(later)
    radio.air.up.append(frame)
    heard += payload.wait(1.0)
    return [one.result for one in heard if one.get_type() == "COMMAND_ACK" and one.command == number]


@pytest.mark.parametrize("later", [0.0, 0.05, 1.8])
def test_a_command_that_a_router_sends_on_two_links_is_obeyed_once_and_not_refused(two_links, later):
    payload, radio = two_links
    results = copied(payload, radio, TURN, 30, later=later)
    assert set(results) == {IN_PROGRESS, ACCEPTED}
    assert results[-1] == ACCEPTED
    assert len(payload.given) == 1
    assert payload.texts == []


def test_an_arming_that_comes_on_a_slower_link_too_does_not_undo_the_stop_of_somebody_else(two_links):
    payload, radio = two_links
    payload.command(STOP, seconds=0.2)
    payload.ground.long(REARM)
    frame = payload.ground.air.up[-1]
    payload.wait(0.2)
    other = type(payload.ground)(payload.ground.air, system_id=254)
    other.long(STOP)
    payload.wait(0.2)
    radio.air.up.append(frame)
    payload.wait(0.5)
    assert payload.stopped


@pytest.mark.parametrize("others", [False, True], ids=["alone", "stopped by another, too"])
@pytest.mark.parametrize("lost", [False, True], ids=["heard", "lost"])
def test_an_arming_undoes_the_stop_that_its_sender_had_sent_before_it_on_a_slower_link_too(two_links, lost, others):
    payload, radio = two_links
    payload.ground.long(STOP)
    stop = payload.ground.air.up[-1]
    if lost:
        payload.ground.air.up.clear()
    payload.wait(0.3)
    payload.ground.long(REARM)
    rearm = payload.ground.air.up[-1]
    payload.wait(0.2)
    assert not payload.stopped
    if others:
        type(payload.ground)(payload.ground.air, system_id=254).long(STOP)
        payload.wait(0.2)
    radio.air.up.append(stop)
    payload.wait(0.3)
    assert payload.stopped
    for _ in range(2):
        radio.air.up.append(rearm)
        payload.wait(0.3)
    assert payload.stopped == others
    assert sum(isinstance(order, Rearm) for order in payload.given) == (1 if others else 2)


def test_an_arming_does_not_undo_the_stop_that_its_sender_has_sent_after_it_where_that_comes_first(two_links):
    payload, radio = two_links
    frames = []
    for number in (STOP, REARM, STOP):
        payload.ground.long(number)
        frames.append(payload.ground.air.up[-1])
        payload.wait(0.3)
    for place in (2, 0, 1):
        radio.air.up.append(frames[place])
        payload.wait(0.1)
        assert payload.stopped


def test_a_cancel_that_comes_on_a_slower_link_too_does_not_end_the_next_task(two_links):
    payload, radio = two_links
    payload.command(TURN, 60, seconds=0.2)
    payload.ground.send(cancel_message(TURN, ComponentId(1, 191)))
    frame = payload.ground.air.up[-1]
    payload.wait(0.3)
    payload.command(TURN, -60, seconds=0.2)
    radio.air.up.append(frame)
    assert payload.results(TURN, 3.0)[-1] == ACCEPTED
    assert [type(order) for order in payload.given] == [TurnTo, Cancel, TurnTo]


@pytest.mark.parametrize("system_id", [255, 254], ids=["said again", "of another station"])
def test_of_two_cancels_that_come_on_a_slower_link_too_none_ends_the_next_task(two_links, system_id):
    payload, radio = two_links
    payload.command(TURN, 60, seconds=0.2)
    payload.ground.send(cancel_message(TURN, ComponentId(1, 191)))
    frame = payload.ground.air.up[-1]
    payload.wait(0.1)
    again = payload.ground if system_id == 255 else type(payload.ground)(payload.ground.air, system_id=254)
    again.send(cancel_message(TURN, ComponentId(1, 191)))
    payload.wait(0.1)
    payload.command(TURN, -60, seconds=0.2)
    radio.air.up.append(frame)
    assert payload.results(TURN, 3.0)[-1] == ACCEPTED
    assert [type(order) for order in payload.given] == [TurnTo, Cancel, TurnTo]


def test_a_cancel_that_came_first_on_the_link_that_lost_the_turn_ends_it_on_the_slower_one(two_links):
    payload, radio = two_links
    payload.ground.long(TURN, 170)
    turn = payload.ground.air.up.pop()
    payload.wait(0.3)
    payload.ground.send(cancel_message(TURN, ComponentId(1, 191)))
    cancel = payload.ground.air.up[-1]
    payload.wait(0.1)
    for frame in (turn, cancel):
        radio.air.up.append(frame)
        payload.wait(0.2)
    assert [type(order) for order in payload.given] == [TurnTo, Cancel]


def stays_stopped(payload, radio, frame):
    """Whether another station's stop holds when a frame from before it comes on the slower link."""
    type(payload.ground)(payload.ground.air, system_id=254).long(STOP)
    payload.wait(0.1)
    radio.air.up.append(frame)
    payload.wait(0.5)
    return payload.stopped


def test_an_arming_that_was_said_again_before_it_comes_on_a_slower_link_does_not_undo_a_stop(two_links):
    payload, radio = two_links
    payload.command(STOP, seconds=0.2)
    payload.ground.long(REARM)
    frame = payload.ground.air.up[-1]
    payload.wait(1.0)
    payload.ground.long(REARM, confirmation=1)
    payload.wait(0.1)
    assert not payload.stopped
    assert stays_stopped(payload, radio, frame)


def test_an_arming_that_comes_on_a_slower_link_too_after_one_that_was_lost_does_not_undo_a_stop(two_links):
    payload, radio = two_links
    payload.command(STOP, seconds=0.2)
    payload.ground.long(REARM)
    lost = payload.ground.air.up.pop()
    payload.ground.long(REARM)
    frame = payload.ground.air.up[-1]
    payload.wait(0.2)
    radio.air.up.append(lost)
    payload.wait(0.2)
    assert not payload.stopped
    assert stays_stopped(payload, radio, frame)


def test_a_turn_that_comes_on_a_slower_link_too_does_not_undo_the_next_one(two_links):
    payload, radio = two_links
    payload.ground.long(TURN, 10)
    frame = payload.ground.air.up[-1]
    payload.wait(0.3)
    payload.command(TURN, 20, seconds=0.4)
    radio.air.up.append(frame)
    payload.wait(1.0)
    assert [order.heading for order in payload.given] == pytest.approx([-math.radians(10), -math.radians(20)])


@pytest.mark.parametrize("seconds", [0.05, 1.0], ids=["while the next one goes on", "after it"])
def test_a_confirmation_that_is_late_on_a_slower_link_does_not_undo_the_next_order(two_links, seconds):
    """Our ground station confirms on all links."""
    payload, radio = two_links
    payload.command(TURN, -20, confirmation=1, seconds=1.0)
    payload.command(TURN, 20, seconds=seconds)
    radio.long(TURN, -20, confirmation=1)
    payload.wait(1.0)
    assert [order.heading for order in payload.given] == pytest.approx([math.radians(20), math.radians(-20)])


@pytest.mark.parametrize(("confirmation", "waited"), [(0, 0.5), (1, 6.0)])
def test_an_order_like_the_last_but_one_is_obeyed_on_another_link(two_links, confirmation, waited):
    payload, radio = two_links
    payload.command(TURN, -20, seconds=1.0)
    payload.command(TURN, 20, seconds=1.0)
    payload.wait(waited)
    radio.long(TURN, -20, confirmation=confirmation)
    payload.wait(1.0)
    assert len(payload.given) == 3
