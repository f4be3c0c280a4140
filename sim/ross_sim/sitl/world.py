"""The world in lock-step: the far end turns the array, the room sounds, the microphones hear both."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ross_payload.errors import AudioError, ConfigError
from ross_payload.interfaces import AudioBlock, AudioFlag, Real, Samples
from ross_sim.acoustics.render import Microphones, MotorNoise
from ross_sim.autopilot.simulated_autopilot import Yaw
from ross_sim.clock import QUANTUM, SimClock
from ross_sim.devices.far_end import FarEnd, Fault
from ross_sim.scenario import Scenario
from ross_sim.sitl.talkers_heard import LEVEL, talkers_heard
from ross_sim.talkers.speech import TalkerVoice

Counts = NDArray[np.int32]

FULL_SCALE = 2**23  # of a 24-bit converter [counts]


@dataclass(frozen=True, slots=True, eq=False)
class Rendered:
    """A stretch of what was heard, and why."""

    images: Samples  # every talker alone, noise-free, (2, n_talkers, n)
    mixture: Samples  # what the converter puts out, (2, n)
    headings: Real  # true, at the ends of every quantum [rad], mount frame, (n_quanta + 1,)


class World:
    """A scene and a plant on one clock.

    In each quantum of 10 ms the far end lives first, then the quantum is rendered with the *true* heading at both its
    ends: the plant's joint angle on a vehicle that may yaw. Sound begins when the microphones are opened: their first
    sample is time 0 of the scenario.

    Every part (one image per talker, the noise) is rounded to the 24-bit grid on its own, so that the parts add up to
    the mixture to the last bit unless it clips. Sensor noise is white, independent at each microphone, and drawn
    quantum by quantum, so that it does not depend on how the audio is read.

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
        Of sensor and motor noise.
    cache
        Folder of the room cache; None: see ``cache_folder``.

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
    ) -> None:
        self.azimuths = scenario.azimuths()
        self.elevations = scenario.elevations()
        self.clock = clock
        self.rate = scenario.payload.audio.rate_hz
        self.source = WorldMicrophones(self)
        self._far_end = far_end
        self._offset = scenario.payload.offset
        self._angle = far_end.angle()
        self._vehicle = Yaw() if scenario.vehicle is None else scenario.vehicle.motion()
        self._turned = self._vehicle.turned(clock.now())
        self._noise_rms, motor_rms = _noise_levels(scenario)
        sensor, motor = np.random.SeedSequence(seed).spawn(2)
        self._sensor = np.random.Generator(np.random.PCG64(sensor))
        self._motor = MotorNoise(motor_rms, np.random.Generator(np.random.PCG64(motor)))
        self._talkers = talkers_heard(scenario, voices, cache)
        self._spacing = scenario.payload.array.spacing_m
        self._microphones: Microphones | None = None
        self._quanta = 0
        self._troubles = _troubles(scenario, far_end)
        self._images: list[Counts] = []
        self._noise: list[Counts] = []
        self._headings: list[float] = []
        clock.before_calls(self.advance)

    def open(self) -> None:
        """Begin to sound."""
        self._microphones = Microphones(self._talkers, self._spacing, self._heading())
        self._headings.append(self._heading())

    def close(self) -> None:
        """Fall silent; the plant lives on."""
        self._microphones = None

    def advance(self, now: float) -> None:
        """Live until ``now`` [s], one quantum later."""
        while self._microphones is not None and self._troubles and self._troubles[0][0] <= self._quanta * QUANTUM:
            self._far_end.afflict(*self._troubles.popleft()[1:])
        begin, angle = self._heading(), self._angle
        self._far_end.advance(now)
        self._angle = self._far_end.angle()
        self._turned = self._vehicle.turned(now)
        if self._microphones is not None:
            self._sound(self._microphones, begin, angle)

    def drain(self) -> Rendered:
        """Hand over what was rendered since the last call and forget it: a world that lives for hours must not grow."""
        images = np.concatenate([np.zeros((2, len(self.azimuths), 0), np.int32), *self._images], axis=-1)
        rendered = Rendered(_samples(images), self.mixture(), self.headings())
        self._images, self._noise, self._headings = [], [], self._headings[-1:]
        return rendered

    def images(self) -> Samples:
        """Every talker alone at microphone 1, noise-free, for all that was rendered so far, (n_talkers, n)."""
        return _joined([image[0] for image in self._images], len(self.azimuths))

    def noise(self) -> Samples:
        """All noise, sensor and motor, (2, n)."""
        return _joined(self._noise, 2)

    def mixture(self) -> Samples:
        """What the converter puts out at both microphones, (2, n)."""
        pairs = zip(self._images, self._noise, strict=True)
        return _joined([_converted(image.sum(axis=1, dtype=np.int32) + noise) for image, noise in pairs], 2)

    def headings(self) -> Real:
        """The true heading at the ends of every quantum since the opening [rad], frame of the room, (n_quanta + 1,)."""
        return np.asarray(self._headings)

    def _heading(self) -> float:
        return self._angle + self._offset + self._turned

    def _sound(self, microphones: Microphones, begin: float, angle: float) -> None:
        first = self._quanta * self.rate // round(1 / QUANTUM)
        self._quanta += 1
        last = self._quanta * self.rate // round(1 / QUANTUM)
        images = _counts(microphones.render(first, last, begin, self._heading()))
        noise = self._noise_rms * self._sensor.standard_normal((2, last - first), dtype=np.float32)
        noise = noise + self._motor.between(angle, self._angle, last - first)
        self._images.append(images)
        self._noise.append(_counts(noise))
        self._headings.append(self._heading())
        self.source.put(_samples(_converted(images.sum(axis=1, dtype=np.int32) + self._noise[-1])))


class WorldMicrophones:
    """The world's AudioSource: reading advances the clock until enough has been heard; nothing is ever skipped."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._blocks: deque[Samples] = deque()
        self._available = 0
        self._index = 0
        self._open = False
        self._opened_at = math.nan

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._world.rate

    def put(self, samples: Samples) -> None:
        """Take a quantum, (2, n)."""
        self._blocks.append(samples)
        self._available += samples.shape[1]

    def read(self, n: int) -> AudioBlock:
        """Return the next ``n`` samples.

        Raises
        ------
        AudioError
            When the source is not open.
        """
        if not self._open:
            raise AudioError("the simulated microphones are not open")
        while self._available < n:
            self._world.clock.advance()
        samples = self._next_samples(n)
        index, self._index = self._index, self._index + n
        clipped = samples.size and (samples.max() >= 1 - 1 / FULL_SCALE or samples.min() <= -1)
        flags = AudioFlag.CLIPPED if clipped else AudioFlag.NONE
        return AudioBlock(samples, index, self._opened_at + index / self.rate, flags=flags)

    def __enter__(self) -> Self:
        """Open the microphones, once.

        Raises
        ------
        AudioError
            When they were opened before.
        """
        if not math.isnan(self._opened_at):
            raise AudioError("the simulated microphones can be opened only once")
        self._open, self._opened_at = True, self._world.clock.now()
        self._world.open()
        return self

    def __exit__(self, *exception: object) -> None:
        """Close them."""
        self._open = False
        self._world.close()

    def _next_samples(self, n: int) -> Samples:
        self._available -= n
        if self._blocks and self._blocks[0].shape[1] == n:
            return self._blocks.popleft()
        parts, wanted = [np.zeros((2, 0), dtype=np.float32)], n
        while wanted:
            head = self._blocks.popleft()
            parts.append(head[:, :wanted])
            if head.shape[1] > wanted:
                self._blocks.appendleft(head[:, wanted:])
            wanted -= parts[-1].shape[1]
        return np.concatenate(parts, axis=1)


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


def _noise_levels(scenario: Scenario) -> tuple[float, float]:
    """Root mean square of the sensor noise and, at full strength, of the motor's."""
    reference = LEVEL
    if scenario.noise.snr_reference == "talker" and scenario.talkers:
        reference /= math.sqrt(sum(10 ** (talker.level_db / 10) for talker in scenario.talkers))
    return reference * 10 ** (-scenario.noise.snr_db / 20), LEVEL * 10 ** (scenario.noise.motor_db / 20)


def _counts(samples: Samples) -> Counts:
    return np.asarray(np.rint(samples * np.float32(FULL_SCALE)), dtype=np.int32)


def _converted(counts: Counts) -> Counts:
    return np.asarray(np.minimum(np.maximum(counts, -FULL_SCALE), FULL_SCALE - 1))


def _samples(counts: Counts) -> Samples:
    return np.asarray(counts, dtype=np.float32) / np.float32(FULL_SCALE)


def _joined(counts: Sequence[Counts], rows: int) -> Samples:
    return _samples(np.concatenate([np.zeros((rows, 0), dtype=np.int32), *counts], axis=1))
