"""What a ground station without our dialect can show: numbers with names, and an array of azimuths.

Angles are degrees here, clockwise from 0 to 360, as on a compass: people read them.
"""

from __future__ import annotations

from collections.abc import Sequence

from ross_payload.health import AudioHealth
from ross_protocols.pairs import compass
from ross_protocols.values import Array, Named, Source, Status

AZIMUTHS = 1  # array_id


def named(status: Status, sources: Sequence[Source], health: AudioHealth | None, time: float) -> list[Named]:
    """Return the numbers that are known; ``time`` is since boot [s]."""
    heading = None if status.heading is None else compass(status.heading)
    target = next((compass(source.azimuth) for source in sources if source.target), None)
    numbers = {
        "ross_state": float(status.state),
        "ross_k": None if status.k is None else float(status.k),
        "ross_head": heading,
        "ross_tgt": target,
        "ross_score": status.score,
        "ross_level": None if health is None else max(health.level_db),
    }
    return [Named(time, name, number) for name, number in numbers.items() if number is not None]


def azimuths(time_usec: int, sources: Sequence[Source]) -> Array:
    """Return K and then the azimuth of every source."""
    return Array(time_usec, "ross_az", AZIMUTHS, (float(len(sources)), *(compass(s.azimuth) for s in sources)))
