"""What a simulated world is heard with."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np
from scipy.signal import butter, lfilter

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.errors import AudioError
from ross_payload.interfaces import AudioBlock, AudioFlag, Real, Samples
from ross_sim.scenario import Scenario

FULL_SCALE = 2**23  # of a 24-bit converter [counts]


class Sounding(Protocol):
    """A world that sounds quantum by quantum while it is open."""

    rate: int  # [Hz]

    def open(self) -> None:
        """Begin to sound."""

    def close(self) -> None:
        """Fall silent."""

    def sound(self) -> tuple[float, Samples]:
        """Return when the next quantum began [s] and what is heard, (2, n), as soon as it is over."""


@dataclass(frozen=True, slots=True)
class Hardware:
    """What microphones and cables do to the sound at two places."""

    factors: tuple[float, float] = (1.0, 1.0)  # gain and polarity of microphones 1 and 2
    swapped: bool = False  # cables

    def recorded(self, samples: Samples) -> Samples:
        """Return what two channels carry, (2, n), rounded and clipped by the converter."""
        if self == IDEAL:
            return samples
        counts = np.rint(samples * np.array(self.factors)[:, None] * FULL_SCALE)
        heard = np.clip(counts, -FULL_SCALE, FULL_SCALE - 1).astype(np.float32) / np.float32(FULL_SCALE)
        return np.asarray(heard[::-1] if self.swapped else heard, dtype=np.float32)


IDEAL = Hardware()


class RollOffs:
    """High-passes of first order before two microphones; what comes goes on from what came.

    Parameters
    ----------
    corners
        Where microphones 1 and 2 are 3 dB down [Hz].
    rate
        Of the samples [Hz].
    """

    def __init__(self, corners: tuple[float, float], rate: int) -> None:
        self._filters = [butter(1, corner, "highpass", fs=rate) if corner else None for corner in corners]
        self._states: list[Real | None] = [None, None]

    def __bool__(self) -> bool:
        """Whether one of them is heard."""
        return any(each is not None for each in self._filters)

    def __call__(self, sounds: Real) -> Real:
        """Return the next samples (2, ..., n) as the microphones take them up."""
        if not self:
            return sounds
        heard = sounds.copy()
        for channel, filters in enumerate(self._filters):
            if filters is not None:
                sound, state = sounds[channel], self._states[channel]
                state = np.zeros((*sound.shape[:-1], 1)) if state is None else state
                heard[channel], self._states[channel] = lfilter(*filters, sound, zi=state)
        return heard


def hardware_of(scenario: Scenario) -> Hardware:
    """Return what the microphones of a scenario are like."""
    told = scenario.microphones
    if told is None:
        return IDEAL
    signs = [-1.0 if inverted else 1.0 for inverted in told.invert]
    first, second = (sign * 10 ** (gain / 20) for sign, gain in zip(signs, told.gain_db, strict=True))
    return Hardware((first, second), told.swapped)


def wiring_of(scenario: Scenario) -> ChannelMap:
    """Return what the payload makes of both channels, which are 0 and 1 here: gain, polarity, and their order."""
    wiring = ChannelMap.of(scenario.payload.audio)
    first, second = np.argsort(wiring.channels).argsort().tolist()
    return replace(wiring, channels=(first, second))


class WorldMicrophones:
    """The world's AudioSource: reading renders until enough has been heard; nothing is ever skipped.

    Parameters
    ----------
    world
        What sounds.
    wiring
        What the payload does to the samples of both channels; None: nothing.
    """

    def __init__(self, world: Sounding, wiring: ChannelMap | None = None) -> None:
        self._world = world
        self._wired = None if wiring is None else (list(wiring.channels), wiring.correction(world.rate))
        self._blocks: deque[Samples] = deque()
        self._available = 0
        self._index = 0
        self._open = self._opened = False
        self._began = math.nan  # when the first sample was heard [s]

    @property
    def rate(self) -> int:
        """Sampling rate [Hz]."""
        return self._world.rate

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
            self._hear()
        samples = self._next_samples(n)
        index, self._index = self._index, self._index + n
        clipped = samples.size and (samples.max() >= 1 - 1 / FULL_SCALE or samples.min() <= -1)
        flags = AudioFlag.CLIPPED if clipped else AudioFlag.NONE
        time = self._began + index / self.rate
        if self._wired is None:
            return AudioBlock(samples, index, time, flags=flags)
        channels, correction = self._wired
        mapped = correction.apply(samples[channels])
        return AudioBlock(mapped.samples, index, time, flags=mapped.flags, raw=mapped.raw, carried=mapped.carried)

    def __enter__(self) -> Self:
        """Open the microphones, once.

        Raises
        ------
        AudioError
            When they were opened before.
        """
        if self._opened:
            raise AudioError("the simulated microphones can be opened only once")
        self._open = self._opened = True
        self._world.open()
        return self

    def __exit__(self, *exception: object) -> None:
        """Close them."""
        self._open = False
        self._world.close()

    def _hear(self) -> None:
        begin, samples = self._world.sound()
        if math.isnan(self._began):
            self._began = begin
        self._blocks.append(samples)
        self._available += samples.shape[1]

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
