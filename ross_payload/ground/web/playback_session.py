"""One of a browser's two places to play a flight of the past in.

Whatever takes long runs on another thread, one thing at a time; of requests that come meanwhile the latest counts.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.playback import Playback
from ross_payload.ground.flights.reading import Flight, open_flight
from ross_payload.ground.flights.sound import Track, tracks_of
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.web.faults import report
from ross_payload.ground.web.view_cache import ViewCache, to_json
from ross_protocols.mavlink.component_id import ComponentId

STEP_PERIOD_S = 0.05  # between two steps
MAX_STEP_S = 0.5  # that is caught up with: a computer that is too slow for a speed plays as fast as it can
PROGRESS_PERIOD_S = 0.25  # between two words of how far it has come
READ_AHEAD_PERIOD_S = 0.15  # between two portions of the flight that are read ahead


class PlaybackSession:
    """Plays a flight from `start` to `close`; ``changed`` is called after every step."""

    def __init__(self, name: str, title: str, changed: Callable[[], None]) -> None:
        self.name, self.title = name, title
        self.watched: ComponentId | None = None
        self.playback: Playback | None = None
        self._changed = changed
        self._view, self._seen = ViewCache(), 0
        self._known: PayloadState | None = None  # of the watched, after the latest step
        self._requests: dict[str, float | bool] = {}
        self._requested = asyncio.Event()
        self._sought_times = 0
        self._sent: tuple[Any, ...] = ()
        self._sent_at = -PROGRESS_PERIOD_S
        self._fixed = ""  # what does not change, as text
        self._task: asyncio.Task[None] | None = None
        self._closed = False

    def start(self, find: Callable[[], Path], refuse: Callable[[str], None]) -> None:
        """Open the flight that ``find`` finds and play it; ``refuse`` is called with why that cannot be."""
        self._task = asyncio.create_task(self._run(find, refuse))

    async def close(self) -> None:
        """End; what is read on the other thread just now, too."""
        self._closed = True
        if self._task is not None:
            self._task.cancel()
            with suppress(asyncio.CancelledError):
                await self._task
        self._task = self.playback = None  # what was read is large: it does not wait for a collection of garbage

    def request(self, **changes: float | bool) -> None:
        """Ask for ``seek`` [s], ``play``, or ``speed`` (seconds of the flight in one)."""
        self._requests |= changes
        self._requested.set()

    def watch(self, who: ComponentId) -> None:
        """Show a payload."""
        self.watched, self._view, self._seen = who, ViewCache(), 0
        self._requested.set()

    def due(self) -> list[str]:
        """Return what is to be sent now."""
        playback = self.playback
        return [] if playback is None else [*self._state(playback), *self._payload(playback)]

    def _state(self, playback: Playback) -> list[str]:
        """How it plays: when that changed, and now and then how far it has come."""
        now, at = time.monotonic(), None if playback.playing else playback.at
        sent = (playback.playing, playback.speed, self._sought_times, at)
        if sent == self._sent and not (playback.playing and now - self._sent_at >= PROGRESS_PERIOD_S):
            return []
        self._sent, self._sent_at = sent, now
        moving = to_json({"at": playback.at, "playing": playback.playing, "speed": playback.speed})
        return [f"{self._fixed[:-1]},{moving[1:]}"]

    def _payload(self, playback: Playback) -> list[str]:
        if self.watched is None or self._known is None:
            return []
        self._view.update(self._known, {})
        sections = self._view.since(self._seen)
        if not sections:
            return []
        self._seen = self._view.number
        times = f'"now":{playback.at:.3f},"sent":{round(time.time() * 1e3)},"heard":null'
        head = f'{{"type":"payload","slot":"{self.name}","id":"{self.watched}"'
        return [f'{head},{times},"sections":{sections}}}']

    async def _run(self, find: Callable[[], Path], refuse: Callable[[str], None]) -> None:
        try:
            playback = await asyncio.to_thread(
                lambda: Playback(open_flight(find(), lambda: self._closed), self._is_obsolete)
            )
            tracks = await asyncio.to_thread(tracks_of, playback.flight)
            self._fixed = _fixed(self.name, self.title, playback.flight, tracks)
            self.watched = self.watched or next(iter(playback.flight.payloads), None)
            self.playback = playback
            await self._play(playback)
        except GroundError as error:
            refuse(error.message)
        except Exception as error:
            report(error)
            refuse("it cannot be played: see the terminal")

    def _is_obsolete(self) -> bool:
        """Whether nobody waits for what is being read any longer."""
        return self._closed or "seek" in self._requests

    async def _play(self, playback: Playback) -> None:
        """Do what is due, and show what is known after it, until cancelled."""
        before = time.monotonic()
        while True:
            self._look(playback)
            played = playback.playing
            with suppress(TimeoutError):
                await asyncio.wait_for(self._requested.wait(), _pause(playback))
            self._requested.clear()
            requests, self._requests = self._requests, {}
            now = time.monotonic()
            elapsed, before = min(now - before, MAX_STEP_S) if played else 0.0, now
            await asyncio.to_thread(_step, playback, requests, elapsed)
            self._sought_times += "seek" in requests

    def _look(self, playback: Playback) -> None:
        """Take what is known now: the playback's own is in motion while a step is done."""
        if self.watched is not None:
            self._known = playback.fleet.payloads.get(self.watched) or unheard(self.watched)
        self._changed()


def unheard(who: ComponentId) -> PayloadState:
    """Return what is known of a payload before its first word: nothing."""
    return PayloadState(who, first=math.inf, last=-math.inf)


def _pause(playback: Playback) -> float | None:
    """Return how long to wait for a request [s]; None: nothing else is due."""
    if playback.playing:
        return STEP_PERIOD_S
    return READ_AHEAD_PERIOD_S if playback.ready < playback.flight.duration else None


def _step(playback: Playback, requests: dict[str, float | bool], elapsed: float) -> None:
    """Fulfil requests, or go on by what has elapsed [s], or read ahead."""
    playback.speed = requests.get("speed", playback.speed)
    playback.playing = bool(requests.get("play", playback.playing))
    at_end = "play" in requests and playback.playing and playback.at >= playback.flight.duration
    if "seek" in requests or at_end:
        playback.seek(requests.get("seek", 0.0))
    elif playback.playing:
        playback.advance(elapsed)
    else:
        playback.prepare()


def _fixed(slot: str, title: str, flight: Flight, tracks: Sequence[Track]) -> str:
    return to_json(
        {
            "type": "flight",
            "slot": slot,
            "name": title,
            "start": flight.start,
            "simulated": flight.simulated,
            "duration": flight.duration,
            "payloads": [str(who) for who in flight.payloads],
            "marks": [{"at": mark.at, "words": mark.words, "id": str(mark.who)} for mark in flight.marks],
            "notes": list(flight.notes),
            "sound": [{"track": each.name, "begin": each.begin, "duration": each.duration} for each in tracks],
        }
    )
