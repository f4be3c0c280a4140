"""DroneCAN: our own messages, defined in `protocols/dronecan/ross`; their angles are clockwise, these are not."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from ross_protocols.dronecan.messages import DroneCanError
from ross_protocols.mavlink.field_converters import clockwise

MOST_SOURCES = 8  # in one message
HALF_MAX = 65504.0  # the greatest float16
UNKNOWN = 255  # index or count
NAN = math.nan


def half(number: float | None) -> float:
    """Return what fits into a float16; None is not-a-number.

    >>> half(1e9), half(None)
    (65504.0, nan)
    """
    if number is None or math.isnan(number):
        return NAN
    return math.copysign(min(abs(number), HALF_MAX), number)


def _number(wire: float) -> float | None:
    return None if math.isnan(wire) else wire


def _direction(angle: float | None) -> float:
    return NAN if angle is None else clockwise(angle)


def _back(wire: float) -> float | None:
    return clockwise(wire) if math.isfinite(wire) else None


def _index(number: int | None) -> int:
    return UNKNOWN if number is None else min(number, UNKNOWN - 1)


def _known(wire: int) -> int | None:
    return None if wire == UNKNOWN else wire


def _mask(value: Any, names: Iterable[str]) -> int:
    return sum(1 << bit for bit, name in enumerate(names) if getattr(value, name))


def _flags(mask: int, names: Iterable[str]) -> dict[str, bool]:
    return {name: bool(mask >> bit & 1) for bit, name in enumerate(names)}


@dataclass(frozen=True, slots=True)
class RossStatus:
    """ross.Status: the mission at a glance."""

    NUMBER, SEED, PRIORITY = 20854, 0x6EB8, 20
    FLAGS: ClassVar[tuple[str, ...]] = (
        "earth", "actuator", "settled", "homed", "fault", "open_loop", "target_found", "certain",
    )  # fmt: skip
    _WIRE: ClassVar[struct.Struct] = struct.Struct("<BBBBBBffffee")

    state: int
    outcome: int | None = None  # None: not over
    k: int | None = None
    target: int | None = None  # index of a source
    rotation: int = 0
    heading: float | None = None  # [rad]
    heading_goal: float | None = None  # of a turn [rad]
    alignment: float | None = None  # where the array listens, or is to, for the sake of one source: a heading [rad]
    joint: float | None = None  # [rad], not wrapped
    score: float | None = None
    gain_db: float | None = None  # predicted SI-SDRi at the alignment [dB]
    earth: bool = False
    actuator: bool = False
    settled: bool = False
    homed: bool = False
    fault: bool = False
    open_loop: bool = False
    target_found: bool = False
    certain: bool = False

    def pack(self) -> bytes:
        """Write the payload."""
        return self._WIRE.pack(
            self.state,
            *(_index(number) for number in (self.outcome, self.k, self.target)),
            min(self.rotation, UNKNOWN),
            _mask(self, self.FLAGS),
            *(_direction(angle) for angle in (self.heading, self.heading_goal, self.alignment)),
            NAN if self.joint is None else -self.joint,
            half(self.score),
            half(self.gain_db),
        )

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        state, outcome, k, target, rotation, mask, heading, goal, alignment, joint, *halves = cls._WIRE.unpack(payload)
        turned = _number(joint)
        return cls(
            state=state,
            outcome=_known(outcome),
            k=_known(k),
            target=_known(target),
            rotation=rotation,
            heading=_back(heading),
            heading_goal=_back(goal),
            alignment=_back(alignment),
            joint=None if turned is None else -turned,
            score=_number(halves[0]),
            gain_db=_number(halves[1]),
            **_flags(mask, cls.FLAGS),
        )


@dataclass(frozen=True, slots=True)
class RossSource:
    """ross.Source: one source of an estimate."""

    FLAGS: ClassVar[tuple[str, ...]] = ("resolved", "target")
    WIRE: ClassVar[struct.Struct] = struct.Struct("<ffeeeBB")

    azimuth: float  # [rad]
    sigma: float  # [rad]
    confidence: float  # 0 to 1, in percent on the wire
    mirror: float | None = None  # where it may be instead [rad]
    elevation: float | None = None  # [rad], up
    score: float | None = None
    resolved: bool = False
    target: bool = False

    def pack(self) -> bytes:
        """Write its part of the payload."""
        percent = round(100 * min(max(self.confidence, 0.0), 1.0))
        angles = clockwise(self.azimuth), _direction(self.mirror)
        halves = (half(number) for number in (self.sigma, self.elevation, self.score))
        return self.WIRE.pack(*angles, *halves, percent, _mask(self, self.FLAGS))

    @classmethod
    def unpack(cls, values: tuple[Any, ...]) -> Self:
        """Read its part of a payload."""
        azimuth, mirror, sigma, elevation, score, percent, mask = values
        rest = _back(mirror), _number(elevation), _number(score)
        return cls(clockwise(azimuth), sigma, percent / 100, *rest, **_flags(mask, cls.FLAGS))


@dataclass(frozen=True, slots=True)
class RossSources:
    """ross.Sources: all sources of an estimate."""

    NUMBER, SEED, PRIORITY = 20855, 0x0917, 24

    estimate: int  # number of the estimate, modulo 256
    sources: tuple[RossSource, ...] = ()
    earth: bool = False
    final: bool = False

    def pack(self) -> bytes:
        """Write the payload; what is more than `MOST_SOURCES` is left out."""
        head = bytes([self.estimate % 256, _mask(self, ("earth", "final"))])
        return head + b"".join(source.pack() for source in self.sources[:MOST_SOURCES])

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload."""
        size = RossSource.WIRE.size
        if len(payload) % size != 2 or len(payload) > 2 + MOST_SOURCES * size:
            raise DroneCanError(f"sources of {len(payload)} bytes")
        sources = tuple(map(RossSource.unpack, RossSource.WIRE.iter_unpack(payload[2:])))
        return cls(payload[0], sources, **_flags(payload[1], ("earth", "final")))
