"""Moments of a flight that somebody looks for: changes of the state, and texts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.ground.flights.tlog_index import NO_STATE, Index
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.status_text import PREFIX
from ross_payload.ground.model.view import word
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common

TEXT = common.MAVLINK_MSG_ID_STATUSTEXT
MOST = 2000


@dataclass(frozen=True, slots=True)
class Bookmark:
    """One moment."""

    at: float  # since the first frame [s]
    words: str
    who: ComponentId


def marks_of(
    index: Index,
    payloads: tuple[ComponentId, ...],
    duration: float,
    packets: Callable[[NDArray[np.int64]], Iterator[tuple[float, Packet]]],
) -> tuple[tuple[Bookmark, ...], float]:
    """Return the moments of all payloads, in order, and until when those are all [s]: later ones are too many.

    ``packets`` reads frames by number; ``duration`` is that of the flight [s].
    """
    which = np.sort(np.concatenate([_telling(index, who) for who in payloads] or [np.empty(0, np.int64)]))
    fleet, marks, until = Fleet(), list[Bookmark](), duration
    for at, packet in packets(which[:MOST]):
        who = packet.sender
        before = fleet.payloads.get(who)
        fleet.on_packet(packet, at)
        marks += _news(before, fleet.payloads.get(who), at)
        until = at if len(which) > MOST else duration
    known = dict(fleet.payloads)
    fleet.end(duration)
    for who, before in known.items():
        marks += _news(before, fleet.payloads[who], duration)
    return tuple(sorted(marks, key=lambda mark: mark.at)), until


def _telling(index: Index, who: ComponentId) -> NDArray[np.int64]:
    """Return the numbers of the frames of a payload in which the state changes, or that are a text."""
    mine = index.sent_by(who)
    status = np.flatnonzero(mine & (index.state != NO_STATE))
    changes = status[np.diff(index.state[status].astype(int), prepend=-1) != 0]
    return np.concatenate([changes, np.flatnonzero(mine & (index.message == TEXT))])


def _news(before: PayloadState | None, after: PayloadState | None, at: float) -> list[Bookmark]:
    """Tell what is new of a payload at a time [s], in words; of a text that was not whole it is seen later."""
    if after is None:
        return []
    was = before.status if before else None
    news = []
    if after.status is not None and (was is None or was.state != after.status.state):
        news.append(Bookmark(at, str(word("ROSS_STATE", after.status.state)).replace("_", " "), after.who))
    texts = after.texts_since(before)
    return [*news, *(Bookmark(text.at, text.text.removeprefix(PREFIX), after.who) for text in texts)]
