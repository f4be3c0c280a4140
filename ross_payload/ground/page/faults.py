"""Faults of the page itself: whoever watches keeps watching, and the terminal shows the traceback."""

from __future__ import annotations

import asyncio


def report(error: Exception) -> None:
    """Tell of a fault of the program on the terminal."""
    words = {"message": "ross ground: a fault of the page; please report it", "exception": error}
    asyncio.get_running_loop().call_exception_handler(words)
