"""The pump thread of the system's clock survives a call that raises."""

from __future__ import annotations

import threading

import pytest

from ross_payload.clock import SystemClock


def test_a_call_that_raises_is_dropped_and_the_others_go_on() -> None:
    clock, died, lived = SystemClock(), threading.Event(), threading.Semaphore(0)

    def die() -> None:
        assert not died.is_set(), "called again"
        died.set()
        raise ZeroDivisionError

    clock.every(0.01, die)
    cancel = clock.every(0.01, lived.release)
    assert died.wait(5.0)
    for _ in range(5):
        assert lived.acquire(timeout=5.0)
    cancel()


def test_what_a_call_raised_comes_out_of_sleep_and_every() -> None:
    clock, died = SystemClock(), threading.Event()

    def die() -> None:
        died.set()
        raise ZeroDivisionError

    clock.every(0.01, die)
    assert died.wait(5.0)
    with pytest.raises(RuntimeError, match="a periodic call died: ZeroDivisionError") as caught:
        clock.sleep(0.05)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    with pytest.raises(RuntimeError, match="died"):
        clock.every(1.0, die)


def test_cancelling_one_of_two_equal_calls_leaves_the_other() -> None:
    clock, called = SystemClock(), threading.Semaphore(0)

    def call() -> None:
        called.release()

    cancels = [clock.every(0.01, call) for _ in range(2)]
    cancels[0]()
    for _ in range(3):
        assert called.acquire(timeout=5.0)
    cancels[1]()
