"""What the whole mission remembers, and the hop that exchanges an Output for an Input."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from ross_payload.dsp.dc_offset import without_offset
from ross_payload.dsp.ego_noise import EgoNoise, learnt
from ross_payload.dsp.itd import band_limits, raised_psd
from ross_payload.dsp.noise import quiet_frames, quiet_psd
from ross_payload.dsp.rotor_tones import tones
from ross_payload.dsp.stft import Stft, short_frames
from ross_payload.events import (
    Answer,
    Answered,
    Estimate,
    Event,
    NoiseMeasured,
    Outcome,
    State,
    StateChanged,
    TurnStarted,
)
from ross_payload.interfaces import (
    Complex,
    Input,
    Marks,
    Observation,
    Output,
    Real,
    Samples,
)
from ross_payload.localization.joint_in_noise import Learnt
from ross_payload.mission.heading_control import Follower
from ross_payload.mission.hearing import Hearing
from ross_payload.mission.settings import Settings, Tools
from ross_payload.mission.source_tracking import SourceTracker
from ross_payload.mission.voice_evidence import Evidence
from ross_payload.mission_state import BUSY
from ross_payload.orders import Cancel, Order, Set, Shutdown, Stop, Task
from ross_payload.pointing import Pointing

FOUND = "the vehicle's attitude is now known"
LOST = "the vehicle's attitude is no longer known"

T = TypeVar("T")
Step = Generator[Output, Input, T]

NOTHING = Output()  # is wished for


class Ended(Exception):
    """The task ends here: an order that ends it, or a fault of the actuator."""

    def __init__(self, outcome: Outcome, reason: str, order: Order | None = None) -> None:
        super().__init__(reason)
        self.outcome = outcome
        self.reason = reason
        self.order = order  # the one that ends the task, None: a fault


class FrameChanged(Ended):
    """The attitude was lost, or is known again: azimuths heard before and after are not in one frame."""


@dataclass(frozen=True, slots=True)
class Listening:
    """What was heard at one heading."""

    heading: float  # [rad], the mean where the array followed it
    samples: Samples  # (2, n)
    spread: float = 0.0  # largest deviation from the heading while it was followed [rad]
    headings: Real | None = None  # in the middle of every hop where they were not all one [rad], (n_hops,)
    aboard: float = 0.0  # the mean heading in the frame of the vehicle [rad]
    rotor_speeds: Real | None = None  # at the beginning of every hop [1/s], (n_hops, n_rotors); None: not known
    damaged: bool = False  # so much of it was clipped or missing that it does not tell how clean a voice is
    deaf: bool = False  # so much of it a dead or saturated microphone gave that it does not tell where anybody is
    around: tuple[Samples, Samples] | None = None  # heard right before and after while the array turned, (2, m) each

    def speeds(self, begin: int, end: int) -> Real | None:
        """Return the speeds of the rotors from one sample to another [1/s], (m, n_rotors); beyond the ends as there."""
        if self.rotor_speeds is None:
            return None
        each, last = len(self.rotor_speeds) / self.samples.shape[1], len(self.rotor_speeds) - 1
        hops = np.arange(np.floor(begin * each), max(np.ceil(end * each), np.floor(begin * each) + 1), dtype=int)
        return np.asarray(self.rotor_speeds[np.clip(hops, 0, last)])


def never(task: Task) -> str:
    """Refuse no task."""
    return ""


@dataclass(slots=True)
class Context:
    """The mission's memory between hops."""

    settings: Settings
    tools: Tools
    samples: int = 0  # heard so far
    hearing: Hearing = field(default_factory=Hearing)  # whether it was sound
    refusal: Callable[[Task], str] = never  # why a task that would take the place of this one cannot be begun
    last: Input | None = None
    lead_in: Samples | None = None  # (2, n), quiet or not
    lead_in_aboard: float = 0.0  # heading in the frame of the vehicle where it was heard [rad]
    lead_in_speeds: Real | None = None  # of the rotors meanwhile, as of `Listening`
    ego_noise: dict[int, EgoNoise | None] = field(default_factory=dict)  # by STFT frame
    heard_noise: list[Learnt | None] = field(
        default_factory=list
    )  # what the explorer knows of it; empty: not asked yet
    noise_psd: dict[int, Real | None] = field(default_factory=dict)  # by STFT frame
    raised_psd: Real | None = None  # as the explorer is told it
    explored: list[Listening] = field(default_factory=list)  # of the latest exploration
    observations: list[Observation] = field(default_factory=list)  # what they tell the explorer
    beliefs: list[Estimate] = field(default_factory=list)  # one after each of them
    unvisited: list[tuple[float, float]] = field(default_factory=list)  # headings and joint angles left of it [rad]
    heard_since: list[Observation] = field(default_factory=list)  # what the listening since then tells the explorer
    reconsidered: tuple[float, float] | None = None  # when it was asked about that first and last [s], None: never
    believed: tuple[Estimate, int] | None = None  # what the latest run believed at last, and whom it listened to
    pending: list[Event] = field(default_factory=list)
    yields: bool = False  # another task may take the place of this one: it has found what it looked for
    later: list[Order] = field(default_factory=list)  # to be obeyed when the task is over
    earth: bool | None = None  # the frame in which the task thinks, None: it does not matter yet
    holding: Follower | None = None  # the heading that was faced last
    surveyed: tuple[Estimate, bool] | None = None  # what was explored last, and whether in the earth frame
    tracker: SourceTracker | None = None  # of the sources that are listened to
    evidence: Evidence | None = None  # what was heard of every source since it was found

    @property
    def time(self) -> float:
        """Mission time [s]."""
        return self.samples / self.settings.rate

    @property
    def rotations(self) -> int:
        """Orientations of the latest exploration after the first one."""
        return max(len(self.observations) - 1, 0)

    @property
    def here(self) -> Input:
        """The latest Input; the mission has always heard one when it asks."""
        if self.last is None:
            raise RuntimeError("expected an Input before this, got none")
        return self.last

    @property
    def pointing(self) -> Pointing:
        """Where the array points at the end of the latest Input."""
        return self.here.pointing

    def keep_frame(self) -> None:
        """From here on the task depends on the frame of the headings: a change of it ends what it does."""
        if self.earth is None:
            self.earth = self.pointing.earth

    def drop_frame(self) -> None:
        """Forget the frame and the heading that was held in it."""
        self.earth = self.holding = None

    def track(self, estimate: Estimate, source: int) -> None:
        """From here on follow the sources of an estimate while one of them is listened to, where that is wanted.

        In frames of its own: longer ones, which an explorer may be told to use, make those who rest seem to move.
        """
        settings, stft = self.settings, short_frames(self.settings.rate)
        if not settings.track or not estimate.k:
            self.tracker = None
            return
        psd = self.noise_psd.get(stft.frame)
        spacing, speed = settings.spacing, settings.speed_of_sound
        rested = sum(heard.samples.shape[1] for heard in self.explored) / settings.rate
        self.tracker = self.tools.tracker(estimate, source, stft, spacing, speed, self.lead_in, psd, rested)

    def publish(self, event: Event) -> None:
        """Send an event with the next Output."""
        self.pending.append(event)

    def enter(self, state: State, detail: str = "") -> None:
        """Enter a state and say so."""
        self.yields = state is State.RUN
        self.publish(StateChanged(self.time, state, detail))

    def psd(self, stft: Stft, later: Complex) -> Real | None:
        """Noise PSD from the lead-in for this STFT, or None when the lead-in was not quiet; computed once."""
        if stft.frame not in self.noise_psd:
            found = None
            if self.lead_in is not None and self.lead_in.shape[1] >= stft.frame:
                found = quiet_psd(stft.analyse(self.lead_in), later)
            if not self.noise_psd:
                self.say_noise(quiet=found is not None)
            self.noise_psd[stft.frame] = found
        return self.noise_psd[stft.frame]

    def explorer_psd(self, later: Complex) -> Real | None:
        """The same for the explorer: raised where the noise has a direction, which would pass for a source."""
        stft, settings = self.tools.explorer_stft, self.settings
        psd = self.psd(stft, later)
        if psd is not None and self.lead_in is not None and self.raised_psd is None:
            heard, limits = stft.analyse(self.lead_in), band_limits(settings.spacing, settings.speed_of_sound)
            self.raised_psd = raised_psd(heard[..., quiet_frames(heard)], stft.frequencies, stft.period, psd, limits)
        return psd if psd is None else self.raised_psd

    def noise_field(self, stft: Stft, spectrogram: Complex, listening: Listening) -> Real | None:
        """Noise covariance of every bin of what was heard; None when the noise is white or unknown."""
        if not self.settings.ego_noise or self.lead_in is None or self.lead_in.shape[1] < stft.frame:
            return None
        if stft.frame not in self.ego_noise:
            heard = stft.analyse(self.lead_in)
            rotors = self.tools.rotors
            self.ego_noise[stft.frame] = learnt(heard, stft.frequencies, stft.period, self.lead_in_aboard, rotors)
        noise = self.ego_noise[stft.frame]
        if noise is None:
            return None
        tonal = self.tonal(stft, listening.samples, listening.rotor_speeds)
        return noise.field(spectrogram, stft.frequencies, stft.period, listening.aboard, tonal)

    def tonal(self, stft: Stft, samples: Samples, speeds: Real | None) -> Marks | None:
        """Where in the spectrogram of ``samples`` tones of the rotors are; None when their speeds are not known."""
        if speeds is None:
            return None
        n = samples.shape[1]
        frames, seconds = stft.frames_of(n), n / self.settings.rate
        return tones(stft.frequencies, stft.period, frames, speeds, seconds=seconds, blades=self.settings.blades)

    def noise_of_explorer(self) -> Learnt | None:
        """What the explorer knows of the noise of the vehicle; None when there is nothing to know."""
        stft, aboard = self.tools.explorer_stft, self.lead_in_aboard
        if self.tools.in_noise is None or self.lead_in is None or self.lead_in.shape[1] < stft.frame:
            return None
        if not self.heard_noise:
            heard = stft.analyse(self.lead_in)
            tonal = self.tonal(stft, self.lead_in, self.lead_in_speeds)
            known = self.tools.in_noise.learn(
                heard, stft.frequencies, stft.period, aboard, self.tools.rotors, tonal=tonal
            )
            self.heard_noise.append(known)
        return self.heard_noise[0]

    def keep_lead_in(self, samples: Samples, speeds: Real | None) -> None:
        """Keep what was heard at the present heading while nobody talked, and how fast the rotors turned."""
        self.lead_in, self.lead_in_aboard = samples, self.pointing.heading - self.pointing.base
        self.lead_in_speeds = speeds
        self.ego_noise, self.heard_noise = {}, []

    def say_noise(self, *, quiet: bool) -> None:
        """Say how loud the lead-in was when it was quiet, or that it was not."""
        level = None
        if quiet and self.lead_in is not None:
            level = float(10 * np.log10(np.mean(self.lead_in[0].astype(np.float64) ** 2) + 1e-20))
        heard = 0 if self.lead_in is None else self.lead_in.shape[1]
        self.publish(NoiseMeasured(self.time, level, heard / self.settings.rate))


def exchange(context: Context, wish: Output = NOTHING) -> Step[Input]:
    """Exchange one Output for one Input, whatever it says; pending events go with the wish."""
    if context.pending:
        wish, context.pending = replace(wish, events=tuple(context.pending)), []
    heard = yield wish
    context.last = heard
    context.samples += heard.block.samples.shape[1]
    context.hearing.add(heard.block.samples, context.settings.rate, heard.block.flags)
    return heard


def hop(context: Context, goal: float | None = None, *, rate: float | None = None, halt: bool = False) -> Step[Input]:
    """Exchange one Output for one Input; every stop, cancel and fault is obeyed here.

    ``goal`` [rad] and ``rate`` [rad/s] are those of the joint; ``halt`` brakes it.

    Raises
    ------
    Ended
        On a command or a fault.
    FrameChanged
        When the attitude that the task depends on is lost or found.
    """
    wishes = goal is not None or rate is not None or halt
    heard = yield from exchange(context, Output(goal=goal, rate=rate, halt=halt) if wishes else NOTHING)
    obey(context, heard.orders)
    if heard.fault:
        raise Ended(Outcome.FAULT, heard.fault)
    if context.earth not in (None, heard.pointing.earth):
        raise FrameChanged(Outcome.FAULT, LOST if context.earth else FOUND)
    return heard


def obey(context: Context, orders: Sequence[Order]) -> None:
    """Obey orders that come in the middle of a task.

    Raises
    ------
    Ended
        When one of them ends the task; those behind it wait until it has ended.
    """
    for place, order in enumerate(orders, start=1):
        try:
            _obey(context, order)
        except Ended:
            context.later.extend(orders[place:])
            raise


def _obey(context: Context, order: Order) -> None:
    match order:
        case Stop() | Shutdown():
            raise Ended(Outcome.STOPPED, "stopped by command", order)
        case Cancel():
            raise Ended(Outcome.STOPPED, "cancelled by command", order)
        case Task() if context.yields:
            if why := context.refusal(order):
                context.publish(Answered(context.time, order.number, Answer.REFUSED, why))
                return
            context.later.append(order)  # behind the settings that came before it
            raise Ended(Outcome.STOPPED, "another task was commanded", order)
        case Set():
            context.later.append(order)
        case _:
            context.publish(Answered(context.time, order.number, Answer.REFUSED, BUSY))


def listen(context: Context, seconds: float) -> Step[tuple[Samples, Real | None]]:
    """Hear ``seconds`` of audio at rest; return the samples (2, n), and the speeds of the rotors as of `Listening`."""
    wanted = round(seconds * context.settings.rate)
    blocks: list[Samples] = []
    speeds: list[tuple[float, ...]] = []
    heard = 0
    while heard < wanted:
        now = yield from hop(context)
        blocks.append(now.block.samples)
        speeds.append(now.attitude.rotor_speeds)
        heard += now.block.samples.shape[1]
    samples = np.concatenate(blocks, axis=1) if blocks else np.zeros((2, 0), np.float32)
    return without_offset(samples), speeds_by_hop(speeds)


def speeds_by_hop(reported: Sequence[tuple[float, ...]]) -> Real | None:
    """Speeds of the rotors at every hop [1/s], (n_hops, n_rotors); None when nobody told any.

    >>> speeds_by_hop([(), (90.0, 91.0)]).tolist(), speeds_by_hop([(), ()])
    ([[0.0, 0.0], [90.0, 91.0]], None)
    """
    n_rotors = max(map(len, reported), default=0)
    if not n_rotors:
        return None
    return np.array([[*speeds, *[0.0] * (n_rotors - len(speeds))] for speeds in reported])


def turn(context: Context, joint: float, reason: str) -> Step[None]:
    """Turn to a joint angle [rad] and wait until settled; what is heard meanwhile passes by."""
    context.publish(TurnStarted(context.time, joint, context.pointing.at(joint), reason))
    yield from hop(context, goal=joint)
    while not context.here.settled:
        yield from hop(context)
