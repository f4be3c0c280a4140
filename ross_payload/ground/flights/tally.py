"""What of each component a log holds: frames, rates, losses and silence, counted without reading a message."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.ground.flights.reading import Flight, name_of
from ross_payload.ground.picture.known import Who

SILENCE = 3.0  # [s] without a frame that are told


@dataclass(frozen=True, slots=True)
class Kind:
    """Frames of one message; what TUNNEL carries counts as what it is."""

    name: str
    count: int
    rate: float | None  # [Hz], None: fewer than two


@dataclass(frozen=True, slots=True)
class Gap:
    """A time without a frame."""

    at: float  # since the first frame of the log [s]
    duration: float  # [s]


@dataclass(frozen=True, slots=True)
class Tally:
    """What a log holds of one component."""

    who: Who
    first: float  # [s]
    last: float  # [s]
    frames: int
    lost: int  # frames that are missing in the sequence
    tunnelled: bool  # some came inside TUNNEL
    kinds: tuple[Kind, ...]  # the most frequent first
    gaps: tuple[Gap, ...]


def tallies(flight: Flight) -> dict[Who, Tally]:
    """Count the frames of every component."""
    senders = np.unique(flight.index.sender).tolist()
    return {Who(sender >> 8, sender & 255): _tally(flight, sender) for sender in senders}


def _tally(flight: Flight, sender: int) -> Tally:
    which = np.flatnonzero(flight.index.sender == sender)
    at, index = flight.at[which], flight.index
    missing = np.diff(index.sequence[which].astype(int)) - 1 & 255
    lost = int(missing[missing < 128].sum())  # more is an order of two links, or a start
    steps = np.diff(at)
    gaps = tuple(Gap(float(at[i]), float(steps[i])) for i in np.flatnonzero(steps > SILENCE))
    names, counts = np.unique(index.message[which], return_counts=True)
    span = float(at[-1] - at[0])
    pairs = sorted(zip(counts.tolist(), names.tolist(), strict=True), key=lambda pair: (-pair[0], pair[1]))
    kinds = (Kind(name_of(name), count, (count - 1) / span if count > 1 and span else None) for count, name in pairs)
    who = Who(sender >> 8, sender & 255)
    tunnelled = bool(index.tunnelled[which].any())
    return Tally(who, float(at[0]), float(at[-1]), len(which), lost, tunnelled, tuple(kinds), gaps)
