"""The pump thread of the system's clock survives a call that raises."""

from __future__ import annotations

import threading
import time

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
    with pytest.raises(RuntimeError, match="a periodic call failed: ZeroDivisionError") as caught:
        clock.sleep(0.05)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    with pytest.raises(RuntimeError, match="failed"):
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


def test_when_cancelling_returns_the_last_call_is_over() -> None:
    clock, inside, over = SystemClock(), threading.Event(), threading.Event()

    def call() -> None:
        inside.set()
        time.sleep(0.2)
        over.set()

    cancel = clock.every(0.01, call)
    assert inside.wait(5.0)
    cancel()
    assert over.is_set()


def test_a_call_may_cancel_itself_and_one_that_hangs_is_waited_for_no_longer_than_a_second() -> None:
    clock, inside, cancelled, go_on = SystemClock(), threading.Event(), threading.Event(), threading.Event()

    def call() -> None:
        inside.set()
        go_on.wait(20.0)
        cancel()
        cancelled.set()

    cancel = clock.every(0.01, call)
    assert inside.wait(5.0)
    cancel()
    assert not cancelled.is_set()
    go_on.set()
    assert cancelled.wait(5.0)
