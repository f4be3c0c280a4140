"""Which signals ask a program to end."""

from __future__ import annotations

import signal
import time

import pytest

from ross_payload.end_signals import PASSED_ON_S, Interrupter, end_signals


def test_a_terminal_that_goes_away_is_a_reason_to_end_unless_it_is_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        assert end_signals() == (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
        assert end_signals() == (signal.SIGINT, signal.SIGTERM)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_signal_that_is_passed_on_does_not_cut_off_what_the_first_has_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the deceleration of a motor: `ross actuators probe --move` left it at full speed."""
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    interrupt = Interrupter()
    with pytest.raises(KeyboardInterrupt):
        interrupt(signal.SIGINT, None)
    now[0] += 0.03
    interrupt(signal.SIGTERM, None)
    assert interrupt.caught is signal.SIGTERM
    now[0] += PASSED_ON_S
    with pytest.raises(KeyboardInterrupt):
        interrupt(signal.SIGINT, None)
