"""The world in lock-step: the far end turns the array, the room sounds, the microphones hear both."""

from __future__ import annotations

import itertools
import math
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ross_payload.dsp.roll_off import RollOffMatch
from ross_payload.errors import AudioError, ConfigError
from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.render import HeadingSignals, Microphones, MotorNoise
from ross_sim.autopilot.yaw import Yaw
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.far_end import FarEnd, Fault
from ross_sim.scenario import Scenario
from ross_sim.sitl.noise_heard import noise_heard
from ross_sim.sitl.talkers_heard import LEVEL, talkers_heard
from ross_sim.sitl.world_microphones import FULL_SCALE, RollOffs, WorldMicrophones, hardware_of, wiring_of
from ross_sim.talkers.speech import TalkerVoice

Counts = NDArray[np.int32]

LOUDEST = np.float32(2**26)  # of a talker or of all noise [counts], 8 times full scale; 30 of them fit into 32 bits
AHEAD = 25  # quanta that are rendered at once while nothing turns, from multiples of so many on


@dataclass(frozen=True, slots=True, eq=False)
class Rendered:
    """A stretch of what was heard, and why."""

    images: Samples  # every talker alone, noise-free, (2, n_talkers, n)
    mixture: Samples  # what the converter puts out, (2, n)
    headings: Real  # true, at the ends of every quantum [rad], mount frame, (n_quanta + 1,)


@dataclass(frozen=True, slots=True)
class Quantum:
    """What a quantum of 10 ms sounds like depends on this alone."""

    begin: float  # when [s]
    headings: tuple[float, float]  # true, at its ends [rad], frame of the room
    joints: tuple[float, float]  # angles of the plant there [rad]


@dataclass(frozen=True, slots=True, eq=False)
class Sounds:
    """What is heard in a quantum or in some."""

    images: Counts  # every talker alone, noise-free, (2, n_talkers, n)
    noise: Counts  # (2, n)
    recorded: Samples  # what the converter puts out, (2, n)

    def between(self, first: int, last: int) -> Sounds:
        """The samples from ``first`` to before ``last``."""
        return Sounds(self.images[..., first:last], self.noise[:, first:last], self.recorded[:, first:last])


class World:
    """A scene and a plant on one clock.

    In each quantum of 10 ms the far end lives first, then the quantum is rendered with the *true* heading at both its
    ends: the plant's joint angle on a vehicle that may yaw. Sound begins when the microphones are opened: their first
    sample is time 0 of the scenario.

    Every part (one image per talker, the noise) is rounded to the 24-bit grid on its own, so that the parts add up to
    the mixture to the last bit unless it clips. Sensor noise is white, independent at each microphone, and drawn
    quantum by quantum, so that it does not depend on how the audio is read. While nothing turns some quanta are
    rendered at once, unless the microphones roll off; what was rendered too far ahead is forgotten.

    Parameters
    ----------
    scenario
        Who talks where and when.
    voices
        One per talker, in their order: the ``talkers`` of ``scenario.cast``.
    far_end
        What turns the array.
    clock
        Advances the world.
    seed
        Of sensor and motor noise, and of noise sources that are made.
    cache
        Folder of the room cache; None: see ``cache_folder``.
    wait
        Waits for the clock, which another thread advances: then quanta are rendered on the thread that reads the
        microphones. None: who reads them advances the clock.

    Raises
    ------
    ConfigError
        When there is not one voice per talker, or at another rate; or when a trouble makes no sense for the actuator.
    """

    def __init__(
        self,
        scenario: Scenario,
        voices: Sequence[TalkerVoice],
        far_end: FarEnd,
        clock: SimClock,
        seed: int,
        *,
        cache: Path | None = None,
        wait: Callable[[], None] | None = None,
    ) -> None:
        self.azimuths = scenario.azimuths()
        self.elevations = scenario.elevations()
        self.clock = clock
        self._wait = wait
        self.rate = scenario.payload.audio.rate_hz
        self._wiring = None if scenario.microphones is None else wiring_of(scenario)
        self.source = WorldMicrophones(self, self._wiring)
        self._far_end = far_end
        self._offset = scenario.offset
        self._angle = far_end.angle()
        self._vehicle = Yaw() if scenario.vehicle is None else scenario.vehicle.motion()
        self._turned = self._vehicle.turned(clock.now())
        reference = _reference(scenario)
        self._noise_rms = reference * 10 ** (-scenario.noise.snr_db / 20)
        motor_rms = LEVEL * 10 ** (scenario.noise.motor_db / 20)  # at full strength
        sensor, motor, room = np.random.SeedSequence(seed).spawn(3)
        self._sensor = np.random.Generator(np.random.PCG64(sensor))
        self._motor = MotorNoise(motor_rms, np.random.Generator(np.random.PCG64(motor)))
        self._talkers = talkers_heard(scenario, voices, cache)
        self._beside = noise_heard(scenario, reference, room, cache)
        self._spacing = scenario.spacing
        self._turns_heard = scenario.room.turns_heard
        self._hardware = hardware_of(scenario)
        corners = (0.0, 0.0) if scenario.microphones is None else scenario.microphones.roll_off_hz
        self._talkers_roll_off, self._noise_roll_off = RollOffs(corners, self.rate), RollOffs(corners, self.rate)
        self._microphones: Microphones | None = None
        self._around: list[Microphones] = []  # what they hear of noise sources in the room
        self._aboard: list[Microphones] = []  # and on the vehicle
        self._lived = clock.now()
        self._quanta = 0  # since the sound began
        self._rendered = 0  # of them
        self._waiting: deque[Quantum] = deque()  # to be rendered, where sound has a thread of its own
        self._sounded: deque[tuple[float, Samples]] = deque()  # to be heard, where it has none
        self._drawn: deque[Samples] = deque()  # sensor noise of the quanta to come
        self._ahead: deque[Sounds] = deque()  # of the same, if nothing turns
        self._troubles = _troubles(scenario, far_end)
        self._guard = threading.Lock()  # of what was rendered
        self._images: list[Counts] = []
        self._noise: list[Counts] = []
        self._headings: list[float] = []
        clock.before_calls(self.advance)

    def open(self) -> None:
        """Begin to sound."""
        heading = self._heading()
        self._headings.append(heading)
        self._microphones = self._microphones_of(self._talkers, heading)
        self._around = [self._microphones_of(heard, heading) for heard in self._beside.room]
        self._aboard = [self._microphones_of(heard, self._angle + self._offset) for heard in self._beside.vehicle]

    def close(self) -> None:
        """Fall silent; the plant lives on."""
        self._microphones = None

    def advance(self, now: float) -> None:
        """Live until ``now`` [s], one quantum later."""
        sounds = self._microphones is not None
        while sounds and self._troubles and self._troubles[0][0] <= self._quanta * QUANTUM:
            self._far_end.afflict(*self._troubles.popleft()[1:])
        heading, angle = self._heading(), self._angle
        self._far_end.advance(now)
        self._angle = self._far_end.angle()
        self._turned = self._vehicle.turned(now)
        if sounds:
            self._quanta += 1
            quantum = Quantum(self._lived, (heading, self._heading()), (angle, self._angle))
            if self._wait is None:
                self._sounded.append(self._render(quantum))
            else:
                self._waiting.append(quantum)
        self._lived = now

    def sound(self) -> tuple[float, Samples]:
        """Return when the next quantum began [s] and what is heard, (2, n), as soon as it is over."""
        if self._wait is None:
            while not self._sounded:
                self.clock.advance()
            return self._sounded.popleft()
        while not self._waiting:
            self._wait()
        return self._render(self._waiting.popleft())

    def rotor_speeds(self) -> list[float]:
        """Return how fast the rotors that are made turn at this moment [1/s]."""
        sample = round(self._quanta * QUANTUM * self.rate)
        return [float(speeds[sample % speeds.size]) for speeds in self._beside.rotor_speeds]

    def drain(self) -> Rendered:
        """Hand over what was rendered since the last call and forget it: a world that lives for hours must not grow."""
        with self._guard:
            kept, noises, headings = self._images, self._noise, self.headings()
            self._images, self._noise, self._headings = [], [], self._headings[-1:]
        images = np.concatenate([np.zeros((2, len(self.azimuths), 0), np.int32), *kept], axis=-1)
        return Rendered(_samples(images), self._hardware.recorded(_mixture(kept, noises)), headings)

    def images(self) -> Samples:
        """Every talker alone at microphone 1, noise-free, for all that was rendered so far, (n_talkers, n).

        The roll-off is that to which the payload corrects it, since it shifts the phase.
        """
        alone = _joined([image[0] for image in self._images], len(self.azimuths))
        if self._wiring is None or not any(self._wiring.roll_offs):
            return alone
        both = [RollOffMatch(self._wiring.roll_offs, self.rate)(np.stack([each, each])) for each in alone]
        return np.stack([first for first, _ in both])

    def noise(self) -> Samples:
        """All noise, of sensors, motor and noise sources, (2, n)."""
        return _joined(self._noise, 2)

    def mixture(self) -> Samples:
        """What the converter puts out at both microphones, (2, n)."""
        return self._hardware.recorded(_mixture(self._images, self._noise))

    def headings(self) -> Real:
        """The true heading at the ends of every quantum since the opening [rad], frame of the room, (n_quanta + 1,)."""
        return np.asarray(self._headings)

    def _microphones_of(self, heard: HeadingSignals, heading: float) -> Microphones:
        return Microphones(heard, self._spacing, heading, turns_heard=self._turns_heard)

    def _heading(self) -> float:
        return self._angle + self._offset + self._turned

    def _render(self, quantum: Quantum) -> tuple[float, Samples]:
        microphones = self._microphones
        if microphones is None:
            raise AudioError("the simulated microphones are not open")
        if self._talkers_roll_off or not self._rests(microphones, quantum):
            self._ahead = deque(self._sounds(microphones, quantum, 1))
        elif not self._ahead:
            self._ahead = deque(self._sounds(microphones, quantum, AHEAD - self._rendered % AHEAD))
        sounds = self._ahead.popleft()
        self._drawn.popleft()
        self._rendered += 1
        with self._guard:
            self._images.append(sounds.images)
            self._noise.append(sounds.noise)
            self._headings.append(quantum.headings[1])
        return quantum.begin, sounds.recorded

    def _rests(self, microphones: Microphones, quantum: Quantum) -> bool:
        """Whether nothing turns, and nothing did in the quantum before."""
        room = all(heard.rests(*quantum.headings) for heard in (microphones, *self._around))
        vehicle = all(heard.rests(*self._aboard_headings(quantum)) for heard in self._aboard)
        return room and vehicle and self._motor.rests(*quantum.joints)

    def _aboard_headings(self, quantum: Quantum) -> tuple[float, float]:
        begin, end = quantum.joints
        return begin + self._offset, end + self._offset

    def _sounds(self, microphones: Microphones, quantum: Quantum, n_quanta: int) -> list[Sounds]:
        """Sound of the next quantum, and of those after it if nothing turns."""
        ends = [(self._rendered + index) * self.rate // round(1 / QUANTUM) for index in range(n_quanta + 1)]
        first, last = ends[0], ends[-1]
        images = _counts(self._talkers_roll_off(microphones.render(first, last, *quantum.headings)))
        for low, high in itertools.pairwise(ends[len(self._drawn) :]):
            self._drawn.append(self._sensor.standard_normal((2, high - low), dtype=np.float32))
        noise = np.concatenate([self._drawn[index] for index in range(n_quanta)], axis=1)
        noise *= np.float32(self._noise_rms)
        noise += self._motor.between(*quantum.joints, last - first)
        for beside in self._around:
            noise += beside.render(first, last, *quantum.headings).sum(axis=1)
        for beside in self._aboard:
            noise += beside.render(first, last, *self._aboard_headings(quantum)).sum(axis=1)
        noise += self._beside.at_microphones(first, last)
        counts = _counts(self._noise_roll_off(noise))
        heard = self._hardware.recorded(_samples(_converted(images.sum(axis=1, dtype=np.int32) + counts)))
        every = Sounds(images, counts, heard)
        return [every.between(low - first, high - first) for low, high in itertools.pairwise(ends)]


def _troubles(scenario: Scenario, far_end: FarEnd) -> deque[tuple[float, Fault, bool]]:
    """What goes wrong in order of time: when [s since the sound began], what, and whether it begins or ends."""
    kind = scenario.payload.actuator.kind
    moments = []
    for trouble in scenario.troubles:
        if trouble.fault not in far_end.faults:
            there = ", ".join(sorted(far_end.faults)) or "none"
            raise ConfigError(f"troubles: expected a fault of {kind} ({there}), got '{trouble.fault}'")
        moments.append((trouble.at_s, trouble.fault, True))
        moments += [] if trouble.end_s is None else [(trouble.end_s, trouble.fault, False)]
    return deque(sorted(moments))


def _reference(scenario: Scenario) -> float:
    """Root mean square of what the SNRs of a scenario refer to."""
    if scenario.noise.snr_reference == "mixture" or not scenario.talkers:
        return LEVEL
    return LEVEL / math.sqrt(sum(10 ** (talker.level_db / 10) for talker in scenario.talkers))


def _counts(samples: Samples) -> Counts:
    counts = np.rint(samples * np.float32(FULL_SCALE))
    return np.asarray(np.minimum(np.maximum(counts, -LOUDEST), LOUDEST), dtype=np.int32)


def _converted(counts: Counts) -> Counts:
    return np.asarray(np.minimum(np.maximum(counts, -FULL_SCALE), FULL_SCALE - 1))


def _samples(counts: Counts) -> Samples:
    return np.asarray(counts, dtype=np.float32) / np.float32(FULL_SCALE)


def _mixture(images: Sequence[Counts], noises: Sequence[Counts]) -> Samples:
    pairs = zip(images, noises, strict=True)
    return _joined([_converted(image.sum(axis=1, dtype=np.int32) + noise) for image, noise in pairs], 2)


def _joined(counts: Sequence[Counts], rows: int) -> Samples:
    return _samples(np.concatenate([np.zeros((rows, 0), dtype=np.int32), *counts], axis=1))
