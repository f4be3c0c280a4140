"""What is heard while the array turns: periods for the explorer, and pieces at nearly one heading for the voices."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ross_payload.angles import circular_mean, difference, wrap
from ross_payload.dsp.dc_offset import without_offset
from ross_payload.interfaces import Input, Samples
from ross_payload.localization.turning import BEFORE_S, Turned
from ross_payload.mission.context import Listening, speeds_by_hop

SHORTEST_S = 0.5  # piece [s]
AROUND_S = 0.5  # heard before and after a piece, to learn from [s]


@dataclass(slots=True)
class HeardTurning:
    """All that was heard since the array began to turn."""

    rate: int  # [Hz]
    _blocks: list[Samples] = field(default_factory=list)
    _ends: list[int] = field(default_factory=list)  # samples heard at the end of every hop
    _headings: list[float] = field(default_factory=list)  # in the middle of every hop [rad], not wrapped
    _aboard: list[float] = field(default_factory=list)  # the same in the frame of the vehicle
    _speeds: list[tuple[float, ...]] = field(default_factory=list)  # of the rotors at the beginning of every hop [1/s]
    _first: int = 0  # hop with which the period begins

    @property
    def samples(self) -> int:
        """Samples of the present period."""
        return self._end(len(self._blocks)) - self._end(self._first)

    def begin(self) -> None:
        """Begin a period."""
        self._first = len(self._blocks)

    def add(self, hop: Input) -> None:
        """Hear a hop."""
        heading = hop.heading_start + wrap(hop.pointing.heading - hop.heading_start) / 2
        base = hop.attitude.yaw + wrap(hop.pointing.base - hop.attitude.yaw) / 2
        self._blocks.append(hop.block.samples)
        self._ends.append(self._end(len(self._ends)) + hop.block.samples.shape[1])
        self._headings.append(heading)
        self._aboard.append(heading - base)
        self._speeds.append(hop.attitude.rotor_speeds)

    def period(self) -> Turned:
        """The present period, and what was heard right before it."""
        start = self._end(self._first)
        first = self._first
        while first and start - self._end(first - 1) <= BEFORE_S * self.rate:
            first -= 1
        samples = without_offset(np.concatenate(self._blocks[first:], axis=1))
        headings, aboard = np.array(self._headings[first:]), np.array(self._aboard[first:])
        return Turned(samples, headings, start - self._end(first), aboard, speeds_by_hop(self._speeds[first:]))

    def pieces(self, turned: float) -> list[Listening]:
        """Cut all of it where the array has turned by an angle [rad], but not into pieces that are too short."""
        if not self._blocks:
            return []
        samples, headings = without_offset(np.concatenate(self._blocks, axis=1)), np.unwrap(self._headings)
        cuts, shortest = [0], SHORTEST_S * self.rate
        for hop, heading in enumerate(headings):
            long = self._end(hop) - self._end(cuts[-1]) >= shortest <= self._ends[-1] - self._end(hop)
            if long and abs(heading - headings[cuts[-1]]) >= turned:
                cuts.append(hop)
        return [self._piece(samples, first, last) for first, last in pairwise([*cuts, len(headings)])]

    def _piece(self, samples: Samples, first: int, last: int) -> Listening:
        begin, end, around = self._end(first), self._end(last), round(AROUND_S * self.rate)
        headings = np.array(self._headings[first:last])
        mean = circular_mean(headings)
        return Listening(
            mean,
            samples[:, begin:end],
            float(np.abs(difference(headings, mean)).max()),
            headings,
            circular_mean(self._aboard[first:last]),
            speeds_by_hop(self._speeds[first:last]),
            around=(samples[:, max(begin - around, 0) : begin], samples[:, end : end + around]),
        )

    def _end(self, hops: int) -> int:
        return self._ends[hops - 1] if hops else 0
