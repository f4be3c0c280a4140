"""The signals that ask a program to end."""

from __future__ import annotations

import signal


def end_signals() -> tuple[signal.Signals, ...]:
    """Return Ctrl-C, SIGTERM and, unless it is ignored as under nohup, SIGHUP: the terminal has gone."""
    hang_up = () if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN else (signal.SIGHUP,)
    return signal.SIGINT, signal.SIGTERM, *hang_up
