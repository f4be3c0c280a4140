"""What of each component a log holds: frames, rates, losses, silence; no message but heartbeats is read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.ground.flights.reading import Flight, name_of, who_of
from ross_payload.ground.model.decoder_state import DecoderState, without_listener
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.peers import is_routed

SILENCE_S = 3.0  # [s] without a frame that are told


@dataclass(frozen=True, slots=True)
class MessageRate:
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
class FrameStats:
    """What a log holds of one component."""

    who: ComponentId
    first: float  # [s]
    last: float  # [s]
    frames: int
    lost: int | None  # frames; None: some are missing, and a router may have kept them to itself
    tunnelled: bool  # some came inside TUNNEL
    kinds: tuple[MessageRate, ...]  # the most frequent first
    gaps: tuple[Gap, ...]


def tallies(flight: Flight) -> dict[ComponentId, FrameStats]:
    """Count the frames of every component."""
    senders = np.unique(flight.index.sender).tolist()
    routed = is_routed(without_listener([divmod(sender, 256) for sender in senders], _stations(flight)))
    return {who_of(sender): _tally(flight, sender, routed) for sender in senders}


def _stations(flight: Flight) -> set[ComponentId]:
    """Return the ground stations of a log, by the first heartbeat of every component."""
    beats = flight.packets(flight.index.first_heartbeats())
    packets = (packet for _, packet in beats if packet.message.type == common.MAV_TYPE_GCS)
    return {packet.sender for packet in packets}


def _missing(sequence: NDArray[np.uint8]) -> int:
    """Count the frames that are missing in the numbers of a component, which may have come on several links."""
    if (np.diff(sequence) == 1).all():
        return 0
    decoder = DecoderState()
    return sum(decoder.missing(number) for number in sequence.tolist())


def _tally(flight: Flight, sender: int, routed: bool) -> FrameStats:
    which = np.flatnonzero(flight.index.sender == sender)
    at, index = flight.at[which], flight.index
    tunnelled = bool(index.tunnelled[which].any())
    missing = _missing(index.sequence[which])
    lost = None if missing and (routed or tunnelled) else missing
    steps = np.diff(at)
    gaps = tuple(Gap(float(at[i]), float(steps[i])) for i in np.flatnonzero(steps > SILENCE_S))
    names, counts = np.unique(index.message[which], return_counts=True)
    span = float(at[-1] - at[0])
    pairs = sorted(zip(counts.tolist(), names.tolist(), strict=True), key=lambda pair: (-pair[0], pair[1]))
    kinds = (
        MessageRate(name_of(name), count, (count - 1) / span if count > 1 and span else None) for count, name in pairs
    )
    return FrameStats(who_of(sender), float(at[0]), float(at[-1]), len(which), lost, tunnelled, tuple(kinds), gaps)
