"""Texts for humans, put together again from the chunks in which they travel."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field

from ross_payload.ground.picture.known import Said
from ross_protocols.codec import TEXT_SIZE
from ross_protocols.values import Text

PATIENCE = 2.0  # [s] for the rest of a text
GAP = " ... "
DONE, FORGET = 32, 10.0  # texts whose late doubles are known, and for how long [s]
MOST_CHUNKS = 20  # of a text: 1000 characters


@dataclass(slots=True)
class _Begun:
    severity: int
    at: float  # of its first chunk [s]
    parts: dict[int, str] = field(default_factory=dict)
    last: int | None = None  # chunk


class Texts:
    """The texts of one component. A lost chunk leaves a gap; its text waits for it for `PATIENCE`.

    >>> from ross_protocols.codec import chunks
    >>> from ross_protocols.values import Severity
    >>> texts, (first, second) = Texts(), chunks(Severity.INFO, "a" * 50 + "b", 7)
    >>> texts.heard(second, at=0.0), [said.text for said in texts.heard(first, at=0.1)] == ["a" * 50 + "b"]
    ([], True)
    """

    def __init__(self) -> None:
        self._begun: OrderedDict[int, _Begun] = OrderedDict()  # by the id of the text
        self._done: OrderedDict[int, float] = OrderedDict()  # when [s], by the id of the text

    def heard(self, text: Text, at: float) -> list[Said]:
        """Take a chunk that came ``at`` a time [s]; return the texts that are whole, or will not be."""
        if not text.id:
            return [*self.waited(at), Said(at, int(text.severity), text.text)]
        if text.id in self._done and at - self._done[text.id] < FORGET:
            return self.waited(at)
        begun = self._begun.setdefault(text.id, _Begun(int(text.severity), at))
        if text.chunk < MOST_CHUNKS:
            begun.parts[text.chunk] = text.text
        if len(text.text) < TEXT_SIZE:
            begun.last = min(text.chunk, MOST_CHUNKS)
        return self.waited(at)

    def waited(self, at: float) -> list[Said]:
        """Return the texts that are whole, or have waited long enough ``at`` a time [s]."""
        if not self._begun:
            return []
        over = [number for number, begun in self._begun.items() if _is_whole(begun) or at - begun.at > PATIENCE]
        said = [_put_together(self._begun.pop(number), at) for number in over]
        for number in over:
            self._done.pop(number, None)
            self._done[number] = at
        while len(self._done) > DONE:
            self._done.popitem(last=False)
        return said


def _is_whole(begun: _Begun) -> bool:
    return begun.last is not None and all(index in begun.parts for index in range(begun.last + 1))


def _put_together(begun: _Begun, at: float) -> Said:
    end = max(begun.parts, default=0) if begun.last is None else begun.last
    words = "".join(begun.parts.get(index, GAP) for index in range(end + 1))
    return Said(at, begun.severity, words if begun.last is not None else words + GAP.rstrip())
