"""The message about all payloads, links and places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ross_payload.ground.links.link import LinkState
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.health import condition, worst
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.triangulation import Bearing, bearings_of, cross
from ross_payload.ground.model.view import SECTIONS, picked
from ross_payload.ground.web.positions import FRESH_S, TYPED, PayloadPosition, Positions
from ross_protocols.mavlink.field_converters import compass

MAX_CROSSED = 8  # payloads: each pair of them is crossed


def overview(fleet: Fleet, links: Sequence[LinkState], positions: Positions, now: float) -> dict[str, Any]:
    """Return what the message of type ``fleet`` says of payloads, links and positions."""
    places = {who: place for who in fleet.payloads if (place := positions.of(who, fleet, now))}
    near = [who for who in places if now - fleet.payloads[who].last < FRESH_S][:MAX_CROSSED]
    bearings = [bearing for who in near for bearing in _bearings(fleet.payloads[who], places[who])]
    hidden, steadiest = fleet.hidden(now)
    return {
        "type": "fleet",
        "now": now,
        "payloads": [_row(each, places.get(each.who)) for each in fleet.payloads.values()],
        "hidden": {"count": hidden, "ids": [str(who) for who in steadiest]},
        "links": [picked(each, "url", "up", "bytes_s", "frames_s", "loss", "error", "last") for each in links],
        "fixes": [fix.json() for fix in cross(bearings)],
        "bearings": [_ray(each) for each in bearings],
        "places": {str(who): place.json() for who, place in places.items()},
    }


def _row(known: PayloadState, place: PayloadPosition | None) -> dict[str, Any]:
    who: Any = SECTIONS["standing"](known, {})
    where: Any = SECTIONS["pointing"](known, {})
    mission: Any = SECTIONS["mission"](known, {})
    return {
        "id": str(known.who),
        "state": who["state"],
        "state_at": known.state_at,
        "health_level": worst(condition(known)),
        "heading": where["heading"],
        "earth": known.earth,
        "k": mission["k"],
        "last": known.last,
        "target": mission["target"],
        "position": None if place is None else place.position(),
        "actuator": who["actuator"],
        "twin": known.twin,
    }


def _ray(bearing: Bearing) -> dict[str, Any]:
    """Return a bearing as the map draws it, degrees clockwise from north."""
    azimuth, sigma = compass(bearing.azimuth), math.degrees(bearing.sigma)
    return {"id": str(bearing.who), "source": bearing.source, "azimuth": azimuth, "sigma": sigma}


def _bearings(known: PayloadState, place: PayloadPosition) -> list[Bearing]:
    """An autopilot's heading is that of the vehicle; a typed one that of the mount."""
    typed = place.heading if place.source == TYPED else None
    mount = None if typed is None else math.radians(typed)
    return bearings_of(known, place.latitude, place.longitude, mount)
