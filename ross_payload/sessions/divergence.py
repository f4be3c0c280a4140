"""Send recorded Inputs to a mission, and see where it leaves the recorded one and whether the headings serve it then.

As long as the mission turns when and where the recorded one did, it gets every Input as it was. From the first turn
that differs on, an Input counts as settled only while the recorded array stands where this mission wants it: a turn
takes until the record comes by there, and listening ends where the recorded array turns away.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from ross_payload.events import Event, SourcesEstimated, State, StateChanged, TurnStarted
from ross_payload.interfaces import Input, Mission, Output, Result
from ross_payload.sessions import event_json
from ross_payload.sessions.recorded_voiceprint import Unanswered
from ross_protocols.angle_text import rotation

NEAR = math.radians(2.0)  # so far from where the mission wants it the array may stand [rad]
SAME = 1e-6  # goals that differ by less are one [rad]
LISTENING = (State.LEAD_IN, State.EXPLORE_LISTEN, State.CHECK, State.RUN, State.NOISE)


class Diverged(Exception):
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


class Divergence:
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
            self.parted = f"{recorded}, the replay does not"
            self._wanted, self._there = here, True

    def fit(self, output: Output, hop: Input) -> Input:
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
            self._wanted = hop.pointing.joint
        if not self.parted or self._wanted is None:
            return hop
        stands = hop.settled and abs(hop.pointing.joint - self._wanted) <= NEAR and output.goal is None
        if self._there and not stands and self._state in LISTENING:
            raise Diverged(
                f"the replay listens at {_joint(self._wanted)}, "
                f"but the recorded array is at {_joint(hop.pointing.joint)} or turning"
            )
        self._there = self._there or stands
        return replace(hop, settled=stands)

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
            self.parted = f"{ours}, the recorded mission does not"
        elif abs(turn.time - recorded.time) > self._early or abs(turn.joint - recorded.joint) > SAME:
            self.parted = f"{ours}, the recorded mission to {_joint(recorded.joint)} at {recorded.time:.2f} s"


def _joint(angle: float) -> str:
    return f"joint angle {rotation(angle)}"


@dataclass(slots=True)
class Replayed:
    """What a replay has brought."""

    start: float = 0.0  # mission time of the first Input [s]
    latest: dict[type[Event], Event] = field(default_factory=dict)  # of every kind: all voices would fill the memory
    lines: list[str] = field(default_factory=list)  # of events.jsonl
    inputs: int = 0  # sent so far
    samples: int = 0  # heard so far
    result: Result | None = None  # None: the mission has not come to its own end
    earth: bool = False  # azimuths count from north
    early: str = ""  # why it ended before the recording did, empty: it did not


def replay(mission: Mission, inputs: Iterable[Input], course: Divergence, rate: int, replayed: Replayed) -> None:
    """Run a mission on recorded Inputs until it, or they, end; ``replayed`` says at any time how far it is."""
    try:
        _feed(mission, inputs, course, rate, replayed)
    except (Diverged, Unanswered) as end:
        replayed.early = str(end)
    except StopIteration as end:
        replayed.result = end.value
    else:
        replayed.early = course.waiting
    finally:
        mission.close()


def _feed(mission: Mission, inputs: Iterable[Input], course: Divergence, rate: int, replayed: Replayed) -> None:
    """Raise StopIteration with the mission's Result when it ends before the Inputs do."""
    output: Output = next(mission)
    joint = 0.0
    for hop in inputs:
        if replayed.inputs:  # what was said before the first Input is not in the recording either
            replayed.latest |= {type(event): event for event in output.events}
            if any(isinstance(event, SourcesEstimated) for event in output.events):
                replayed.earth = hop.pointing.earth
            replayed.lines += [event_json.line(event) for event in output.events]
            course.follow(output.events, replayed.start + replayed.samples / rate, joint)
        fitted = course.fit(output, hop)
        replayed.inputs += 1
        replayed.samples += hop.block.samples.shape[1]
        joint = hop.pointing.joint
        output = mission.send(fitted)
