"""Where a replayed mission leaves the recorded one, and whether the recorded headings still serve it then.

As long as the mission turns when and where the recorded one did, it gets every Input as it was. From the first turn
that differs on, an Input counts as settled only while the recorded array stands where this mission wants it: a turn
takes until the record comes by there, and listening ends where the recorded array turns away.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ross_payload.events import Event, State, StateChanged, TurnStarted
from ross_payload.interfaces import Input, Output
from ross_protocols.angle_text import rotation

NEAR = math.radians(2.0)  # so far from where the mission wants it the array may stand [rad]
SAME = 1e-6  # goals that differ by less are one [rad]
LISTENING = (State.LEAD_IN, State.EXPLORE_LISTEN, State.CHECK, State.RUN, State.NOISE)


class Strayed(Exception):
    """The recorded array is not where the mission needs it."""


@dataclass(frozen=True, slots=True)
class Turn:
    """One turn that a mission asked for."""

    time: float  # mission time [s]
    joint: float  # [rad]


def turns_of(lines: Sequence[str]) -> list[Turn]:
    """Return the turns among the lines of an events.jsonl."""
    events = [json.loads(line) for line in lines if "TurnStarted" in line]
    return [Turn(event["time"], event["joint"]) for event in events if event.get("event") == "TurnStarted"]


class Course:
    """Follows one replay; ``early`` is what a time may differ by rounding [s], less than a hop."""

    def __init__(self, recorded: Sequence[Turn], early: float) -> None:
        self._recorded = recorded
        self._early = early
        self._turns = 0  # said so far
        self._state = State.IDLE
        self._wanted: float | None = None  # joint angle [rad]
        self._there = True
        self.parted = ""  # where the missions part, in words; empty: not yet

    def follow(self, events: Sequence[Event], time: float, here: float) -> None:
        """Take what the mission says before the Input at mission time ``time`` [s], the joint being ``here`` [rad]."""
        for event in events:
            if isinstance(event, StateChanged):
                self._state = event.state
            elif isinstance(event, TurnStarted):
                self._compare(Turn(event.time, event.joint))
        missed = self._next()
        if not self.parted and missed is not None and missed.time <= time - self._early:
            recorded = f"the recorded mission turned to {_joint(missed.joint)} at {missed.time:.2f} s"
            self._part(f"{recorded}, the replay does not")
            self._wanted, self._there = here, True

    def fit(self, output: Output, heard: Input) -> Input:
        """Return an Input as the mission may have it.

        Raises
        ------
        Strayed
            When the mission listens and the recorded array turns away.
        """
        if output.goal is not None:
            self._wanted, self._there = output.goal, False
        if output.halt or output.stop:
            self._wanted = None
        if self._there and self._state not in LISTENING:
            self._wanted = heard.joint
        if not self.parted or self._wanted is None:
            return heard
        stands = heard.settled and abs(heard.joint - self._wanted) <= NEAR and output.goal is None
        if self._there and not stands and self._state in LISTENING:
            raise Strayed(
                f"the replay listens at {_joint(self._wanted)}, "
                f"but the recorded array is at {_joint(heard.joint)} or turning"
            )
        self._there = self._there or stands
        return replace(heard, settled=stands)

    @property
    def waiting(self) -> str:
        """What the mission waits for in vain, empty when for nothing."""
        if not self.parted or self._there or self._wanted is None:
            return ""
        return f"from then on the recorded array is never at rest at {_joint(self._wanted)}"

    def _next(self) -> Turn | None:
        return self._recorded[self._turns] if self._turns < len(self._recorded) else None

    def _compare(self, turn: Turn) -> None:
        recorded = self._next()
        self._turns += 1
        if self.parted:
            return
        ours = f"the replay turns to {_joint(turn.joint)} at {turn.time:.2f} s"
        if recorded is None:
            self._part(f"{ours}, the recorded mission does not")
        elif abs(turn.time - recorded.time) > self._early or abs(turn.joint - recorded.joint) > SAME:
            self._part(f"{ours}, the recorded mission to {_joint(recorded.joint)} at {recorded.time:.2f} s")

    def _part(self, words: str) -> None:
        self.parted = words


def _joint(angle: float) -> str:
    return f"joint angle {rotation(angle)}"
