"""Waiting for something to become true, with a limit far beyond what it needs; never for a length of time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")
LIMIT_S = 60.0
LOOK_S = 0.005  # between two looks


def wait_for(found: Callable[[], T], seconds: float = LIMIT_S, what: object = "it") -> T:
    """Return what is found as soon as there is something."""
    end = time.monotonic() + seconds
    while not (thing := found()):
        assert time.monotonic() < end, f"waited {seconds:g} s in vain for {what() if callable(what) else what}"
        time.sleep(LOOK_S)
    return thing


async def wait_for_async(found: Callable[[], T]) -> T:
    """Return what is found as soon as there is something, and let others go on meanwhile."""
    async with asyncio.timeout(LIMIT_S):
        while not (thing := found()):
            await asyncio.sleep(LOOK_S)
    return thing
