"""Send the recorded Inputs to a mission, in the runner's order, and keep what it says."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from ross_payload.events import Event, SourcesEstimated
from ross_payload.interfaces import Input, Mission, Output, Result
from ross_payload.recording import plain
from ross_payload.replay.course import Course, Strayed
from ross_payload.replay.voices import Unanswered


@dataclass(slots=True)
class Replayed:
    """What a replay has brought."""

    start: float = 0.0  # mission time of the first Input [s]
    events: list[Event] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)  # of events.jsonl
    inputs: int = 0  # sent so far
    samples: int = 0  # heard so far
    result: Result | None = None  # None: the mission has not come to its own end
    earth: bool = False  # azimuths count from north
    early: str = ""  # why it ended before the recording did, empty: it did not


def replay(mission: Mission, inputs: Iterable[Input], course: Course, rate: int, told: Replayed) -> None:
    """Run a mission on recorded Inputs until it, or they, end; ``told`` says at any time how far it is."""
    try:
        _feed(mission, inputs, course, rate, told)
    except (Strayed, Unanswered) as end:
        told.early = str(end)
    except StopIteration as end:
        told.result = end.value
    else:
        told.early = course.waiting
    finally:
        mission.close()


def _feed(mission: Mission, inputs: Iterable[Input], course: Course, rate: int, told: Replayed) -> None:
    """Raise StopIteration with the mission's Result when it ends before the Inputs do."""
    output: Output = next(mission)
    joint = 0.0
    for heard in inputs:
        if told.inputs:  # what was said before the first Input is not in the recording either
            told.events += output.events
            if any(isinstance(event, SourcesEstimated) for event in output.events):
                told.earth = heard.attitude.known
            told.lines += [plain.line(event) for event in output.events]
            course.follow(output.events, told.start + told.samples / rate, joint)
        fitted = course.fit(output, heard)
        told.inputs += 1
        told.samples += heard.block.samples.shape[1]
        joint = heard.joint
        output = mission.send(fitted)
