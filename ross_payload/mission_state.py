"""What the mission does and has found out, folded from its events: one pure function for all who follow it."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from ross_payload import events

RESTING = frozenset({events.State.IDLE, events.State.DONE, events.State.STOPPED, events.State.FAULT})  # no task runs
FOUND = {events.Outcome.TARGET_FOUND: True, events.Outcome.NO_TARGET: False}  # other ends leave it as it was
BUSY = "busy: cancel first"
STOPPED = "stopped: re-arm first"
SAME_ANGLE = 1e-6  # [rad]
MEASURED = re.compile(r"\d+\.\d+")  # in a fault, as how long nothing was reported


def is_same_fault(one: str, other: str) -> bool:
    """Whether two faults in words differ at most in what was measured: then it is one that lasts.

    >>> is_same_fault("no report for 0.51 s", "no report for 0.52 s"), is_same_fault("fault 0x2310", "fault 0x3210")
    (True, False)
    """
    return MEASURED.sub("", one) == MEASURED.sub("", other)


@dataclass(frozen=True, slots=True)
class MissionState:
    """The mission after some events; what is counted grows by one with every event of its kind."""

    state: events.State | None = None  # None: it has not spoken yet
    detail: str = ""  # of the state
    outcome: events.Outcome | None = None  # of the task that ended last, None: none has, or one runs
    noise_measured: bool = False
    explorations: int = 0
    headings: tuple[float, ...] = ()  # of the orientations of the latest exploration [rad]
    rotation: int = 0  # r, of the latest orientation
    estimates: int = 0
    estimate: events.Estimate | None = None  # the latest
    known: int | None = None  # K of the latest final estimate
    plans: int = 0
    planned: tuple[events.AlignmentCandidate, ...] = ()  # for the latest estimate
    alignment: events.AlignmentCandidate | None = None  # that the array turns to, or was turned to last
    separations: int = 0
    target: int | None = None  # index of a source
    target_found: bool = False
    sought: bool = True  # a voice is enrolled: without one scores are 0 and tell nothing
    score: float | None = None
    goal: float | None = None  # heading that is turned to [rad]

    @property
    def resting(self) -> bool:
        """Whether no task runs, as far as is known here."""
        return self.state in RESTING

    @property
    def running(self) -> bool:
        """Whether a task is known to run."""
        return self.state is not None and not self.resting

    @property
    def barred(self) -> str:
        """Why nothing may turn before it is re-armed, in words; empty: it may."""
        if self.state is events.State.STOPPED:
            return STOPPED
        return f"fault, re-arm first: {self.detail}" if self.state is events.State.FAULT else ""


def reduce(mission: MissionState, event: events.Event) -> MissionState:
    """Return the mission after one more event.

    >>> reduce(MissionState(), events.StateChanged(0.0, events.State.RUN)).running
    True
    """
    match event:
        case events.StateChanged():
            outcome = mission.outcome if event.state in RESTING else None
            mission = replace(mission, state=event.state, detail=event.detail, outcome=outcome)
        case events.NoiseMeasured():
            mission = replace(mission, noise_measured=event.level_db is not None)
        case events.OrientationHeard():
            mission = _orientation(mission, event)
        case events.SourcesEstimated():
            mission = replace(
                mission,
                estimates=mission.estimates + 1,
                estimate=event.estimate,
                known=event.estimate.k if event.final else mission.known,
                planned=(),
                alignment=None,
                target=None,
                target_found=False,
            )
        case events.SourcesTracked() | events.SourcesReconsidered():
            mission = replace(mission, estimate=event.estimate)
        case events.AlignmentPlanned():
            first = event.candidates[0] if event.candidates else None
            mission = replace(mission, plans=mission.plans + 1, planned=event.candidates, alignment=first)
        case events.TurnStarted():
            mission = replace(mission, goal=event.heading, alignment=_turned_to(mission, event))
        case events.Checked() | events.Separated():
            mission = _separation(mission, event)
        case events.Enrolled():  # another target, whom nobody was compared with yet
            mission = replace(mission, target=None, target_found=False, score=None, sought=True)
        case events.ScoreDropped():
            mission = replace(mission, target_found=False, target=None, score=event.value)
        case events.Finished():
            found = FOUND.get(event.outcome, mission.target_found)
            mission = replace(mission, outcome=event.outcome, target_found=found, goal=None)
    return mission


def _orientation(mission: MissionState, event: events.OrientationHeard) -> MissionState:
    if event.index == 0:
        mission = replace(mission, explorations=mission.explorations + 1, headings=())
    return replace(mission, headings=(*mission.headings, event.heading), rotation=event.index)


def _turned_to(mission: MissionState, event: events.TurnStarted) -> events.AlignmentCandidate | None:
    if mission.state is not events.State.ALIGN_TURN:
        return mission.alignment
    return next((each for each in mission.planned if abs(each.joint - event.joint) < SAME_ANGLE), mission.alignment)


def _separation(mission: MissionState, event: events.Checked | events.Separated) -> MissionState:
    group = chosen(event)
    preferred = event.candidate.source if isinstance(event, events.Checked) else mission.target
    return replace(
        mission,
        separations=mission.separations + 1,
        alignment=event.candidate if isinstance(event, events.Checked) else mission.alignment,
        target=None if group is None else target_of(event.groups[group], preferred),
        target_found=group is not None,
        score=leading_score(event) if mission.sought else None,
    )


def chosen(event: events.Checked | events.Separated) -> int | None:
    """Return the index of the group that is taken for the target; None: no group sounds like it."""
    if isinstance(event, events.Checked):
        return event.accepted
    return event.target if event.groups[event.target].accepted else None


def target_of(group: events.GroupScore, preferred: int | None) -> int | None:
    """Return the source that a group recognised as the target stands for; None when it may be one of several.

    >>> both = events.GroupScore((1, 2), 3.0, True)
    >>> target_of(both, preferred=2), target_of(both, preferred=0)
    (2, None)
    """
    if preferred in group.members:
        return preferred
    return group.members[0] if len(group.members) == 1 else None


def leading_score(event: events.Checked | events.Separated) -> float | None:
    """Return the score of the best group of a check, or of the running target."""
    if isinstance(event, events.Separated):
        return event.groups[event.target].value
    return max((group.value for group in event.groups), default=None)
