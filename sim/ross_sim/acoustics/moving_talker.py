"""What is heard of a talker who walks: the responses of neighbouring places on the path, mixed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path as Folder

import numpy as np

from ross_payload.interfaces import Samples
from ross_sim.acoustics.impulse_responses import Responses
from ross_sim.acoustics.render import HeadingSignals, TalkerSignals
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.talkers.path import Path
from ross_sim.talkers.timeline import Timeline

REMEMBERED = 12  # nodes whose signals are kept

NodeSpec = Callable[[int], RoomSpec]


class ComputedResponses:
    """The impulse responses of a plane: quicker computed than read from disk; see `Responses`."""

    def __init__(self, spec: RoomSpec, n_taps: int) -> None:
        self.n_taps = n_taps
        self._spec = spec

    def at(self, heading: float) -> Samples:
        """Return the responses at a heading [rad], (2, n_sources, n_taps of this place)."""
        responses: Samples = respond(self._spec, [heading])[0]
        return responses


class KeptResponses(Responses):
    """The impulse responses of a true room, kept on disk, with as many taps as the longest of the path."""

    def __init__(self, spec: RoomSpec, n_taps: int, folder: Folder | None) -> None:
        super().__init__(spec, folder)
        self.n_taps = n_taps


class MovingTalker:
    """One talker on a path.

    The wet signals of the two positions of the grid between which the talker is are mixed linearly, sample by sample,
    as those of neighbouring headings are while the array turns: nothing clicks, and a talker who rests on a node is
    heard through the response of exactly that place.

    Parameters
    ----------
    timeline, gain
        What is said, and how loud.
    path
        Where it is said.
    spec_of
        The room with the talker at one position of the grid.
    n_taps
        Of the longest response along the path.
    rate
        [Hz].
    cache
        Folder of the room cache; None: see ``cache_folder``.
    """

    def __init__(
        self,
        timeline: Timeline,
        gain: float,
        path: Path,
        spec_of: NodeSpec,
        *,
        n_taps: int,
        rate: int,
        cache: Folder | None = None,
    ) -> None:
        self._path, self._rate = path, rate

        def signals(node: int) -> TalkerSignals:
            spec = spec_of(node)
            kept = len(spec.size) > 2 and spec.t60 > 0
            responses = KeptResponses(spec, n_taps, cache) if kept else ComputedResponses(spec, n_taps)
            return TalkerSignals([timeline], [gain], responses, rate)

        self._signals = lru_cache(REMEMBERED)(signals)

    def at(self, heading: float, first: int, last: int) -> Samples:
        """Return what is heard at a heading [rad] from sample ``first`` to before ``last``, (2, 1, n)."""
        places = self._path.grid_place(np.arange(first, last) / self._rate)
        lowest, highest = math.floor(places.min()), math.ceil(places.max())
        heard = np.zeros((2, 1, last - first), dtype=np.float32)
        for node in range(lowest, highest + 1):
            weight = np.clip(1 - np.abs(places - node), 0, 1).astype(np.float32)
            heard += weight * self._signals(node).at(heading, first, last)
        return heard


class MixedTalkers:
    """Talkers at rest and talkers who walk, in the order of the scenario."""

    def __init__(self, resting: HeadingSignals, walking: Sequence[MovingTalker], places: Sequence[int]) -> None:
        self._resting, self._walking, self._places = resting, walking, places

    def at(self, heading: float, first: int, last: int) -> Samples:
        """Return what is heard at a heading [rad] from sample ``first`` to before ``last``, (2, n_talkers, n)."""
        heard = self._resting.at(heading, first, last)
        for place, talker in zip(self._places, self._walking, strict=True):  # in rising order
            heard = np.insert(heard, place, talker.at(heading, first, last)[:, 0], axis=1)
        return heard
