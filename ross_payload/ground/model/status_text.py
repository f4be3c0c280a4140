"""Texts for humans, put together again from the chunks in which they travel."""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass, field

from ross_payload.ground.model.payload_state import StatusText
from ross_protocols.mavlink.codec import TEXT_SIZE, Packet
from ross_protocols.mavlink.values import Text

PREFIX = "RoSS: "  # of the payload's texts
REST_TIMEOUT_S = 2.0  # for the rest of a text
EXPLANATION_S = 1.5  # around a refusal, in which the payload says why
GAP = " ... "
DONE, FORGET = (
    32,
    10.0,
)  # texts whose late doubles are known, and for how long [s]; a payload that restarts counts from the start
MOST_CHUNKS = 20  # of a text: 1000 characters


@dataclass(slots=True)
class _PartialText:
    severity: int
    at: float  # of its first chunk [s]
    parts: dict[int, str] = field(default_factory=dict)
    last: int | None = None  # chunk

    def may_have(self, text: Text) -> bool:
        """Tell whether a chunk may be one of this text: nothing that is known of it says otherwise."""
        beyond = self.last is not None and min(text.chunk, MOST_CHUNKS) > self.last
        return text.severity == self.severity and self.parts.get(text.chunk, text.text) == text.text and not beyond


class Texts:
    """The texts of one component. A lost chunk leaves a gap; its text waits for it for `REST_TIMEOUT_S`.

    The id of a text may be used again at once, by a component that has restarted: chunks that cannot belong to what
    came with it before begin another text.

    >>> from ross_protocols.mavlink.codec import chunks
    >>> from ross_protocols.mavlink.values import Severity
    >>> texts, (first, second) = Texts(), chunks(Severity.INFO, "a" * 50 + "b", 7)
    >>> texts.on_chunk(second, at=0.0), [text.text for text in texts.on_chunk(first, at=0.1)] == ["a" * 50 + "b"]
    ([], True)
    """

    def __init__(self) -> None:
        self._partial: OrderedDict[int, _PartialText] = OrderedDict()  # by the id of the text
        self._done: OrderedDict[int, tuple[float, _PartialText]] = OrderedDict()  # when [s] and what, by the same id

    def on_chunk(self, text: Text, at: float) -> list[StatusText]:
        """Take a chunk that came ``at`` a time [s]; return the texts that are whole, or will not be."""
        if not text.id:
            return [*self.completed(at), StatusText(at, int(text.severity), text.text)]
        begun = self._partial.get(text.id)
        if begun is None and self._is_double(text, at):
            return self.completed(at)
        given_up = []
        if begun is not None and not begun.may_have(text):
            given_up.append(_put_together(self._partial.pop(text.id), at))
        begun = self._partial.setdefault(text.id, _PartialText(int(text.severity), at))
        if text.chunk < MOST_CHUNKS:
            begun.parts[text.chunk] = text.text
        if len(text.text) < TEXT_SIZE:
            begun.last = min(text.chunk, MOST_CHUNKS)
        return given_up + self.completed(at)

    def _is_double(self, text: Text, at: float) -> bool:
        """Tell whether a chunk belongs to a text that is done."""
        done, begun = self._done.get(text.id, (-math.inf, None))
        return begun is not None and at - done < FORGET and begun.may_have(text)

    def completed(self, at: float) -> list[StatusText]:
        """Return the texts that are whole, or have waited long enough ``at`` a time [s], which may be infinite."""
        if not self._partial:
            return []
        over = [number for number, begun in self._partial.items() if _is_whole(begun) or at - begun.at > REST_TIMEOUT_S]
        texts = []
        for number in over:
            self._done.pop(number, None)
            begun = self._partial.pop(number)
            end = min(at, begun.at + REST_TIMEOUT_S)  # though it may be noticed later, when something comes
            self._done[number] = end, begun
            texts.append(_put_together(begun, end))
        while len(self._done) > DONE:
            self._done.popitem(last=False)
        return texts


class RecentTexts:
    """The texts of one component within `EXPLANATION_S`: one of them may say why something was refused."""

    def __init__(self) -> None:
        self._texts = Texts()
        self._latest: list[StatusText] = []

    def on_packet(self, packet: Packet, now: float) -> list[StatusText]:
        """Return the texts that are whole with a packet."""
        if packet.name != "STATUSTEXT" or not isinstance(packet.value, Text):
            return []
        fresh = self._texts.on_chunk(packet.value, now)
        self._latest = [*self.latest(now), *fresh]
        return fresh

    def latest(self, now: float) -> list[StatusText]:
        """Return the texts of the last `EXPLANATION_S`, the oldest first."""
        self._latest = [text for text in self._latest if now - text.at < EXPLANATION_S]
        return self._latest


def _is_whole(begun: _PartialText) -> bool:
    return begun.last is not None and all(index in begun.parts for index in range(begun.last + 1))


def _put_together(begun: _PartialText, at: float) -> StatusText:
    end = max(begun.parts, default=0) if begun.last is None else begun.last
    words = "".join(begun.parts.get(index, GAP) for index in range(end + 1))
    return StatusText(at, begun.severity, words if begun.last is not None else words + GAP.rstrip())
