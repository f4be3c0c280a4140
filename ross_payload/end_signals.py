"""The signals that ask a program to end."""

from __future__ import annotations

import math
import signal
import time
from types import FrameType

PASSED_ON_S = 2.0  # within this, signals to end mean one: a script that passes it on first waits for what else it runs


def end_signals() -> tuple[signal.Signals, ...]:
    """Return Ctrl-C, SIGTERM and, unless it is ignored as under nohup, SIGHUP: the terminal has gone."""
    hang_up = getattr(signal, "SIGHUP", None)  # not on every system
    heard = hang_up is not None and signal.getsignal(hang_up) is not signal.SIG_IGN
    return signal.SIGINT, signal.SIGTERM, *((hang_up,) if heard else ())


class Interrupter:
    """A handler that raises a KeyboardInterrupt, and remembers the signal; not for one that is passed on.

    That would cut off what the first one has begun, as the deceleration of a motor.

    An exception out of a handler may come to nothing: Python ignores it where it runs a weak reference's callback, as
    while something is imported, and libraries make others of it.
    """

    def __init__(self) -> None:
        self.caught: signal.Signals | None = None
        self._raised = -math.inf  # when [s]

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Interrupt."""
        self.caught = signal.Signals(number)
        now = time.monotonic()
        if now - self._raised > PASSED_ON_S:
            self._raised = now
            raise KeyboardInterrupt


def caught_signal() -> signal.Signals | None:
    """Return the signal to end that came while an `Interrupter` was to handle it; None: there was none."""
    handlers = [signal.getsignal(number) for number in end_signals()]
    return next((each.caught for each in handlers if isinstance(each, Interrupter)), None)
