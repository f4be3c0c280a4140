"""How each value lies in its message: the only place where angles turn around and units change.

A layout maps every field of a MAVLink message to an attribute of a value and a pair of functions, there and back; a
bitmask field maps to the attributes that are its bits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ross_protocols import values as v
from ross_protocols.dialect import common, ross

FLOAT32_MAX = (2 - 2**-23) * 2.0**127
UINT8_MAX = 255


class Pair(NamedTuple):
    """From a value to the wire and back."""

    there: Callable[[Any], Any]
    back: Callable[[Any], Any]


class Field(NamedTuple):
    """An attribute and how it is written."""

    attribute: str
    pair: Pair


Bits = dict[str, int]  # attribute -> bit
Fields = dict[str, "Field | Bits"]  # by the field's name on the wire


@dataclass(frozen=True, slots=True)
class Layout:
    """A kind of value, its message and its fields."""

    value: type
    message: Any
    fields: Fields
    constant: dict[str, Any]

    def write(self, value: v.Value) -> Any:
        """Return the MAVLink message of a value."""
        wire: dict[str, Any] = dict(self.constant)
        for name, field in self.fields.items():
            if isinstance(field, Field):
                wire[name] = field.pair.there(getattr(value, field.attribute))
            else:
                wire[name] = sum(bit for attribute, bit in field.items() if getattr(value, attribute))
        return self.message(**wire)

    def read(self, message: Any) -> v.Value:
        """Return the value of a MAVLink message."""
        attributes: dict[str, Any] = {}
        for name, field in self.fields.items():
            wire = getattr(message, name)
            if isinstance(field, Field):
                attributes[field.attribute] = field.pair.back(wire)
            else:
                attributes |= {attribute: bool(wire & bit) for attribute, bit in field.items()}
        value: v.Value = self.value(**attributes)
        return value


def wrap(angle: float) -> float:
    """Wrap an angle [rad] into (-pi, pi].

    >>> wrap(-math.pi) == math.pi
    True
    """
    return math.pi - (math.pi - angle) % (2 * math.pi)


def float32(number: float) -> float:
    """Return what fits into a float on the wire; beyond its range that is infinity, as IEEE 754 rounds."""
    return math.copysign(math.inf, number) if abs(number) > FLOAT32_MAX else float(number)


def clockwise(angle: float) -> float:
    """Turn a direction [rad] around, from counter-clockwise to clockwise or back, into (-pi, pi].

    >>> clockwise(math.pi / 2) == -math.pi / 2
    True
    """
    return wrap(-angle) if math.isfinite(angle) else angle


def bits(indices: tuple[int, ...]) -> int:
    """Return the bitmask of some indices.

    >>> bits((0, 2))
    5
    """
    return sum(1 << index for index in set(indices))


def indices(mask: int) -> tuple[int, ...]:
    """Return the indices in a bitmask, ascending.

    >>> indices(5)
    (0, 2)
    """
    return tuple(index for index in range(32) if mask >> index & 1)


def known(pair: Pair, invalid: float) -> Pair:
    """Write None as ``invalid`` (NaN is one), and read it as None."""

    def is_invalid(wire: float) -> bool:
        return math.isnan(wire) if math.isnan(invalid) else wire == invalid

    return Pair(
        lambda value: invalid if value is None else pair.there(value),
        lambda wire: None if is_invalid(wire) else pair.back(wire),
    )


def text(size: int) -> Pair:
    """Write ASCII, cut to ``size`` characters; what is not ASCII becomes a question mark."""
    return Pair(lambda value: value.encode("ascii", "replace")[:size], str)


def member(kind: type) -> Pair:
    """Write an enumeration as its number; a number that it does not have stays a number."""
    numbers = {int(entry): entry for entry in kind}  # type: ignore[attr-defined]
    return Pair(int, lambda wire: numbers.get(wire, wire))


INTEGER = Pair(int, int)
NUMBER = Pair(float32, float)
DIRECTION = Pair(clockwise, clockwise)
TURNED = Pair(lambda angle: float32(0.0 - angle), lambda wire: 0.0 - wire)  # not wrapped, and never -0.0
MICRO = Pair(lambda seconds: float32(seconds * 1e6), lambda wire: wire / 1e6)
MILLI = Pair(lambda seconds: round(seconds * 1e3), lambda wire: wire / 1e3)
WRAPPED16 = Pair(lambda number: number % 65536, int)
FRAME = Pair(lambda earth: 1 if earth else 2, lambda wire: wire == 1)
MEMBERS = Pair(bits, indices)
MAYBE_NUMBER, MAYBE_DIRECTION, MAYBE_TURNED = (known(pair, math.nan) for pair in (NUMBER, DIRECTION, TURNED))
MAYBE_INDEX = known(INTEGER, UINT8_MAX)


def _same(pair: Pair, *names: str) -> Fields:
    return {name: Field(name, pair) for name in names}


TIME = _same(INTEGER, "time_usec")
EARTH: Fields = {"frame": Field("earth", FRAME)}

HEARTBEAT = Layout(
    v.Heartbeat,
    common.MAVLink_heartbeat_message,
    {"system_status": Field("health", member(v.Health)), "custom_mode": Field("state", INTEGER)},
    constant={
        "type": common.MAV_TYPE_ONBOARD_CONTROLLER,
        "autopilot": common.MAV_AUTOPILOT_INVALID,
        "base_mode": common.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED,
        "mavlink_version": 3,
    },
)
TEXT = Layout(
    v.Text,
    common.MAVLink_statustext_message,
    _same(member(v.Severity), "severity")
    | _same(text(50), "text")
    | _same(INTEGER, "id")
    | {"chunk_seq": Field("chunk", INTEGER)},
    constant={},
)
INFORMATION = Layout(
    v.Information,
    ross.MAVLink_ross_information_message,
    TIME
    | _same(INTEGER, "dialect_version", "k_max")
    | _same(NUMBER, "spacing", "speed_of_sound")
    | _same(text(16), "actuator")
    | _same(text(24), "software_version")
    | {
        "axis_offset": Field("axis_offset", DIRECTION),
        "joint_min": Field("joint_upper", MAYBE_TURNED),
        "joint_max": Field("joint_lower", MAYBE_TURNED),
        "joint_rate_max": Field("joint_speed", MAYBE_NUMBER),
        "orientation_time": Field("unit", NUMBER),
        "sample_rate": Field("rate", INTEGER),
    },
    constant={},
)
STATUS = Layout(
    v.Status,
    ross.MAVLink_ross_status_message,
    TIME
    | EARTH
    | _same(INTEGER, "state", "rotation", "rotation_max")
    | _same(MAYBE_INDEX, "outcome", "k", "target")
    | _same(MAYBE_DIRECTION, "heading", "heading_goal", "mount_yaw")
    | _same(MAYBE_TURNED, "joint", "joint_rate")
    | _same(MAYBE_NUMBER, "score", "criterion")
    | {
        "mission_time": Field("mission_time", MILLI),
        "flags": {"noise_measured": 1, "certain": 2, "target_found": 4},
        "actuator_flags": {"actuator_present": 1, "settled": 2, "homed": 4, "fault": 8, "open_loop": 16},
    },
    constant={},
)
SOURCE = Layout(
    v.Source,
    ross.MAVLink_ross_source_message,
    TIME
    | EARTH
    | _same(WRAPPED16, "estimate")
    | _same(INTEGER, "source", "count")
    | _same(DIRECTION, "azimuth")
    | _same(MAYBE_NUMBER, "elevation", "score")
    | _same(NUMBER, "confidence", "weight")
    | {
        "azimuth_mirror": Field("mirror", MAYBE_DIRECTION),
        "azimuth_sigma": Field("sigma", NUMBER),
        "flags": {"resolved": 1, "target": 2, "final": 4},
    },
    constant={},
)
ALIGNMENT = Layout(
    v.Alignment,
    ross.MAVLink_ross_alignment_message,
    TIME
    | EARTH
    | _same(WRAPPED16, "plan")
    | _same(INTEGER, "candidate", "count", "source")
    | _same(DIRECTION, "heading")
    | _same(TURNED, "joint")
    | _same(MICRO, "isolation")
    | _same(MEMBERS, "aliased")
    | _same(member(v.Rule), "rule")
    | _same(member(v.CandidateState), "state"),
    constant={},
)
SEPARATION = Layout(
    v.Separation,
    ross.MAVLink_ross_separation_message,
    TIME
    | EARTH
    | _same(WRAPPED16, "separation")
    | _same(INTEGER, "group", "count")
    | _same(member(v.Phase), "phase")
    | _same(MEMBERS, "members")
    | _same(MAYBE_DIRECTION, "heading")
    | _same(MAYBE_NUMBER, "score", "criterion", "si_sdr")
    | _same(text(16), "method")
    | {
        "si_sdr_improvement": Field("si_sdri", MAYBE_NUMBER),
        "flags": {"accepted": 1, "target": 2},
    },
    constant={},
)

LAYOUTS = (HEARTBEAT, TEXT, INFORMATION, STATUS, SOURCE, ALIGNMENT, SEPARATION)
