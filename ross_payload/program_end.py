"""The end of a program, which waits for nobody for ever.

Python waits at its end for every thread that is no daemon, without a word: also for one that a plug-in has started and
that never ends. And a last line is written until somebody reads it.
"""

from __future__ import annotations

import os
import select
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress

LAST_LINE_S = 5.0  # that whoever reads the standard error may take for the last line
TELL_S = 5.0  # after which threads are named that the end waits for
LEAVE_S = 10.0  # after which it does not wait for them any more
LOOK_S = 0.1  # between two looks whether Python has begun to end
STANDARD_ERROR = 2  # its descriptor


@contextmanager
def ending(code: int) -> Iterator[None]:
    """Write the last line of a program within this; then, or a few seconds later, the process ends with ``code``.

    Once the main thread is over the others have `LEAVE_S`; those that are left are named. What waits on the standard
    output is written before: whoever reads that takes the time they need.
    """
    with suppress(OSError, ValueError):
        sys.stdout.flush()
    written = threading.Event()
    with suppress(RuntimeError):  # the system has no thread left
        threading.Thread(target=_watch, args=(written, code), name="end", daemon=True).start()
    try:
        yield
    finally:
        written.set()


def end_within(seconds: float, code: int, waits_for: Callable[[], Iterable[str]]) -> Callable[[], None]:
    """Return what has the process end with ``code`` after this time, if it has not by then, and say what it waits for.

    It does not wait, and may be called by a handler of signals. Where ``waits_for`` is empty by then, the end waits for
    threads that Python joins.
    """
    begun = threading.Event()

    def end() -> None:
        begun.wait()
        threading.Event().wait(seconds)
        names = ", ".join(tuple(waits_for()) or _names())
        _say(f"ross: not ended after {seconds:g} s{names and f', waiting for {names}'}; it ends so")
        os._exit(code)

    with suppress(RuntimeError):  # the system has no thread left
        threading.Thread(target=end, name="end", daemon=True).start()
    return begun.set


def _watch(written: threading.Event, code: int) -> None:
    if not written.wait(LAST_LINE_S):
        os._exit(code)
    while not _is_over():
        threading.Event().wait(LOOK_S)
    threading.Event().wait(TELL_S)
    if names := _names():
        _say(
            f"ross: still waiting for a thread that has not ended: {', '.join(names)}; the program ends soon without it"
        )
    threading.Event().wait(LEAVE_S - TELL_S)
    with suppress(OSError, ValueError):
        sys.stdout.flush()
    os._exit(code)


def _is_over() -> bool:
    """Return whether Python has begun to end: it joins the threads of executors before the main one counts as over."""
    return getattr(threading, "_SHUTTING_DOWN", False) or not threading.main_thread().is_alive()


def _names() -> list[str]:
    """Return whom Python waits for at its end."""
    others = (thread for thread in threading.enumerate() if thread is not threading.main_thread())
    return [repr(thread.name) for thread in others if thread.is_alive() and not thread.daemon]


def _say(text: str) -> None:
    """Write a line to the standard error, if that takes it."""
    with suppress(OSError, ValueError):
        if select.select((), (STANDARD_ERROR,), (), 0)[1]:
            os.write(STANDARD_ERROR, f"{text}\n".encode("utf-8", "backslashreplace")[: select.PIPE_BUF])
