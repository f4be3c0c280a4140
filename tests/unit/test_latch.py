"""The file that remembers a stop over a restart."""

import logging

import pytest

from ross_payload.events import State, StateChanged
from ross_payload.service.latch import StopLatch

STOPPED = StateChanged(0.0, State.STOPPED)


@pytest.fixture
def latch(tmp_path):
    return StopLatch(tmp_path / "stopped")


def test_a_stop_is_remembered_for_the_owner_alone(latch, tmp_path):
    latch.said(STOPPED, None)
    assert latch.closed
    assert (tmp_path / "stopped").stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("state", [state for state in State if state is not State.IDLE])
def test_nothing_but_arming_again_takes_a_stop_back(latch, state):
    latch.said(STOPPED, None)
    latch.said(StateChanged(0.0, state), None)
    assert latch.closed
    latch.said(StateChanged(0.0, State.IDLE), None)
    assert not latch.closed


def test_arming_without_a_stop_is_nothing(latch):
    latch.said(StateChanged(0.0, State.IDLE), None)
    assert not latch.closed


def test_a_disk_that_takes_no_file_is_logged_and_ends_nothing(tmp_path, caplog):
    with caplog.at_level(logging.ERROR):
        StopLatch(tmp_path / "missing" / "stopped").said(STOPPED, None)
    assert "the stop is not remembered" in caplog.text
