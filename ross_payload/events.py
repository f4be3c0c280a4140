"""What the mission says: facts that cross to telemetry, reports and pictures.

Every angle is in radians, counter-clockwise. *Headings* and *azimuths* are in the frame of the mount's attitude (earth
frame when that is known, else mount frame); *joint angles* are what the actuator speaks. ``time`` is mission time [s]:
samples heard divided by the rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.floating[Any]]


class State(IntEnum):
    """What the mission is doing; the number goes into the heartbeat's custom_mode."""

    IDLE = 0
    LEAD_IN = 1
    EXPLORE_TURN = 2
    EXPLORE_LISTEN = 3
    ALIGN_TURN = 4
    CHECK = 5
    RUN = 6
    DONE = 7
    STOPPED = 8
    FAULT = 9
    TURN = 10  # to a commanded heading
    NOISE = 11  # measures the noise on request


class Outcome(IntEnum):
    """How a mission ends; the value is the exit code of the command that ran it."""

    TARGET_FOUND = 0
    FAULT = 1
    NO_TARGET = 3
    COMPLETED = 4  # a task that looks for nobody has done what was asked
    STOPPED = 130


@dataclass(frozen=True, slots=True)
class SourceEstimate:
    """One source that the explorer believes in."""

    azimuth: float  # [rad]
    sigma: float  # one standard deviation of the azimuth [rad]
    confidence: float  # probability that a talker is within 10 deg, 0 to 1
    resolved: bool  # front told from back
    weight: float = 0.0  # share of the evidence, 0 to 1
    elevation: float | None = None  # [rad], None: not told from 0; the sign is taken, not heard
    elevation_sigma: float | None = None  # one standard deviation of the elevation [rad]
    nominal_sigma: float | None = None  # what `sigma` is without reverberation [rad]; None: the same

    @property
    def nominal(self) -> float:
        """One standard deviation of the azimuth by how much was heard, as if no reflections disturbed it [rad]."""
        return self.sigma if self.nominal_sigma is None else self.nominal_sigma


@dataclass(frozen=True, slots=True)
class Estimate:
    """Everything the explorer believes after some orientations."""

    sources: tuple[SourceEstimate, ...]
    certain: bool = False  # enough has been heard: the stop rule is met
    directness: float | None = None  # 1 in the open, 0.95 to 0.4 in ever worse rooms; None: not estimated
    rival: Estimate | None = None  # the likeliest explanation with more sources; None: unlikely

    @property
    def k(self) -> int:
        """The number of sources K."""
        return len(self.sources)

    @property
    def azimuths(self) -> Real:
        """Azimuths of the sources [rad], (k,)."""
        return np.array([source.azimuth for source in self.sources])

    @property
    def elevations(self) -> Real:
        """Elevations of the sources [rad], (k,); 0 where one is not told from 0."""
        return np.array([source.elevation or 0.0 for source in self.sources])


@dataclass(frozen=True, slots=True)
class Event:
    """The root of all events."""

    time: float  # mission time [s]


@dataclass(frozen=True, slots=True)
class StateChanged(Event):
    """The mission enters a state."""

    state: State
    detail: str = ""


@dataclass(frozen=True, slots=True)
class NoiseMeasured(Event):
    """The quiet lead-in gave a noise PSD, or did not."""

    level_db: float | None  # mean level at microphone 1 [dB re full scale], None: there was no quiet
    seconds: float


@dataclass(frozen=True, slots=True)
class OrientationHeard(Event):
    """One orientation of the exploration is complete."""

    index: int  # r
    heading: float  # [rad]
    joint: float  # [rad]
    grid: Real  # ITD [s], (n_bins,)
    density: Real  # (n_bins,)
    peaks: tuple[float, ...]  # ITD [s]


@dataclass(frozen=True, slots=True)
class SourcesEstimated(Event):
    """The explorer's belief after an orientation."""

    estimate: Estimate
    rotations: int
    final: bool
    informed: bool = False  # told from outside, nothing was explored


@dataclass(frozen=True, slots=True)
class SourcesTracked(Event):
    """Where the sources of the latest estimate are now, heard while listening; in its order, and as many."""

    estimate: Estimate
    rates: tuple[float, ...]  # of every azimuth [rad/s]
    ages: tuple[float, ...]  # since each was heard last [s]


@dataclass(frozen=True, slots=True)
class SourcesReconsidered(Event):
    """How sure the sources of the latest estimate are by all that was heard since; in its order, and as many.

    An estimate without those that are dropped follows, where any are, or one with those that are added.
    """

    estimate: Estimate
    dropped: tuple[int, ...] = ()  # indices of sources that are most probably nobody


@dataclass(frozen=True, slots=True)
class AlignmentCandidate:
    """A heading that isolates one source."""

    source: int  # index into the estimate's sources
    heading: float  # [rad]
    joint: float  # [rad]
    isolation: float  # min_k |tau_i - tau_k| at this heading [s]
    rule: str  # "gain", "stay" or "limited"; of the paper's rules "bisector" or "argmax"
    aliased: tuple[int, ...] = ()  # interferers that pose as one
    gain_db: float | None = None  # predicted SI-SDRi [dB]


@dataclass(frozen=True, slots=True)
class AlignmentPlanned(Event):
    """Where to turn, in order of travel."""

    candidates: tuple[AlignmentCandidate, ...]
    headings: Real  # [rad], (n_headings,), over [0, pi)
    isolation: Real  # [s], (n_sources, n_headings)


@dataclass(frozen=True, slots=True)
class TurnStarted(Event):
    """The array is asked to turn."""

    joint: float  # goal [rad]
    heading: float  # goal [rad]
    reason: str


@dataclass(frozen=True, slots=True)
class GroupScore:
    """One separated group and how much it sounds like the target."""

    members: tuple[int, ...]  # indices into the estimate's sources
    value: float
    accepted: bool
    si_sdr: float | None = None  # estimated [dB]
    si_sdri: float | None = None  # estimated [dB]


@dataclass(frozen=True, slots=True)
class Checked(Event):
    """T_check of listening at a candidate, separated and scored; or who was recognised before the array came there.

    Then the groups are those who were heard by then, each alone: nobody was separated at this heading.
    """

    candidate: AlignmentCandidate
    groups: tuple[GroupScore, ...]
    accepted: int | None  # index into groups
    method: str
    why: str


@dataclass(frozen=True, slots=True)
class Separated(Event):
    """T_run of listening, separated and scored."""

    start: int  # index of the first sample
    heading: float  # [rad]
    voices: Real  # (n_groups, n_samples), float32, at microphone 1
    groups: tuple[GroupScore, ...]
    target: int  # index into groups
    method: str
    why: str


@dataclass(frozen=True, slots=True)
class ScoreDropped(Event):
    """The running target no longer sounds like the target, or another source as much: somebody else is looked for."""

    value: float
    criterion: float  # or the score of the other source
    other: int | None = None  # the source that sounds as much like the target, and comes next


@dataclass(frozen=True, slots=True)
class Doubted(Event):
    """What is believed does not hold: the mission explores."""

    reason: str


@dataclass(frozen=True, slots=True)
class Slipped(Event):
    """The array has turned without its actuator: steps were lost, or something has slipped on its shaft."""

    shift: float  # by which every azimuth appeared to turn: the reported heading minus the true one [rad]


@dataclass(frozen=True, slots=True)
class ArrayContradicted(Event):
    """What an exploration heard contradicts what is configured of the array; what is None or False agrees."""

    spacing: float | None  # that explains more [m]
    configured: float  # spacing [m]
    gain_db: float | None  # of microphone 2 over microphone 1
    inverted: bool  # the microphones have opposite polarity
    delay: float | None = None  # of microphone 2 before microphone 1, whatever the heading, roughly [s]
    fixed: bool = False  # what was heard has the same delay at all headings, as interference has
    roll_off: float | None = None  # of microphone 2 above that of microphone 1, at low frequencies [Hz]


@dataclass(frozen=True, slots=True)
class Enrolled(Event):
    """The talker at a source agreed to be enrolled, and is."""

    name: str
    source: int  # index into the estimate's sources
    azimuth: float  # [rad]
    seconds: float  # of voiced speech
    voiceprint: Any  # an `interfaces.VoicePrint`: personal data, which is in no log


@dataclass(frozen=True, slots=True)
class Finished(Event):
    """The mission is over."""

    outcome: Outcome
    reason: str


class Answer(IntEnum):
    """What becomes of an order."""

    ACCEPTED = 0
    REFUSED = 1  # not in this state, or impossible: the reason says why
    PROGRESS = 2
    DONE = 3
    FAILED = 4
    CANCELLED = 5


@dataclass(frozen=True, slots=True)
class Answered(Event):
    """The mission answers an order; every order gets ACCEPTED or REFUSED, an accepted task one of the last three."""

    order: int  # its number
    answer: Answer
    reason: str = ""
    progress: float | None = None  # 0 to 1, of PROGRESS
