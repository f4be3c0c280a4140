"""Where payloads stand: the autopilot says it, or somebody typed it; and where their bearings cross."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ross_payload.ground.model.fleet import Fleet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.field_converters import compass

FRESH_S = 10.0  # for which an autopilot's word counts
TYPED, AUTOPILOT = "typed", "autopilot"


@dataclass(frozen=True, slots=True)
class PayloadPosition:
    """Where a payload stands; ``heading`` is that of its mount's zero, where no autopilot knows it."""

    latitude: float  # [rad]
    longitude: float  # [rad]
    heading: float | None  # clockwise from north [deg]
    source: str  # `TYPED` or `AUTOPILOT`

    def position(self) -> dict[str, Any]:
        """Return latitude and longitude [deg]."""
        return {"lat": math.degrees(self.latitude), "lon": math.degrees(self.longitude)}

    def json(self) -> dict[str, Any]:
        """Return it in degrees."""
        return {**self.position(), "heading": self.heading, "from": self.source}


def typed_position(message: dict[str, Any]) -> PayloadPosition:
    """Read what somebody typed.

    Raises
    ------
    ValueError
        When a number is missing or out of range.
    """
    latitude, longitude = number(message, "lat", -90, 90), number(message, "lon", -180, 180)
    heading = None if message.get("heading") is None else number(message, "heading", -360, 360) % 360
    return PayloadPosition(math.radians(latitude), math.radians(longitude), heading, TYPED)


class Positions:
    """Typed places by payload, kept until the process ends; a fresh word of an autopilot counts more."""

    def __init__(self) -> None:
        self.typed: dict[ComponentId, PayloadPosition] = {}

    def of(self, who: ComponentId, fleet: Fleet, now: float) -> PayloadPosition | None:
        """Return where a payload stands; None: nobody knows."""
        vehicle = fleet.vehicles.get(who.system)
        if vehicle is None or now - vehicle.at > FRESH_S:
            return self.typed.get(who)
        place = vehicle.position
        heading = None if place.yaw is None else compass(place.yaw)
        return PayloadPosition(place.latitude, place.longitude, heading, AUTOPILOT)


def number(message: dict[str, Any], name: str, least: float, most: float) -> float:
    """Return a number of a message.

    Raises
    ------
    ValueError
        When it is none, or out of range.
    """
    found = message.get(name)
    if isinstance(found, bool) or not isinstance(found, int | float) or not least <= found <= most:
        raise ValueError(f"{name}: expected a number from {least:g} to {most:g}, got {str(found)[:20]}")
    return float(found)
