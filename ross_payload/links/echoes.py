"""What we have sent, to know our own voice when it comes back."""

from __future__ import annotations

from collections import deque

MOST = 4096  # frames, about ten seconds of three busy links
HEAD, PAYLOAD = 4, 10  # where the sequence number and the payload of a frame begin


class Echoes:
    """The latest frames that went out on any link, whoever has signed them since."""

    def __init__(self) -> None:
        self._order: deque[int] = deque()
        self._known: set[int] = set()

    def sent(self, frame: bytes) -> None:
        """Remember a frame."""
        mark = _mark(frame)
        if mark in self._known:
            return
        self._known.add(mark)
        self._order.append(mark)
        if len(self._order) > MOST:
            self._known.remove(self._order.popleft())

    def knows(self, frame: bytes) -> bool:
        """Tell whether we have sent a frame: the same sequence number, sender, message and payload."""
        return _mark(frame) in self._known


def _mark(frame: bytes) -> int:
    return hash(frame[HEAD : PAYLOAD + frame[1]])
