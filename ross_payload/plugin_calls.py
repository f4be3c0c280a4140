"""Calls of plug-ins that are under way, so that one which never returns can be named.

A plug-in may compute for ever, or wait for a device that has gone. Nobody can end its call; whoever waits can be told
which one it is.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple, TypeVar

T = TypeVar("T")

LOOK_S = 1.0  # between two looks
LATE_LOOKS = 15  # that find the same call under way: then it is late; a server that is started later has 10 s
REPEAT_LOOKS = 60  # after which it is told again

log = logging.getLogger(__name__)


class PluginCall(NamedTuple):
    """One call."""

    who: str  # the plug-in in words
    method: str

    def __str__(self) -> str:
        return f"{self.who}: {self.method}"


_under_way: dict[int, PluginCall] = {}  # by thread, the innermost one


def called(who: str, method: str, call: Callable[[], T]) -> T:
    """Call a plug-in, and let everybody know meanwhile.

    >>> called("separator 'theirs'", "batch", lambda: [str(each) for each in _under_way.values()])
    ["separator 'theirs': batch"]
    """
    thread = threading.get_ident()
    outer = _under_way.get(thread)
    _under_way[thread] = PluginCall(who, method)
    try:
        return call()
    finally:
        if outer is None:
            del _under_way[thread]
        else:
            _under_way[thread] = outer


class LateCalls:
    """Looks which calls do not return, and says so in the log; `in_words` is for any thread."""

    def __init__(self) -> None:
        self._looks: dict[int, tuple[PluginCall, int]] = {}  # by thread, the same call in so many looks

    def in_words(self) -> tuple[str, ...]:
        """Return the calls that are late."""
        return tuple(str(call) for call, looks in self._looks.values() if looks >= LATE_LOOKS)

    def look(self) -> None:
        """Look once."""
        before = self._looks
        found = {}
        for thread, call in dict(_under_way).items():
            known, looks = before.get(thread, (None, 0))
            found[thread] = call, looks + 1 if known is call else 1
        self._looks = found
        for call, looks in found.values():
            if looks % REPEAT_LOOKS == LATE_LOOKS:
                log.warning("%s has not returned for %.0f s: what needs it stands still", call, looks * LOOK_S)


@contextmanager
def telling_late_calls() -> Iterator[LateCalls]:
    """Say of every call that does not return which it is, as long as this lasts."""
    done, late = threading.Event(), LateCalls()

    def work() -> None:
        while not done.wait(LOOK_S):
            late.look()

    thread = threading.Thread(target=work, name="late plug-ins", daemon=True)
    try:
        thread.start()
    except RuntimeError as error:  # the system has no thread left: all else goes on
        log.warning("plug-ins that hang are not told: %s", error)
    try:
        yield late
    finally:
        done.set()
