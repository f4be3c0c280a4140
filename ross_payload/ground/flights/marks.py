"""Moments of a flight that somebody looks for: changes of the state, and texts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ross_payload.ground.flights.scan import NO_STATE, Index
from ross_payload.ground.picture.fleet import Fleet
from ross_payload.ground.picture.known import Payload, Who
from ross_payload.ground.picture.view import word
from ross_protocols.codec import Packet
from ross_protocols.dialect import common

TEXT = common.MAVLINK_MSG_ID_STATUSTEXT
MOST = 2000
OUR_NAME = "RoSS: "


@dataclass(frozen=True, slots=True)
class Mark:
    """One moment."""

    at: float  # since the first frame [s]
    words: str
    who: Who


def marks_of(
    index: Index, payloads: tuple[Who, ...], packets: Callable[[NDArray[np.int64]], Iterator[tuple[float, Packet]]]
) -> tuple[Mark, ...]:
    """Return the first `MOST` moments of all payloads, in order; ``packets`` reads frames by number."""
    which = np.concatenate([_telling(index, who) for who in payloads] or [np.empty(0, np.int64)])
    fleet, marks = Fleet(), list[Mark]()
    for at, packet in packets(np.sort(which)[:MOST]):
        who = Who(packet.system_id, packet.component_id)
        before = fleet.payloads.get(who)
        fleet.hear(packet, at)
        marks += [Mark(at, words, who) for words in _news(before, fleet.payloads.get(who))]
    return tuple(marks)


def _telling(index: Index, who: Who) -> NDArray[np.int64]:
    """Return the numbers of the frames of a payload in which the state changes, or that are a text."""
    mine = index.sender == 256 * who.system + who.component
    status = np.flatnonzero(mine & (index.state != NO_STATE))
    changes = status[np.diff(index.state[status].astype(int), prepend=-1) != 0]
    return np.concatenate([changes, np.flatnonzero(mine & (index.message == TEXT))])


def _news(before: Payload | None, after: Payload | None) -> list[str]:
    """Tell what is new of a payload, in words."""
    if after is None:
        return []
    was = before.status if before else None
    news = []
    if after.status is not None and (was is None or was.state != after.status.state):
        news.append(str(word("ROSS_STATE", after.status.state)).replace("_", " "))
    if after.texts and (before is None or after.texts[-1] is not (before.texts or (None,))[-1]):
        news.append(after.texts[-1].text.removeprefix(OUR_NAME))
    return news
