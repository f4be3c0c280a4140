"""What one talker says, sample by sample: a recording in a loop, with a start, an end and pauses."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Samples

FADE = 0.005  # of every edit [s]
NEVER = 2.0**62  # [samples]; a start that is later does not come


@dataclass(frozen=True, slots=True)
class Timeline:
    """A recording that begins at ``start``, repeats for ever and is muted after ``end`` and in ``pauses``.

    The recording runs on through a pause. Every edit fades linearly in 5 ms inside the talking, so that nothing is
    heard before a start, after an end or in a pause.

    >>> talk = Timeline.of(np.ones(1000, dtype=np.float32), rate=1000, start=2.0, end=2.5)
    >>> talk.between(1998, 2007).astype(float).round(1).tolist()
    [0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0]
    >>> talk.between(2495, 2502).astype(float).round(1).tolist()
    [1.0, 0.8, 0.6, 0.4, 0.2, 0.0, 0.0]
    >>> bool(talk.between(2500, 9000).any())
    False
    """

    speech: Samples  # (n,), faded at both ends
    start: int  # [samples]
    end: float  # [samples], may be infinite
    pauses: tuple[tuple[float, float], ...]  # [samples]
    fade: float  # [samples]

    @classmethod
    def of(
        cls,
        speech: Samples,
        rate: int,
        start: float = 0.0,
        end: float | None = None,
        pauses: Sequence[tuple[float, float]] = (),
    ) -> Timeline:
        """Make one from times [s]."""
        fade = FADE * rate
        edge = np.arange(speech.size, dtype=np.float32)
        faded = speech * np.clip(np.minimum(edge, edge[::-1]) / fade, 0, 1)
        return cls(
            speech=faded.astype(np.float32),
            start=round(min(start * rate, NEVER)),
            end=math.inf if end is None else end * rate,
            pauses=tuple((begin * rate, stop * rate) for begin, stop in pauses),
            fade=fade,
        )

    def between(self, first: int, last: int) -> Samples:
        """Return the samples from ``first`` to before ``last``, (last - first,)."""
        index = np.arange(first, last)
        gain = (index >= self.start) * np.clip((self.end - index) / self.fade, 0, 1)
        for begin, stop in self.pauses:
            gain *= np.clip(np.maximum(begin - index, index - stop) / self.fade, 0, 1)
        if not gain.any():
            return np.zeros(index.size, dtype=np.float32)
        said = self.speech[(index - self.start) % self.speech.size]
        return np.asarray(said * gain, dtype=np.float32)
