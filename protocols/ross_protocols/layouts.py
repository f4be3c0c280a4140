"""How each value lies in its message.

A layout maps every field of a MAVLink message to an attribute of a value and a pair of functions, there and back; a
bitmask field maps to the attributes that are its bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from ross_protocols import values as v
from ross_protocols.dialect import common, ross
from ross_protocols.pairs import (
    ADDED_NUMBER,
    DIRECTION,
    FRAME,
    INTEGER,
    MAYBE_COUNT,
    MAYBE_DIRECTION,
    MAYBE_INDEX,
    MAYBE_MEBI,
    MAYBE_NUMBER,
    MAYBE_TURNED,
    MEMBERS,
    MICRO,
    MILLI,
    NUMBER,
    NUMBERS,
    PADDED,
    SHARES,
    TURNED,
    WRAPPED16,
    WRAPPED32,
    Pair,
    member,
    text,
)  # fmt: skip


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
        "flags": {"noise_measured": 1, "certain": 2, "target_found": 4, "time_unix": 8},
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
    | _same(ADDED_NUMBER, "gain")
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

AUDIO = Layout(
    v.Audio,
    ross.MAVLink_ross_audio_message,
    TIME
    | _same(INTEGER, "trouble")
    | _same(WRAPPED16, "reopened")
    | _same(WRAPPED32, "lost")
    | _same(NUMBERS, "level", "peak")
    | _same(NUMBER, "waiting")
    | _same(MAYBE_NUMBER, "rate"),
    constant={},
)
RECORDING = Layout(
    v.Recording,
    ross.MAVLink_ross_recording_message,
    TIME
    | _same(member(v.RecordingState), "state")
    | _same(NUMBER, "duration")
    | _same(MAYBE_MEBI, "free")
    | _same(text(40), "name")
    | _same(text(48), "reason"),
    constant={},
)
DENSITY = Layout(
    v.Density,
    ross.MAVLink_ross_density_message,
    TIME
    | EARTH
    | _same(WRAPPED16, "exploration")
    | _same(INTEGER, "rotation")
    | _same(DIRECTION, "heading")
    | _same(SHARES, "density")
    | {"itd_first": Field("first", MICRO), "itd_last": Field("last", MICRO)},
    constant={},
)
ISOLATION = Layout(
    v.Isolation,
    ross.MAVLink_ross_isolation_message,
    TIME
    | EARTH
    | _same(WRAPPED16, "plan")
    | _same(INTEGER, "source")
    | _same(MICRO, "maximum")
    | _same(SHARES, "isolation")
    | {"heading_first": Field("first", TURNED), "heading_last": Field("last", TURNED)},
    constant={},
)
LINK = Layout(
    v.LinkReport,
    ross.MAVLink_ross_link_message,
    TIME
    | _same(WRAPPED32, "sent", "dropped", "received", "bad", "refused")
    | _same(MAYBE_COUNT, "lost")
    | _same(WRAPPED16, "reconnects")
    | _same(INTEGER, "link", "count")
    | _same(text(60), "url")
    | {"flags": {"up": 1, "autopilot": 2}},
    constant={},
)
NAMED = Layout(
    v.Named,
    common.MAVLink_named_value_float_message,
    {"time_boot_ms": Field("time", MILLI), "name": Field("name", text(10)), "value": Field("value", NUMBER)},
    constant={},
)
ARRAY = Layout(
    v.Array,
    common.MAVLink_debug_float_array_message,
    TIME | _same(text(10), "name") | {"array_id": Field("id", INTEGER), "data": Field("numbers", PADDED)},
    constant={},
)

LAYOUTS = (
    HEARTBEAT, TEXT, INFORMATION, STATUS, SOURCE, ALIGNMENT, SEPARATION, AUDIO, RECORDING, DENSITY, ISOLATION, LINK,
    NAMED, ARRAY,
)  # fmt: skip
