"""A stop over the air: obeyed at once, answered when it outlives a restart; nothing moves until it is armed again."""

import pytest

from command_bench import (
    ACCEPTED,
    CANCELLED,
    DENIED,
    IN_PROGRESS,
    PARK,
    REARM,
    STOP,
    TEMPORARILY_REJECTED,
    TURN,
    Payload,
)
from ross_payload.events import State, StateChanged
from ross_payload.orders import Stop


@pytest.fixture
def payload(sky):
    return Payload(sky())


class Disk:
    """What has a stop outlive the process, as a test wants it."""

    def __init__(self):
        self.saved, self.failure = False, ""


@pytest.fixture
def disk():
    return Disk()


@pytest.fixture
def lasting(sky, disk):
    """A payload whose stops outlive its process."""
    return Payload(sky(), disk)


def test_a_stop_is_obeyed_at_once_and_acknowledged_when_it_is_on_the_disk(lasting, disk):
    assert lasting.command(STOP, seconds=0.05) == []
    assert lasting.stopped
    disk.saved = True
    assert lasting.results(STOP, 0.05) == [ACCEPTED]
    assert lasting.texts == []


def test_the_sender_of_a_stop_hears_that_a_hung_disk_keeps_its_answer_and_later_that_it_is_forgotten(lasting):
    assert lasting.command(STOP, seconds=1.9) == [IN_PROGRESS]
    assert lasting.results(STOP, 0.2) == [ACCEPTED], "it is obeyed all the same"
    assert lasting.texts == ["stopped, but a restart clears it: the disk does not respond"]


def test_a_stop_that_a_full_disk_does_not_take_is_accepted_and_the_disk_is_named(lasting, disk):
    disk.saved, disk.failure = True, "/var/lib/ross/stopped: No space left on device"
    assert lasting.command(STOP, seconds=0.05) == [ACCEPTED]
    assert lasting.texts == ["stopped, but a restart clears it: /var/lib/ross/stopped: No space left on device"]


def test_a_stop_that_waits_for_what_is_refused_is_forgotten_for_that_reason(lasting, disk):
    disk.failure = "/var/lib/ross/stopped: can't start new thread"
    assert lasting.command(STOP, seconds=1.9) == [IN_PROGRESS]
    assert lasting.results(STOP, 0.2) == [ACCEPTED]
    assert lasting.texts == ["stopped, but a restart clears it: /var/lib/ross/stopped: can't start new thread"]


def test_every_sender_of_a_stop_is_answered(lasting, disk):
    for _ in range(3):
        lasting.ground.long(STOP)
    lasting.wait(0.05)
    disk.saved = True
    assert lasting.command(STOP, seconds=0.05) == [ACCEPTED]


def test_a_stop_is_given_and_accepted_with_the_poll_that_hears_it(payload):
    payload.command(TURN, 90, seconds=0.1)
    payload.computing = True
    payload.ground.long(STOP)
    heard = payload.wait(0.01)
    assert payload.stopped
    assert [m.result for m in heard if m.get_type() == "COMMAND_ACK" and m.command == STOP] == [ACCEPTED]


@pytest.mark.parametrize("state", list(State))
def test_a_stop_is_obeyed_in_every_state(payload, state):
    payload.server.on_event(StateChanged(0.0, state))
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
