"""The file that remembers a stop over a restart."""

import logging
import os
import stat
import threading
import time
from contextlib import closing

import pytest

from ross_payload.events import State, StateChanged
from ross_payload.orders import Cancel, Rearm, Shutdown, Stop
from ross_payload.service.stop_latch import StopLatch

STOPPED, IDLE = StateChanged(0.0, State.STOPPED), StateChanged(0.0, State.IDLE)


class Disk:
    """Takes files to be written when it is told to; knows what it was given, and may refuse."""

    def __init__(self):
        self.ready = threading.Event()
        self.ready.set()
        self.kinds, self.error = [], None

    def sync(self, descriptor):
        assert self.ready.wait(20)
        if self.error is not None:
            raise self.error
        self.kinds.append("folder" if stat.S_ISDIR(os.fstat(descriptor).st_mode) else "file")
        os.fsync(descriptor)


@pytest.fixture
def disk():
    return Disk()


@pytest.fixture
def latch(tmp_path, disk):
    with closing(StopLatch(tmp_path / "stopped", disk.sync, retry=0.01)) as latch:
        yield latch
        disk.ready.set()


def settled(latch):
    """The latch, when the disk has taken or refused everything."""
    end = time.monotonic() + 20
    while not latch.saved:
        assert time.monotonic() < end
        time.sleep(0.001)
    return latch


def test_a_stop_is_kept_from_its_order_on_for_the_owner_alone(latch, tmp_path):
    latch.ordered(Stop())
    assert settled(latch).closed
    assert (tmp_path / "stopped").stat().st_mode & 0o777 == 0o600


def test_a_stop_is_saved_when_the_disk_has_the_file_and_its_name(latch, disk):
    latch.ordered(Stop())
    settled(latch)
    assert disk.kinds == ["file", "folder"]


def test_a_disk_that_hangs_holds_nobody_up_and_nothing_is_called_saved(latch, disk):
    disk.ready.clear()
    begun = time.thread_time()
    latch.ordered(Stop())
    assert time.thread_time() - begun < 0.1
    assert not latch.saved
    disk.ready.set()
    assert settled(latch).closed


@pytest.mark.parametrize("order", [Cancel(), Shutdown()])
def test_other_orders_stop_nothing_for_good(latch, order):
    latch.ordered(order)
    assert not settled(latch).closed


def test_a_stop_that_nobody_ordered_is_kept_too(latch):
    latch.on_event(STOPPED, None)
    assert settled(latch).closed


@pytest.mark.parametrize("state", list(State))
def test_nothing_but_arming_again_takes_a_stop_back(latch, state):
    latch.ordered(Stop())
    latch.on_event(StateChanged(0.0, state), None)
    assert settled(latch).closed
    latch.ordered(Rearm())
    assert settled(latch).closed, "it is armed when the mission says so"
    latch.on_event(IDLE, None)
    assert not settled(latch).closed


def test_a_stop_is_taken_back_when_what_is_left_after_arming_is_a_fault_that_homing_clears(latch):
    latch.ordered(Stop())
    latch.ordered(Rearm())
    latch.on_event(StateChanged(0.0, State.FAULT), None)
    assert settled(latch).closed
    latch.on_event(StateChanged(0.0, State.DONE), None)
    assert not settled(latch).closed


def test_a_stop_right_behind_an_arming_stays(latch):
    """The mission says that it is armed before it hears of the second stop."""
    latch.ordered(Stop())
    latch.ordered(Rearm())
    latch.ordered(Stop())
    latch.on_event(IDLE, None)
    assert settled(latch).closed


def test_arming_without_a_stop_is_nothing(latch):
    latch.ordered(Rearm())
    latch.on_event(IDLE, None)
    assert not settled(latch).closed
    assert latch.failure == ""


def test_a_disk_that_takes_no_file_is_logged_once_and_tried_again(latch, disk, tmp_path, caplog):
    disk.error = OSError(28, "No space left on device")
    with caplog.at_level(logging.INFO):
        latch.ordered(Stop())
        latch.on_event(STOPPED, None)
        assert settled(latch).failure == f"{tmp_path / 'stopped'}: No space left on device"
        assert caplog.text.count("the stop was not saved") == 1
        disk.error = None
        end = time.monotonic() + 20
        while latch.failure:
            assert time.monotonic() < end
            time.sleep(0.001)
    assert disk.kinds == ["file", "folder"]
    assert "saved again" in caplog.text


def test_a_folder_that_is_gone_ends_nothing(tmp_path, caplog):
    with caplog.at_level(logging.ERROR), closing(StopLatch(tmp_path / "missing" / "stopped")) as latch:
        latch.ordered(Stop())
        settled(latch)
    assert "the stop was not saved: No such file or directory" in caplog.text


def test_closing_waits_until_everything_is_saved(tmp_path):
    latch = StopLatch(tmp_path / "stopped")
    latch.ordered(Stop())
    latch.close()
    assert latch.closed
    latch.close()


def test_a_stop_that_finds_no_thread_is_told_and_saved_with_the_next(latch, tmp_path, monkeypatch, caplog):
    def refused(thread):
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refused)
        latch.ordered(Stop())
        latch.close()
    assert (latch.saved, "can't start new thread" in latch.failure) == (False, True)
    assert "the stop was not saved: can't start new thread" in caplog.text
    latch.ordered(Stop())
    settled(latch)
    assert (latch.closed, latch.failure) == (True, "")
