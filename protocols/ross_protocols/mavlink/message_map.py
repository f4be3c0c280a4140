"""How each value lies in its message.

A layout maps every field of a MAVLink message to an attribute of a value and a pair of functions, there and back; a
bitmask field maps to the attributes that are its bits.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ross_protocols.mavlink import field_converters as c
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport


class Field(NamedTuple):
    """An attribute and how it is written."""

    attribute: str
    pair: c.Pair


Bits = dict[str, int]  # attribute -> bit
Fields = dict[str, "Field | Bits"]  # by the field's name on the wire


@dataclass(frozen=True, slots=True)
class Layout:
    """A kind of value, its message and its fields."""

    value: type
    message: Any
    fields: Fields
    constant: dict[str, Any] = field(default_factory=dict)  # what the other fields of the message are

    def write(self, value: v.Value) -> Any:
        """Return the MAVLink message of a value."""
        wire: dict[str, Any] = dict(self.constant)
        for name, kept in self.fields.items():
            if isinstance(kept, Field):
                wire[name] = kept.pair.there(getattr(value, kept.attribute))
            else:
                wire[name] = sum(bit for attribute, bit in kept.items() if getattr(value, attribute))
        return self.message(**wire)

    def read(self, message: Any) -> v.Value:
        """Return the value of a MAVLink message."""
        attributes: dict[str, Any] = {}
        for name, kept in self.fields.items():
            wire = getattr(message, name)
            if isinstance(kept, Field):
                attributes[kept.attribute] = kept.pair.back(wire)
            else:
                attributes |= {attribute: bool(wire & bit) for attribute, bit in kept.items()}
        value: v.Value = self.value(**attributes)
        return value


def _same(pair: c.Pair, *names: str) -> Fields:
    return {name: Field(name, pair) for name in names}


TIME = _same(c.INTEGER, "time_usec")
EARTH: Fields = {"frame": Field("earth", c.FRAME)}

HEARTBEAT = Layout(
    v.Heartbeat,
    common.MAVLink_heartbeat_message,
    {"system_status": Field("health", c.member(v.Health)), "custom_mode": Field("state", c.INTEGER)},
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
    _same(c.member(v.Severity), "severity")
    | _same(c.text(50), "text")
    | _same(c.INTEGER, "id")
    | {"chunk_seq": Field("chunk", c.INTEGER)},
)
INFORMATION = Layout(
    v.Information,
    ross.MAVLink_ross_information_message,
    TIME
    | _same(c.INTEGER, "dialect_version", "k_max")
    | _same(c.NUMBER, "spacing", "speed_of_sound")
    | _same(c.text(16), "actuator")
    | _same(c.text(24), "software_version")
    | {
        "axis_offset": Field("axis_offset", c.DIRECTION),
        "joint_min": Field("joint_upper", c.MAYBE_TURNED),
        "joint_max": Field("joint_lower", c.MAYBE_TURNED),
        "joint_rate_max": Field("joint_speed", c.MAYBE_NUMBER),
        "orientation_time": Field("unit", c.NUMBER),
        "sample_rate": Field("rate", c.INTEGER),
    },
)
STATUS = Layout(
    v.Status,
    ross.MAVLink_ross_status_message,
    TIME
    | EARTH
    | _same(c.INTEGER, "state")
    | _same(c.FEW, "rotation", "rotation_max")
    | _same(c.MAYBE_INDEX, "outcome", "k", "target")
    | _same(c.MAYBE_DIRECTION, "heading", "heading_goal", "mount_yaw")
    | _same(c.MAYBE_TURNED, "joint", "joint_rate")
    | _same(c.MAYBE_NUMBER, "score", "criterion")
    | {
        "mission_time": Field("mission_time", c.MILLI),
        "flags": {
            "noise_measured": 1,
            "certain": 2,
            "target_found": 4,
            "time_unix": 8,
            "streaming": 16,
            "recording": 32,
        },
        "actuator_flags": {"actuator_present": 1, "settled": 2, "homed": 4, "fault": 8, "open_loop": 16},
    },
)
SOURCE = Layout(
    v.Source,
    ross.MAVLink_ross_source_message,
    TIME
    | EARTH
    | _same(c.WRAPPED16, "estimate")
    | _same(c.INTEGER, "source", "count")
    | _same(c.DIRECTION, "azimuth")
    | _same(c.MAYBE_NUMBER, "elevation", "score")
    | _same(c.NUMBER, "confidence", "weight")
    | _same(c.ADDED_NUMBER, "age")
    | {
        "azimuth_mirror": Field("mirror", c.MAYBE_DIRECTION),
        "azimuth_sigma": Field("sigma", c.NUMBER),
        "azimuth_rate": Field("rate", c.ADDED_TURNED),
        "flags": {"resolved": 1, "target": 2, "final": 4, "tracked": 8},
    },
)
ALIGNMENT = Layout(
    v.Alignment,
    ross.MAVLink_ross_alignment_message,
    TIME
    | EARTH
    | _same(c.WRAPPED16, "plan")
    | _same(c.INTEGER, "candidate", "count", "source")
    | _same(c.DIRECTION, "heading")
    | _same(c.TURNED, "joint")
    | _same(c.MICRO, "isolation")
    | _same(c.MEMBERS, "aliased")
    | _same(c.ADDED_NUMBER, "gain")
    | _same(c.member(v.Rule), "rule")
    | _same(c.member(v.CandidateState), "state"),
)
SEPARATION = Layout(
    v.Separation,
    ross.MAVLink_ross_separation_message,
    TIME
    | EARTH
    | _same(c.WRAPPED16, "separation")
    | _same(c.INTEGER, "group", "count")
    | _same(c.member(v.Phase), "phase")
    | _same(c.MEMBERS, "members")
    | _same(c.MAYBE_DIRECTION, "heading")
    | _same(c.MAYBE_NUMBER, "score", "criterion", "si_sdr")
    | _same(c.text(16), "method")
    | {"si_sdr_improvement": Field("si_sdri", c.MAYBE_NUMBER), "flags": {"accepted": 1, "target": 2}},
)

AUDIO = Layout(
    v.Audio,
    ross.MAVLink_ross_audio_message,
    TIME
    | _same(c.INTEGER, "trouble")
    | _same(c.WRAPPED16, "reopened")
    | _same(c.WRAPPED32, "lost")
    | _same(c.NUMBERS, "level", "peak")
    | _same(c.NUMBER, "waiting")
    | _same(c.MAYBE_NUMBER, "rate"),
)
RECORDING = Layout(
    v.Recording,
    ross.MAVLink_ross_recording_message,
    TIME
    | _same(c.member(v.RecordingState), "state")
    | _same(c.NUMBER, "duration")
    | _same(c.MAYBE_MEBI, "free")
    | _same(c.text(40), "name")
    | _same(c.text(48), "reason"),
)
DENSITY = Layout(
    v.Density,
    ross.MAVLink_ross_density_message,
    TIME
    | EARTH
    | _same(c.WRAPPED16, "exploration")
    | _same(c.FEW, "rotation")
    | _same(c.DIRECTION, "heading")
    | _same(c.SHARES, "density")
    | {"itd_first": Field("first", c.MICRO), "itd_last": Field("last", c.MICRO)},
)
ISOLATION = Layout(
    v.Isolation,
    ross.MAVLink_ross_isolation_message,
    TIME
    | EARTH
    | _same(c.WRAPPED16, "plan")
    | _same(c.INTEGER, "source")
    | _same(c.MICRO, "maximum")
    | _same(c.SHARES, "isolation")
    | {"heading_first": Field("first", c.TURNED), "heading_last": Field("last", c.TURNED)},
)
LINK = Layout(
    v.LinkReport,
    ross.MAVLink_ross_link_message,
    TIME
    | _same(c.WRAPPED32, "sent", "dropped", "received", "bad", "refused")
    | _same(c.MAYBE_COUNT, "lost")
    | _same(c.WRAPPED16, "reconnects")
    | _same(c.INTEGER, "link", "count")
    | _same(c.text(60), "url")
    | {"flags": {"up": 1, "autopilot": 2}},
)
STREAM = Layout(
    StreamReport,
    ross.MAVLink_ross_stream_message,
    TIME
    | EARTH
    | _same(c.INTEGER, "number", "count", "rate", "port")
    | _same(c.member(Selection), "selection")
    | _same(c.member(Codec), "codec")
    | _same(c.MAYBE_INDEX, "source", "group")
    | _same(c.MAYBE_FEW, "listeners")
    | _same(c.MAYBE_DIRECTION, "azimuth")
    | _same(c.NUMBER, "gain")
    | _same(c.MAYBE_DECIBEL, "level")
    | _same(c.MAYBE_MILLI16, "delay")
    | _same(c.WRAPPED32, "lost")
    | _same(c.MAYBE_COUNT, "packets_lost")
    | _same(c.text(10), "sink")
    | _same(c.text(40), "address")
    | _same(c.text(24), "detail")
    | {"flags": {"on": 1, "fault": 2, "muted": 4, "records": 8, "separated": 16}},
)
NAMED = Layout(
    v.Named,
    common.MAVLink_named_value_float_message,
    {"time_boot_ms": Field("time", c.MILLI), "name": Field("name", c.text(10)), "value": Field("value", c.NUMBER)},
)
ARRAY = Layout(
    v.Array,
    common.MAVLink_debug_float_array_message,
    TIME | _same(c.text(10), "name") | {"array_id": Field("id", c.INTEGER), "data": Field("numbers", c.PADDED)},
)

LAYOUTS = (
    HEARTBEAT, TEXT, INFORMATION, STATUS, SOURCE, ALIGNMENT, SEPARATION, AUDIO, RECORDING, DENSITY, ISOLATION, LINK,
    STREAM, NAMED, ARRAY,
)  # fmt: skip
