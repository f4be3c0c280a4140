"""What the mission does and has found out, folded from its events: one pure function for all who follow it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Estimate,
    Event,
    Finished,
    GroupScore,
    NoiseMeasured,
    OrientationHeard,
    Outcome,
    ScoreDropped,
    Separated,
    SourcesEstimated,
    SourcesTracked,
    State,
    StateChanged,
    TurnStarted,
)

RESTING = frozenset({State.IDLE, State.DONE, State.STOPPED, State.FAULT})  # no task runs
FOUND = {Outcome.TARGET_FOUND: True, Outcome.NO_TARGET: False}  # other ends leave it as it was
BUSY = "busy: cancel first"
STOPPED = "stopped: re-arm first"
SAME_ANGLE = 1e-6  # [rad]


@dataclass(frozen=True, slots=True)
class MissionState:
    """The mission after some events; what is counted grows by one with every event of its kind."""

    state: State | None = None  # None: it has not spoken yet
    detail: str = ""  # of the state
    outcome: Outcome | None = None  # of the task that ended last, None: none has, or one runs
    noise_measured: bool = False
    explorations: int = 0
    headings: tuple[float, ...] = ()  # of the orientations of the latest exploration [rad]
    rotation: int = 0  # r, of the latest orientation
    estimates: int = 0
    estimate: Estimate | None = None  # the latest
    known: int | None = None  # K of the latest final estimate
    plans: int = 0
    planned: tuple[AlignmentCandidate, ...] = ()  # for the latest estimate
    alignment: AlignmentCandidate | None = None  # that the array turns to, or was turned to last
    separations: int = 0
    target: int | None = None  # index of a source
    target_found: bool = False
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
        if self.state is State.STOPPED:
            return STOPPED
        return f"fault, re-arm first: {self.detail}" if self.state is State.FAULT else ""


def reduce(mission: MissionState, event: Event) -> MissionState:
    """Return the mission after one more event.

    >>> reduce(MissionState(), StateChanged(0.0, State.RUN)).running
    True
    """
    match event:
        case StateChanged():
            outcome = mission.outcome if event.state in RESTING else None
            mission = replace(mission, state=event.state, detail=event.detail, outcome=outcome)
        case NoiseMeasured():
            mission = replace(mission, noise_measured=event.level_db is not None)
        case OrientationHeard():
            mission = _orientation(mission, event)
        case SourcesEstimated():
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
        case SourcesTracked():
            mission = replace(mission, estimate=event.estimate)
        case AlignmentPlanned():
            first = event.candidates[0] if event.candidates else None
            mission = replace(mission, plans=mission.plans + 1, planned=event.candidates, alignment=first)
        case TurnStarted():
            mission = replace(mission, goal=event.heading, alignment=_turned_to(mission, event))
        case Checked() | Separated():
            mission = _separation(mission, event)
        case ScoreDropped():
            mission = replace(mission, target_found=False, target=None, score=event.value)
        case Finished():
            found = FOUND.get(event.outcome, mission.target_found)
            mission = replace(mission, outcome=event.outcome, target_found=found, goal=None)
    return mission


def _orientation(mission: MissionState, event: OrientationHeard) -> MissionState:
    if event.index == 0:
        mission = replace(mission, explorations=mission.explorations + 1, headings=())
    return replace(mission, headings=(*mission.headings, event.heading), rotation=event.index)


def _turned_to(mission: MissionState, event: TurnStarted) -> AlignmentCandidate | None:
    if mission.state is not State.ALIGN_TURN:
        return mission.alignment
    return next((each for each in mission.planned if abs(each.joint - event.joint) < SAME_ANGLE), mission.alignment)


def _separation(mission: MissionState, event: Checked | Separated) -> MissionState:
    group = chosen(event)
    preferred = event.candidate.source if isinstance(event, Checked) else mission.target
    return replace(
        mission,
        separations=mission.separations + 1,
        alignment=event.candidate if isinstance(event, Checked) else mission.alignment,
        target=None if group is None else target_of(event.groups[group], preferred),
        target_found=group is not None,
        score=leading_score(event),
    )


def chosen(event: Checked | Separated) -> int | None:
    """Return the index of the group that is taken for the target; None: no group sounds like it."""
    if isinstance(event, Checked):
        return event.accepted
    return event.target if event.groups[event.target].accepted else None


def target_of(group: GroupScore, preferred: int | None) -> int | None:
    """Return the source that a group recognised as the target stands for; None when it may be one of several.

    >>> target_of(GroupScore((1, 2), 3.0, True), preferred=2), target_of(GroupScore((1, 2), 3.0, True), preferred=0)
    (2, None)
    """
    if preferred in group.members:
        return preferred
    return group.members[0] if len(group.members) == 1 else None


def leading_score(event: Checked | Separated) -> float | None:
    """Return the score of the best group of a check, or of the running target."""
    if isinstance(event, Separated):
        return event.groups[event.target].value
    return max((group.value for group in event.groups), default=None)
