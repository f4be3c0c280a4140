"""Commands that are not for us, not known, not allowed, or of the other kind."""

import math

import pytest

from command_bench import (
    ACCEPTED,
    DENIED,
    FAILED,
    IN_PROGRESS,
    INFORM,
    LONG_ONLY,
    RECORD,
    STOP,
    TURN,
    UNSUPPORTED,
    Payload,
    near,
)
from ross_payload.orders import (
    TurnTo,
)
from ross_protocols.mavlink.dialect import ross

NAN = math.nan


@pytest.fixture
def payload(sky):
    return Payload(sky())


@pytest.mark.parametrize("number", [400, 185, 22, 54013, 65535, 0])
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
    assert near(payload.given[0], TurnTo(math.radians(-40)))


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
