"""Playing a flight: the fleet as it was known at any moment."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ross_payload.ground.flights.reading import Flight
from ross_payload.ground.model.fleet import Fleet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common

SPACING = 500  # frames at least between two moments that are remembered: about 40 ms of work
MOST_KEPT = 2000  # moments that are remembered
SLOWEST, FASTEST = 1.0, 64.0
POSITION = common.MAVLINK_MSG_ID_GLOBAL_POSITION_INT


class Playback:
    """The fleet at one moment of a flight; the same whether that moment was played or sought.

    What was read once is found again after hearing `SPACING` frames at most, unless the log is huge. `prepare` reads
    ahead in small portions: seeking before ``ready`` [s] is quick, seeking beyond it reads all that lies between, which
    may take minutes. It is given up as soon as ``obsolete`` says that nobody waits for it, and is to be followed by
    another seek then.
    """

    def __init__(self, flight: Flight, obsolete: Callable[[], bool] = lambda: False) -> None:
        self.flight = flight
        self._obsolete = obsolete
        self.fleet = Fleet()
        self.at = 0.0  # since the first frame [s]
        self.playing = False
        self._speed = 1.0
        self._which = relevant_frames(flight, flight.payloads)
        self._times = flight.at[self._which]
        self._spacing = max(SPACING, len(self._which) // MOST_KEPT)
        self._known = 0  # frames of those that ``fleet`` knows
        self._kept: list[Fleet] = [Fleet()]  # after every ``_spacing`` frames
        self.seek(0.0)

    @property
    def speed(self) -> float:
        """How many seconds of the flight go by in one."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._speed = min(max(SLOWEST, speed), FASTEST)

    @property
    def ready(self) -> float:
        """Until when seeking is quick [s]."""
        known = len(self._kept) * self._spacing
        return self.flight.duration if known >= len(self._times) else float(self._times[known])

    def seek(self, at: float) -> None:
        """Go to a time [s]; all frames until then, and of then, are heard."""
        self.at = min(max(0.0, at), self.flight.duration)
        wanted = int(np.searchsorted(self._times, self.at, side="right"))
        near = min(wanted // self._spacing, len(self._kept) - 1)
        if wanted < self._known or near * self._spacing > self._known:
            self.fleet, self._known = self._kept[near].copy(), near * self._spacing
        self._known = self._read(self.fleet, self._known, wanted)

    def advance(self, duration: float) -> None:
        """Go on by a duration [s] of whoever watches, when playing; stop at the end."""
        if not self.playing:
            return
        self.seek(self.at + duration * self.speed)
        self.playing = self.at < self.flight.duration

    def prepare(self) -> float:
        """Read some frames ahead of all that was read; return which share of the flight is quick to seek in."""
        known = (len(self._kept) - 1) * self._spacing
        if known + self._spacing < len(self._times):
            self._read(self._kept[-1].copy(), known, known + self._spacing)
        return min(len(self._kept) * self._spacing / max(len(self._times), 1), 1.0)

    def _read(self, fleet: Fleet, known: int, wanted: int) -> int:
        """Let a fleet that knows ``known`` frames read more, and remember it on the way; return how many it knows."""
        while known < wanted and not self._obsolete():
            until = min(wanted, (known // self._spacing + 1) * self._spacing)
            for at, packet in self.flight.packets(self._which[known:until]):
                fleet.on_packet(packet, at)
            known = until
            if known == len(self._kept) * self._spacing:
                self._kept.append(fleet.copy())
        return known


def relevant_frames(flight: Flight, payloads: tuple[ComponentId, ...]) -> NDArray[np.int64]:
    """Return the numbers of the frames that change what is known of payloads, and of where vehicles are.

    The first frame and the first heartbeat of everybody who is no payload tell whether a router passes on what these
    say.
    """
    index = flight.index
    mine = np.flatnonzero(index.sent_by(*payloads) | (index.message == POSITION))
    firsts = np.concatenate([np.unique(index.sender, return_index=True)[1], index.first_heartbeats()])
    return np.union1d(mine, firsts[~index.sent_by(*flight.payloads)[firsts]])
