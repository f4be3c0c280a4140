"""What the microphones hear while the array rests or turns: every talker, and the motor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from ross_payload.interfaces import Samples
from ross_sim.acoustics.impulse_responses import microradians
from ross_sim.clock import QUANTUM

Spectra = NDArray[np.complex64]

CHUNK = 0.5  # convolved at once [s]
DISPLACEMENT = 2.2e-3  # of a microphone between two neighbours of the grid, at most [m]: 18 deg of phase at 8 kHz
REMEMBERED = 48  # chunks and spectra kept
STILL = 2e-6  # a quantum that turns by less is at rest [rad]
QUANTA_STILL = 3  # before the response of the exact heading is faded in
DRIFT = 1e-5  # from there on the exact heading serves within this [rad]


class HeadingResponses(Protocol):
    """Impulse responses at any heading."""

    @property
    def n_taps(self) -> int:
        """Taps of a response, at most."""

    def at(self, heading: float) -> Samples:
        """Return the responses at a heading [rad], (2, n_sources, at most n_taps)."""


class HeadingSignals(Protocol):
    """Signals of talkers at any heading."""

    def at(self, heading: float, first: int, last: int) -> Samples:
        """Return what is heard at a heading [rad] from sample ``first`` to before ``last``, (2, n_talkers, n)."""


class Sounding(Protocol):
    """What a source sounds like, sample by sample."""

    def between(self, first: int, last: int) -> Samples:
        """Return the samples from ``first`` to before ``last``, (last - first,)."""


class TalkerSignals:
    """Every talker's speech as heard at one heading, convolved by the chunk and remembered.

    Chunks begin at multiples of their length, so that a sample does not depend on who asked for it, or when.
    """

    def __init__(
        self, timelines: Sequence[Sounding], gains: Sequence[float], responses: HeadingResponses, rate: int
    ) -> None:
        self._timelines = timelines
        self._gains = np.asarray(gains, dtype=np.float32)
        self._responses = responses
        self._length = round(CHUNK * rate)
        self._size = next_fast_len(self._length + responses.n_taps - 1, real=True)
        self._chunk = lru_cache(REMEMBERED)(self._convolve)
        self._filters = lru_cache(REMEMBERED)(self._filter_spectra)
        self._dry = lru_cache(4)(self._dry_spectra)

    def at(self, heading: float, first: int, last: int) -> Samples:
        """Return what is heard at a heading [rad] from sample ``first`` to before ``last``, (2, n_talkers, n)."""
        step = microradians(heading)
        parts = []
        for index in range(first // self._length, -(-last // self._length)):
            begin = index * self._length
            parts.append(self._chunk(step, index)[..., max(first - begin, 0) : last - begin])
        return parts[0] if len(parts) == 1 else np.concatenate(parts, axis=-1)

    def _convolve(self, step: int, index: int) -> Samples:
        dry = self._dry(index)
        if dry is None:
            return np.zeros((2, len(self._timelines), self._length), dtype=np.float32)
        before = self._responses.n_taps - 1
        wet = irfft(dry * self._filters(step), self._size)  # overlap-save: the first n_taps - 1 samples wrap around
        return np.asarray(wet[..., before : before + self._length], dtype=np.float32)

    def _dry_spectra(self, index: int) -> Spectra | None:
        last = (index + 1) * self._length
        first = index * self._length - self._responses.n_taps + 1
        dry = np.stack([talk.between(first, last) for talk in self._timelines]) if self._timelines else np.zeros((0, 1))
        if not dry.any():
            return None
        return np.asarray(rfft(dry * self._gains[:, None], self._size), dtype=np.complex64)

    def _filter_spectra(self, step: int) -> Spectra:
        return np.asarray(rfft(self._responses.at(step * 1e-6), self._size), dtype=np.complex64)


class Microphones:
    """Two microphones that turn: the exact heading at rest, a grid of headings while turning, no clicks between.

    While turning, the wet signals of neighbours on the grid are mixed linearly, sample by sample, by the true
    heading. After three quanta at rest the response of the exact heading is faded in within one quantum; when the
    array moves away it is faded out likewise. Where turns are not heard, what is heard at the last heading at rest
    goes on instead: nearly all responses of a mission are those of turns, which in a room take most of its time.
    """

    def __init__(self, stems: HeadingSignals, spacing: float, heading: float, *, turns_heard: bool = True) -> None:
        self._stems = stems
        self._held = None if turns_heard else heading
        self._step = 2 * math.pi / max(72, math.ceil(math.pi * spacing / DISPLACEMENT))
        self._exact: float | None = heading
        self._quanta_still = QUANTA_STILL

    def render(self, first: int, last: int, begin: float, end: float) -> Samples:
        """Return one quantum from heading ``begin`` to ``end`` [rad], (2, n_talkers, n)."""
        before, self._exact = self._exact, self._settle(begin, end)
        if before is not None and before == self._exact:
            return self._stems.at(before, first, last)
        if self._held is not None:
            turning = self._stems.at(self._held, first, last)
            self._held = self._held if self._exact is None else self._exact
        else:
            turning = self._turning(first, last, begin, end)
        fade = np.linspace(0, 1, last - first, dtype=np.float32)
        if before is not None:
            turning = turning + (1 - fade) * (self._stems.at(before, first, last) - turning)
        if self._exact is not None:
            turning = turning + fade * (self._stems.at(self._exact, first, last) - turning)
        return turning

    def rests(self, begin: float, end: float) -> bool:
        """Tell whether a quantum sounds as the one before does: `render` may then be asked for several at once."""
        return self._exact is not None and max(abs(begin - self._exact), abs(end - self._exact)) < DRIFT

    def _settle(self, begin: float, end: float) -> float | None:
        if self.rests(begin, end):
            return self._exact
        still = self._exact is None and abs(end - begin) < STILL
        self._quanta_still = self._quanta_still + 1 if still else 0
        return end if self._quanta_still >= QUANTA_STILL else None

    def _turning(self, first: int, last: int, begin: float, end: float) -> Samples:
        path = (begin + (end - begin) * np.arange(1, last - first + 1) / (last - first)) / self._step
        nodes = range(math.floor(path.min()), math.floor(path.max()) + 2)
        heard = np.zeros((1, 1, 1), dtype=np.float32)
        for node in nodes:
            weight = np.clip(1 - np.abs(path - node), 0, 1).astype(np.float32)
            heard = heard + weight * self._stems.at(node * self._step, first, last)
        return heard


def gains(speech: Sequence[Samples], levels_db: Sequence[float], response: Samples, rms: float) -> list[float]:
    """Gains that give every talker equal power (and its level) at microphone 1, and all together ``rms``.

    Powers are averaged over the whole recording, (n,) each, through ``response`` (2, n_talkers, n_taps); talkers are
    taken as uncorrelated.

    >>> delta = np.ones((2, 2, 1), dtype=np.float32)
    >>> loud, soft = gains([np.ones(9), np.full(9, 0.1)], [0.0, 0.0], delta, rms=np.sqrt(2))
    >>> round(loud, 6), round(soft, 6)
    (1.0, 10.0)
    """
    powers = [
        float(np.mean(_filtered(said, taps).astype(float) ** 2)) for said, taps in zip(speech, response[0], strict=True)
    ]
    wanted = [10 ** (level / 10) for level in levels_db]
    return [float(rms) * math.sqrt(want / sum(wanted) / power) for want, power in zip(wanted, powers, strict=True)]


def _filtered(signal: Samples, taps: Samples) -> Samples:
    """Filter a signal, (n,), by overlap-add in blocks that stay in the processor's cache; the same (n,) samples.

    `scipy.signal.oaconvolve` does so too; to import that package takes as long as a short mission.
    """
    size = next_fast_len(4 * taps.size, real=True)
    step = size - taps.size + 1  # no shorter than what rings on from one block into the next
    blocks = np.zeros((-(-signal.size // step), step), dtype=signal.dtype)
    blocks.reshape(-1)[: signal.size] = signal
    ringing = irfft(rfft(blocks, size) * rfft(taps, size), size)
    ringing[1:, : taps.size - 1] += ringing[:-1, step:]
    return np.asarray(ringing[:, :step].reshape(-1)[: signal.size])


FULL_STEP = math.radians(1.8)  # of a NEMA 17
LOUD = math.radians(20)  # at this speed the noise has its full strength [rad/s]


@dataclass(slots=True)
class MotorNoise:
    """Tones at the rate of full steps and twice that, and broadband noise; silent at rest.

    The motor sits under the middle of the array: both microphones hear the same. The phase of the tones is that of
    the shaft, so that they follow every acceleration; the strength follows the speed and fades over a quantum. Half
    of the power is tonal.
    """

    rms: float  # at full strength, re full scale
    generator: np.random.Generator  # of the broadband part
    _strength: float = 0.0

    def rests(self, begin: float, end: float) -> bool:
        """Tell whether it is silent, and was."""
        return self._strength == 0.0 and begin == end

    def between(self, begin: float, end: float, n: int) -> Samples | float:
        """Return ``n`` samples while the shaft turns from ``begin`` to ``end`` [rad], (n,); 0 at rest."""
        speed = abs(end - begin) / QUANTUM
        before, self._strength = self._strength, min(speed / LOUD, 1.0)
        if before == self._strength == 0.0:
            return 0.0
        phase = 2 * math.pi * np.linspace(begin, end, n, endpoint=False) / FULL_STEP
        tonal = 0.8 * np.sin(phase) + 0.6 * np.sin(2 * phase)  # power 1/2
        broadband = math.sqrt(0.5) * self.generator.standard_normal(n, dtype=np.float32)
        strength = np.linspace(before, self._strength, n, endpoint=False)
        return np.asarray(self.rms * strength * (tonal + broadband), dtype=np.float32)
