"""Live listening for the page beside a scripted mission, on threads of its own.

The mission computes in lock-step, and may stand still for a moment while it does. What is heard is given out a little
later than it was simulated, so that nobody hears that; and the mission is the same, whether somebody listens or not.
"""

from __future__ import annotations

import threading
from collections import deque
from pathlib import Path
from queue import SimpleQueue

from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.events import Event
from ross_payload.interfaces import Input
from ross_payload.listening.observers import LiveListening
from ross_payload.pointing import Pointing
from ross_sim.paced_clock import Pacer
from ross_sim.sitl.pace import ListenedSpeed

LEAD_S = 1.5  # by which a mission is ahead of what is heard of it: more than it computes at once
KEPT = 1000  # hops of which it is known where the array pointed: those under way to the stage
LAST_CALL_S = 5.0  # beyond the lead, that the rest may take at the end


class PacedTime(SystemClock):
    """Simulated time as it should be by the pace, whatever the mission computes."""

    def __init__(self, pacer: Pacer) -> None:
        super().__init__()
        self._pacer = pacer

    def now(self) -> float:
        """Return the simulated time [s]."""
        return self._pacer.now()


class PageVoices(LiveListening):
    """Listens to a mission that is held back by ``pacer``; gives out what was heard `LEAD_S` later.

    Parameters
    ----------
    config
        Everything; its own streams are those of the mission.
    speed
        What the pacer asks; told of the streams, it holds the mission back to real time while one is on.
    pacer
        Holds the mission back, on its thread.
    """

    def __init__(self, config: Config, speed: ListenedSpeed, pacer: Pacer) -> None:
        listening = config.listening.model_copy(update={"streams": ()})
        config = config.model_copy(update={"listening": listening})
        super().__init__(config, PacedTime(pacer), Path(), locate=self._located)
        speed.streams = self.streams
        self._speed, self._pacer, self._wall = speed, pacer, SystemClock()
        self._to_present: SimpleQueue[tuple[float, Input, Event | None] | None] = SimpleQueue()
        self._pointed: deque[tuple[float, Pointing, bool]] = deque(maxlen=KEPT)
        self._presenter = threading.Thread(target=self._present, name="presentation", daemon=True)

    def on_input(self, hop: Input) -> None:
        """Take a hop; from the mission's thread, never waits."""
        lead = LEAD_S if self._speed.listened else 0.0
        delay = self._pacer.delay(hop.block.time)
        self._to_present.put((self._wall.now() + delay + lead, hop, None))

    def on_event(self, event: Event, hop: Input) -> None:
        """Take what the mission says; from its thread, never waits."""
        self._to_present.put((0.0, hop, event))

    def __enter__(self) -> PageVoices:
        """Begin to listen."""
        super().__enter__()
        self._presenter.start()
        return self

    def close(self) -> None:
        """Give out what is under way; idempotent."""
        self._to_present.put(None)
        if self._presenter.is_alive():
            self._presenter.join(LEAD_S + LAST_CALL_S)
        super().close()

    def _present(self) -> None:
        while (item := self._to_present.get()) is not None:
            due, hop, event = item
            if event is not None:
                super().on_event(event, hop)
                continue
            wait = due - self._wall.now()
            if wait > 0:
                self._wall.sleep(min(wait, LEAD_S))
            self._pointed.append((hop.block.time, hop.pointing, hop.settled))
            self.hear(hop.block)

    def _located(self, begin: float, end: float) -> tuple[Pointing, bool]:
        """Where the array pointed at the end of a hop; called on the thread that listens."""
        known = tuple(self._pointed)
        return next((pointing, settled) for time, pointing, settled in reversed(known) if time <= begin)
