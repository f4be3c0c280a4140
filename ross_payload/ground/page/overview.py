"""The message about all payloads, links and places."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ross_payload.ground.links.link import LinkState
from ross_payload.ground.page.places import FRESH, TYPED, Place
from ross_payload.ground.picture.bearings import Bearing, bearings_of, cross
from ross_payload.ground.picture.condition import condition, worst
from ross_payload.ground.picture.known import Payload, Who
from ross_payload.ground.picture.view import SECTIONS
from ross_protocols.pairs import compass

if TYPE_CHECKING:
    from ross_payload.ground.page.hub import Hub

MOST_CROSSED = 8  # payloads: each pair of them is crossed


def at_once(hub: Hub) -> Any:
    """Return what is told as soon as it changes; the rest can wait."""
    payloads = hub.station.fleet.payloads.values()
    states = [(each.who, each.boots, each.twin, each.status and each.status.state) for each in payloads]
    links = [(each.url, each.up, each.error) for each in hub.station.links()]
    return states, links, hub.control.version, hub.hands.orders.doing, dict(hub.places.typed), hub.over


def overview(hub: Hub, now: float) -> dict[str, Any]:
    """Return the message of type ``fleet``."""
    fleet = hub.station.fleet
    places = {who: place for who in fleet.payloads if (place := hub.places.of(who, fleet, now))}
    hidden, steadiest = fleet.hidden(now)
    return {
        "type": "fleet",
        "now": now,
        "payloads": [_row(each, places.get(each.who)) for each in fleet.payloads.values()],
        "hidden": {"count": hidden, "ids": [str(who) for who in steadiest]},
        "links": [_link(each) for each in hub.station.links()],
        "fixes": fixes(fleet.payloads, places, now),
        "bearings": [_ray(each) for each in bearings(fleet.payloads, places, now)],
        "places": {str(who): place.json() for who, place in places.items()},
        "advice": "" if hub.over else hub.station.advice(),
        "over": hub.over,
    }


def _row(known: Payload, place: Place | None) -> dict[str, Any]:
    who: Any = SECTIONS["standing"](known, {})
    where: Any = SECTIONS["pointing"](known, {})
    mission: Any = SECTIONS["mission"](known, {})
    return {
        "id": str(known.who),
        "state": who["state"],
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


def _link(link: LinkState) -> dict[str, Any]:
    return {
        "url": link.url,
        "up": link.up,
        "bytes_s": link.bytes_s,
        "frames_s": link.frames_s,
        "loss": link.loss,
        "error": link.error,
        "last": link.last,
    }


def fixes(payloads: dict[Who, Payload], places: dict[Who, Place], now: float) -> list[dict[str, Any]]:
    """Return where the bearings of payloads cross."""
    return [fix.json() for fix in cross(bearings(payloads, places, now))]


def bearings(payloads: dict[Who, Payload], places: dict[Who, Place], now: float) -> list[Bearing]:
    """Return the bearings of payloads that were heard lately and stand somewhere."""
    near = [who for who in places if now - payloads[who].last < FRESH][:MOST_CROSSED]
    return [bearing for who in near for bearing in _bearings(payloads[who], places[who])]


def _ray(bearing: Bearing) -> dict[str, Any]:
    """Return a bearing as the map draws it, degrees clockwise from north."""
    azimuth, sigma = compass(bearing.azimuth), math.degrees(bearing.sigma)
    return {"id": str(bearing.who), "source": bearing.source, "azimuth": azimuth, "sigma": sigma}


def _bearings(known: Payload, place: Place) -> list[Bearing]:
    """An autopilot's heading is that of the vehicle; a typed one that of the mount."""
    typed = place.heading if place.source == TYPED else None
    mount = None if typed is None else math.radians(typed)
    return bearings_of(known, place.latitude, place.longitude, mount)
