"""How fast the rotors of a vehicle turn, as its autopilot tells: ESC_STATUS, ESC_TELEMETRY_*, RPM.

On the wire speeds are in revolutions per minute; here they are in revolutions per second, and positive either way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ross_protocols.mavlink.dialect import ross

STATUS, SENSORS, TELEMETRY = 291, 226, (11030, 11031, 11032)  # message ids: of PX4; ArduPilot's sensors, controllers
EACH = 4  # rotors of one message
FASTEST = 1000.0  # [1/s]: what turns faster is no rotor


def speeds_of(message: Any) -> dict[int, float] | None:
    """Return the speed [1/s] of rotors by number, from 0, that a message tells; None: any other message.

    >>> speeds_of(rotor_status(1.0, [90.0, -91.5]))
    {0: 90.0, 1: 91.5, 2: 0.0, 3: 0.0}
    """
    name = message.get_type()
    if name == "ESC_STATUS":
        return _numbered(message.index, message.rpm)
    if name == "RPM":
        return _numbered(0, (message.rpm1, message.rpm2))
    if name in ("ESC_TELEMETRY_1_TO_4", "ESC_TELEMETRY_5_TO_8", "ESC_TELEMETRY_9_TO_12"):
        return _numbered(EACH * TELEMETRY.index(message.get_msgId()), message.rpm)
    return None


def rotor_status(boot: float, speeds: Sequence[float]) -> Any:
    """Return the ESC_STATUS of up to four rotors at speeds [1/s], numbered from 0."""
    rpm, nothing = [round(60 * speed) for speed in _four(speeds)], [math.nan] * EACH
    return ross.MAVLink_esc_status_message(0, round(boot * 1e6), rpm, nothing, nothing)


def rotor_telemetry(speeds: Sequence[float], group: int, count: int) -> Any:
    """Return the ESC_TELEMETRY message ``group``, from 0, of up to four rotors at speeds [1/s]."""
    kinds = (
        ross.MAVLink_esc_telemetry_1_to_4_message,
        ross.MAVLink_esc_telemetry_5_to_8_message,
        ross.MAVLink_esc_telemetry_9_to_12_message,
    )
    nothing = [0] * EACH
    rpm = [min(round(60 * abs(speed)), 65535) for speed in _four(speeds)]
    return kinds[group](nothing, nothing, nothing, nothing, rpm, [count % 65536] * EACH)


def rotor_sensors(speeds: Sequence[float]) -> Any:
    """Return the RPM message of the first two rotors, at speeds [1/s]."""
    first, second, *_ = _four(speeds)
    return ross.MAVLink_rpm_message(60 * first, 60 * second)


def _numbered(first: int, rpm: Sequence[float]) -> dict[int, float]:
    found = {first + place: abs(each) / 60 for place, each in enumerate(rpm)}
    return {number: speed if speed < FASTEST else 0.0 for number, speed in found.items()}  # NaN is not below


def merged(speeds: Mapping[int, float]) -> tuple[float, ...]:
    """Speeds [1/s] in the order of the rotors, 0 for one that is not told; () when none turns.

    >>> merged({1: 90.0}), merged({0: 0.0})
    ((0.0, 90.0), ())
    """
    if not any(speeds.values()):
        return ()
    return tuple(speeds.get(number, 0.0) for number in range(max(speeds) + 1))


def _four(speeds: Sequence[float]) -> list[float]:
    return [*speeds, *[0.0] * EACH][:EACH]
