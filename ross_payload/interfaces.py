"""The seams: what a simulator, a driver or a plug-in must provide, and the frozen values that cross them.

Inside the payload everything is SI and radians, counter-clockwise. Three angles are never mixed: the *joint angle*
is what an actuator speaks (from its zero, unwrapped); the *heading* is where the axis from microphone 1 to
microphone 2 points (`Pointing`); an *azimuth* is where a source is, in the same
frame as the heading.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from enum import IntFlag, StrEnum
from types import TracebackType
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ross_payload.events import Estimate, Event, Outcome
from ross_payload.orders import Order
from ross_payload.pointing import Pointing

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]
Samples = NDArray[np.float32]
Marks = NDArray[np.bool_]
Cancel = Callable[[], None]  # ends a periodic call


class Managed(Protocol):
    """What ``with`` opens and closes."""

    def __enter__(self) -> Self:
        """Open it."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""


# ---------------------------------------------------------------------------------------------------- time


class Clock(Protocol):
    """Time, injected. The system's clock or a simulated one."""

    def now(self) -> float:
        """Return the time [s], monotonic, from an arbitrary origin."""

    def sleep(self, duration: float) -> None:
        """Wait for ``duration`` [s]."""

    def every(self, period: float, call: Callable[[], None]) -> Cancel:
        """Call ``call`` every ``period`` [s] until cancelled; calls due at one time run in order of registration.

        Cancelling waits for a call that is under way.
        """


# ---------------------------------------------------------------------------------------------------- audio


class AudioFlag(IntFlag):
    """What is wrong with a block of audio."""

    NONE = 0
    CLIPPED = 1
    INVALID = 2  # not-a-number or infinite samples, replaced by zeros
    MISSING = 4  # samples that never came, replaced by zeros


UNHEARD = AudioFlag.INVALID | AudioFlag.MISSING  #: zeros stand for some samples


@dataclass(frozen=True, slots=True)
class AudioBlock:
    """Consecutive samples of both microphones."""

    samples: Samples  # (2, n), on a 24-bit grid
    index: int  # of the first sample, since the source was opened
    time: float  # of the first sample, on the Clock [s]
    lost: int = 0  # samples lost right before this block
    flags: AudioFlag = AudioFlag.NONE
    raw: Samples | None = None  # before all corrections, (2, n); None: samples are as they came
    carried: float = 0.0  # by the filter that corrects them, from what came before


class AudioSource(Managed, Protocol):
    """Two microphones; a context manager."""

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` consecutive samples; never skips, also what was heard while turning.

        Raises
        ------
        AudioError
            When the source has ended or broken.
        """


@dataclass(frozen=True, slots=True)
class VoiceBlock:
    """Consecutive samples of what somebody listens to: one voice, or the mixture at microphone 1."""

    samples: Samples  # (n,), within -1 to 1
    index: int  # of the first sample, since the source was opened: the same sample of the mixture has the same index
    time: float  # when that sample was at the microphone, on the Clock [s]


class AudioSink(Managed, Protocol):
    """Where a voice goes: a file, headphones, the network. A context manager; no method blocks.

    It cannot be opened: `AudioError`. Closing it writes what is still waiting, and gives up on who does not take it.
    """

    def write(self, block: VoiceBlock) -> None:
        """Take the next samples. What goes wrong afterwards is told by `fault`, and is nobody else's concern.

        Raises
        ------
        AudioError
            When it can take no more as it is open now: it is closed, and opened again after a while.
        """

    @property
    def fault(self) -> str:
        """What is wrong, in words; empty while all is well."""

    @property
    def lost(self) -> int:
        """Samples that were taken and never got out."""


# ---------------------------------------------------------------------------------------------------- motion


class Feedback(StrEnum):
    """Where an actuator's reported angle comes from."""

    MEASURED = "measured"
    MODEL = "model"  # open loop: computed from what was commanded


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What an actuator can do. Angles are joint angles [rad]."""

    lower: float  # travel limit [rad], -inf when continuous
    upper: float  # travel limit [rad], +inf when continuous
    max_speed: float  # [rad/s]
    max_acceleration: float  # [rad/s^2]
    resolution: float  # smallest step [rad]
    continuous: bool  # turns without end
    feedback: Feedback
    finds_zero: bool = False  # `home` goes to a switch or an index; else it declares the zero, or an encoder knows it
    disturbance: float = 0.0  # so far may wind take it from its goal, and it comes back by itself [rad]


@dataclass(frozen=True, slots=True)
class ActuatorState:
    """Where an actuator is, as far as it knows."""

    angle: float  # joint angle [rad]
    rate: float  # [rad/s]
    settled: bool  # at the goal and still
    homed: bool  # the zero is known
    healthy: bool
    time: float  # of the report, on the Clock [s]
    fault: str = ""  # in words, empty when healthy


class Actuator(Managed, Protocol):
    """Something that turns. A context manager: opening it moves nothing, closing it stops it. No method blocks.

    It may have an ``identity``: vendor, model, name, version, as its device tells them, in one line; empty while it
    has not.
    """

    @property
    def capabilities(self) -> Capabilities:
        """Travel, speed, acceleration, resolution, feedback."""

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal in flight.

        Raises
        ------
        LimitError
            When the angle lies outside the travel or is not finite.
        NotHomed
            When the zero is not known.
        ActuatorFault
            When the actuator is in a fault or its stop is latched.
        """

    def state(self) -> ActuatorState:
        """Return the last known state."""

    def stop(self) -> None:
        """Decelerate to rest and forget the goal; from any thread; idempotent."""

    def home(self) -> None:
        """Begin to find (or declare) the zero."""

    def release(self) -> None:
        """Remove the torque; the position is unknown afterwards where the hardware forgets it."""

    def poll(self, now: float) -> None:
        """Drain input and send what is due at ``now`` [s]; never waits."""


@runtime_checkable
class SharedControl(Protocol):
    """An actuator that others may turn too, while nobody here holds it."""

    def take_control(self) -> None:
        """Take control and hold it where it is; a goal does so, too."""

    def release_control(self) -> bool:
        """Give control back once it is at rest; tell whether there can be others that take it."""

    def brake(self) -> None:
        """Bring to rest what others turn, without taking control from them."""


class Port(Protocol):
    """A wire: serial, UDP, TCP, CAN, pulses, or an in-process one."""

    def send(self, frame: Any) -> None:
        """Send one frame (bytes, a CAN message, a pulse segment); never waits."""

    def receive(self) -> list[Any]:
        """Return what has arrived since the last call; never waits."""

    def close(self) -> None:
        """Give the wire back; idempotent."""


@dataclass(frozen=True, slots=True)
class Services:
    """What a back end is given when it is opened."""

    clock: Clock
    open_port: Callable[[str], Port]  # from the URL in the configuration


class Backend(Protocol):
    """The object behind an entry point in ``ross_payload.actuators``."""

    Config: type[Any]  # a frozen pydantic model of [actuator.options]

    def open(self, config: Any, services: Services) -> Actuator:
        """Make the actuator; nothing moves."""


@dataclass(frozen=True, slots=True)
class Attitude:
    """The base of the payload in the earth frame [rad], counter-clockwise yaw."""

    yaw: float
    pitch: float = 0.0
    roll: float = 0.0
    sigma: float = 0.0  # one standard deviation of the yaw [rad]
    age: float = 0.0  # [s]
    known: bool = True  # False: angles are in the mount frame
    height: float | None = None  # above the mouths of those who talk [m], None: not known
    rotor_speeds: tuple[float, ...] = ()  # of the rotors of the vehicle [1/s], 0: stands or not known; (): of none


class Mount(Protocol):
    """Where the base of the payload points."""

    def attitude(self, time: float) -> Attitude:
        """Return the attitude at ``time`` on the Clock [s]."""


# ---------------------------------------------------------------------------------------------------- mission


@dataclass(frozen=True, slots=True)
class Input:
    """One hop of audio and what was known while it was heard."""

    block: AudioBlock
    heading_start: float  # of the first sample [rad]
    pointing: Pointing  # just after the last sample
    settled: bool  # still at the goal during the whole hop
    attitude: Attitude  # of the base at the first sample
    fault: str = ""  # of the actuator, in words
    orders: tuple[Order, ...] = ()


@dataclass(frozen=True, slots=True)
class Output:
    """What the mission says and wants after an Input."""

    events: tuple[Event, ...] = ()
    goal: float | None = None  # joint angle [rad]
    rate: float | None = None  # at most so fast [rad/s]; None: as the guard allows
    halt: bool = False  # decelerate and forget the goal
    stop: bool = False  # the same, and moves are refused until `rearm`
    rearm: bool = False
    home: bool = False
    slipped: float | None = None  # so much is the reported joint angle ahead of the true one [rad]: put it right
    hold: bool | None = None  # True: a task begins, nobody else may turn the actuator; False: others may; None: as is


@dataclass(frozen=True, slots=True)
class Result:
    """How a mission ended."""

    outcome: Outcome
    reason: str


Mission = Generator[Output, Input, Result]


# ---------------------------------------------------------------------------------------------------- plug-ins


@dataclass(frozen=True, slots=True)
class Observation:
    """What one orientation (T_unit of listening at rest) tells about ITDs."""

    heading: float  # [rad]
    grid: Real  # centres of the ITD bins [s], (n_bins,)
    density: Real  # weighted ITD density over the grid, sums to 1 when anything was heard, (n_bins,)
    weight: float  # evidence: the sum of the weights of all bins used; 0 in silence
    peaks: tuple[float, ...] = ()  # prominent peaks of the density [s]
    features: Any = None  # what an explorer wants to keep for itself
    height: float | None = None  # of the array above the mouths of those who talk [m], None: not known


class Explorer(Protocol):
    """Finds K and every azimuth from observations at several headings."""

    name: str

    def observe(
        self,
        spectrogram: Complex,
        frequencies: Real,
        heading: float,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
    ) -> Observation:
        """Condense one orientation; spectrogram (2, n_freqs, n_frames), frequencies [Hz].

        ``frame_period`` is the time between frames [s]; when it is not told, frames overlap by three quarters.
        """

    def estimate(self, observations: Sequence[Observation]) -> Estimate:
        """Estimate K and all azimuths from every orientation heard so far."""


class TurningExplorer(Explorer, Protocol):
    """An explorer that can hear while the array turns."""

    def observe_turning(
        self,
        spectrogram: Complex,
        frequencies: Real,
        headings: Real,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
        skip: int = 0,
    ) -> Observation:
        """Condense a period in which the array turned; ``headings`` [rad] are those of the frames, (n_frames,).

        Headings are not wrapped. The first ``skip`` frames do not belong to the period: they only tell which echoes
        are still to come. Talkers are taken to be equally loud during one period.
        """


class ReconsideringExplorer(Explorer, Protocol):
    """An explorer that can be asked later, once more was heard, how sure it is of what it found."""

    def reconsider(self, observations: Sequence[Observation], believed: Estimate) -> Estimate | None:
        """Explain all observations by as many sources as are believed in, near where they are believed to be.

        Each with the probability that it is somebody; None where that cannot be. Where it is not unlikely that there
        are more talkers, the likeliest explanation with more sources is its rival.
        """


@dataclass(frozen=True, slots=True)
class Scene:
    """What a separator may know."""

    frequencies: Real  # [Hz], (n_freqs,)
    spacing: float  # d [m]
    speed_of_sound: float  # v_p [m/s]
    n_sources: int  # K
    tau: Real | None = None  # TDOA of every source at this heading [s], (n_sources,), > 0 when microphone 2 leads
    noise_psd: Real | None = None  # E|noise|^2 per bin and microphone, (n_freqs,)
    seed: int = 0
    hop: int | None = None  # between frames [samples]; None: unknown, so the frames cannot be cut again
    noise_field: Real | None = None  # coordinates of the noise covariance, (n_freqs, 4, n_frames); None: white


@dataclass(frozen=True, slots=True)
class Quality:
    """How clean a separated group is believed to be."""

    si_sdr: float  # [dB]
    si_sdri: float  # [dB]


@dataclass(frozen=True, slots=True)
class Groups:
    """Separated signals, each as heard at the reference microphone (microphone 1)."""

    signals: Complex  # (n_groups, n_freqs, n_frames)
    members: tuple[tuple[int, ...], ...]  # indices into Scene.tau that each group holds; () when unknown
    method: str  # the separator that made them
    why: str = ""  # why this method was chosen, in words
    masks: Real | None = field(default=None)  # in [0, 1], (n_groups, n_freqs, n_frames)
    quality: tuple[Quality, ...] = ()  # of every group; () when the method cannot tell


class Separator(Protocol):
    """Splits a mixture into groups of sources that share a TDOA.

    One that can also do so frame by frame has a method ``live(lookahead)`` that returns its `LiveSeparator`, which
    waits for ``lookahead`` more frames before it separates one.
    """

    name: str

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a whole recording; spectrogram (2, n_freqs, n_frames)."""


class LiveSeparator(Protocol):
    """Separates frame by frame, while people talk.

    What is quick happens in `step`, for every frame. What is slow, learning how each source sounds here, happens in
    `learn`, beside the frames, on a thread of its own; its result is taken over by `renewed` and fades in.
    """

    name: str
    lookahead: int  # frames that must be heard after a frame before it is separated

    def start(self, scene: Scene) -> Any:
        """Return the state in which nothing was heard yet: covariances follow from ``scene.tau`` alone."""

    def step(self, state: Any, frame: Complex, scene: Scene) -> tuple[Any, Groups]:
        """Hear one frame (2, n_freqs); return the state after it, and the groups of ``lookahead`` frames ago.

        Their signals are (n_groups, n_freqs, 1). The scene may change from frame to frame in its TDOAs and noise PSD,
        not in the number of sources.
        """

    def learn(self, window: Complex, scene: Scene, before: Any = None) -> Any:
        """Return what the latest frames (2, n_freqs, n_frames), heard at one heading, tell about the sources.

        ``before`` is what was learnt from the frames shortly before, at the same heading; None: nothing.
        """

    def renewed(self, state: Any, learnt: Any) -> Any:
        """Return the state that goes on with what was learnt, without a jump in level and with the groups in order.

        What was learnt at another heading may be given to the state of `start`: a separator takes from it what holds
        there too.
        """


@dataclass(frozen=True, slots=True)
class Score:
    """How much a voice sounds like the enrolled one."""

    value: float  # calibrated log-likelihood ratio [nat]; 0 is undecided
    accepted: bool  # above the criterion


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """What of a separated voice is compared with a print."""

    samples: Real  # (n_samples,), perhaps nothing
    poorness: float = 0.0  # 0: compared as it was separated; 1: soft, full of the others, only parts of it are left


class VoicePrint(Protocol):
    """One enrolled voice."""

    def score(self, voice: Real, rate: int) -> Score:
        """Compare a recording (n_samples,) at ``rate`` [Hz] with the enrolled voice."""

    def score_clips(self, clips: Sequence[Clip], rate: int) -> Score:
        """Compare what was heard of one voice with the enrolled voice: as one recording."""
        return self.score(np.concatenate([clip.samples for clip in clips]), rate)
