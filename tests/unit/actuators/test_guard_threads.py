"""The stop latch against threads and signals: a stop wins, whenever it comes."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from guard_bench import Device, bench
from ross_payload.errors import ActuatorError
from ross_payload.interfaces import ActuatorState


class Interrupted(Device):
    """Calls ``interrupt`` once, in the middle of its ``at``-th call of any method."""

    def __init__(self, at: int) -> None:
        super().__init__()
        self.left = at
        self.interrupt = lambda: None

    def _count(self) -> None:
        self.left -= 1
        if self.left == 0:
            self.interrupt()

    def state(self) -> ActuatorState:
        self._count()
        return super().state()

    def poll(self, now: float) -> None:
        self._count()
        super().poll(now)
        self._count()

    def _ask(self, method: str, what: str) -> None:
        self._count()
        super()._ask(method, what)
        self._count()


@contextmanager
def on_signal(call: object) -> Iterator[None]:
    before = signal.signal(signal.SIGUSR1, lambda *_: call())  # type: ignore[operator]
    try:
        yield
    finally:
        signal.signal(signal.SIGUSR1, before)


@pytest.fixture
def eager() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


request = st.sampled_from(["go", "go", "poll", "poll", "home", "release", "halt", "jam"])


@given(at=st.integers(1, 60), action=st.sampled_from(["hold", "park"]), requests=st.lists(request, max_size=12))
def test_a_stop_from_a_signal_in_the_middle_of_anything_ends_in_a_stop(
    at: int, action: str, requests: list[str]
) -> None:
    device = Interrupted(at)
    on = bench(device, on_fault=action, max_move_s=0.05)
    device.interrupt = lambda: signal.raise_signal(signal.SIGUSR1)
    asks = {
        "go": lambda: on.guard.command(1.0),
        "poll": lambda: on.clock.sleep(0.04),
        "home": on.guard.home,
        "release": on.guard.release,
        "halt": on.guard.halt,
        "jam": lambda: setattr(device, "jammed", True),
    }
    with on_signal(on.guard.stop):
        for each in requests:
            with suppress(ActuatorError):
                asks[each]()
    if not on.guard.stopped:
        return
    moved = [what for what in device.asked if what.startswith(("go", "home", "stop"))]
    assert not moved or moved[-1] == "stop"
    with pytest.raises(ActuatorError, match="re-arm"):
        on.guard.command(0.5)


@pytest.mark.usefixtures("eager")
def test_a_stop_from_many_threads_while_commands_race_ends_in_a_stop_every_time() -> None:
    for seed in range(60):
        on = bench()
        begin = threading.Barrier(4)

        def commands(begin: threading.Barrier = begin, guard: object = on.guard) -> None:
            begin.wait()
            for index in range(40):
                with suppress(ActuatorError):
                    guard.command(0.01 * index)  # type: ignore[attr-defined]

        def polls(begin: threading.Barrier = begin, guard: object = on.guard, clock: object = on.clock) -> None:
            begin.wait()
            for _ in range(40):
                guard.poll(clock.now())  # type: ignore[attr-defined]

        def stops(begin: threading.Barrier = begin, guard: object = on.guard, seed: int = seed) -> None:
            begin.wait()
            for _ in range(seed):
                guard.state()  # type: ignore[attr-defined]
            guard.stop()  # type: ignore[attr-defined]

        threads = [threading.Thread(target=each) for each in (commands, polls, stops, stops)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert on.device.asked[-1] == "stop"
        assert on.device.goal is None
        on.guard.rearm()
        on.guard.command(0.5)
