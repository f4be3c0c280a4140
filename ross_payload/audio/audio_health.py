"""How the microphones are, from what they give: ten judgements a second, each from the last seconds.

Two channels that were swapped look alike from levels: the tap test of ``ross devices`` tells them apart.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from ross_payload.audio.live_source import SourceStatus, Watched
from ross_payload.config import Config
from ross_payload.events import Event
from ross_payload.health import DEAD_DB, DEAD_FROM_HZ, AudioHealth, AudioTrouble, are_identical
from ross_payload.interfaces import UNHEARD, AudioBlock, AudioFlag, Input, Real

PER_SECOND = 10  # judgements
LEVELS, DEAD, LONG, GONE = 10, 20, 30, 5  # judgements that a verdict looks back: levels, dead, the slow ones, absent
LOSS_REPORTED_S = 10.0  # [s]
FLOOR_DB = -120.0
OFFSET, STEADY = 3e-3, 3.0  # a constant part, re full scale, and re how the means of tenths of a second vary
LOWEST, HIGHEST = 60.0, 500.0  # [Hz] in which polarity shows, between rumble and
PHASE = 0.5  # [rad] that sound along the axis turns between the microphones, at most
OPPOSITE, ALIGNED = -0.6, 0.3  # coherence below which polarity is wrong, above which it is right again
LEAST_BINS = 2  # of a tenth of a second


@dataclass(frozen=True, slots=True)
class Tenth:
    """What a tenth of a second says; pairs are of microphones 1 and 2."""

    mean: Real
    power: Real  # without the mean
    peak: Real
    constant: Real  # bool: every sample is the same
    high: Real  # power above a few hundred hertz
    product: float  # mean of the product of both, without their means
    low: Real  # power below a few hundred hertz
    low_product: float  # real part of their cross spectrum there
    clipped: bool
    missing: bool


class HealthMonitor:
    """Watches a mission and says how its microphones are; ``health`` may be called from any thread.

    Parameters
    ----------
    config
        Rate, spacing, speed of sound.
    source
        Tells what blocks do not: how much waits, what was reopened; None: nobody does.
    """

    def __init__(self, config: Config, source: Watched | None = None) -> None:
        rate, array = config.audio.rate_hz, config.array
        self._source = source
        self._size = rate // PER_SECOND
        highest = min(HIGHEST, PHASE * array.speed_of_sound_m_s / (2 * math.pi * array.spacing_m))
        frequencies = np.fft.rfftfreq(self._size, 1 / rate)
        self._bins = (frequencies >= LOWEST) & (frequencies <= highest)
        self._high = frequencies >= DEAD_FROM_HZ
        self._window = np.hanning(self._size)
        self._blocks: list[AudioBlock] = []
        self._tenths: deque[Tenth] = deque(maxlen=LONG)
        self._lost = 0
        self._lost_at = -math.inf  # [s]
        self._inverted = False
        self._health = AudioHealth()

    def on_input(self, hop: Input) -> None:
        """One hop was heard."""
        self.listen(hop.block)

    def on_event(self, event: Event, hop: Input) -> None:
        """What the mission says is not about the microphones."""

    def listen(self, block: AudioBlock) -> None:
        """Take the next block."""
        self._lost += block.lost
        if block.lost or block.flags & UNHEARD:
            self._lost_at = block.time
        self._blocks.append(block)
        if sum(each.samples.shape[1] for each in self._blocks) >= self._size:
            self._tenths.append(self._tenth())
            self._blocks.clear()
            self._health = self._judge(block.time)

    def health(self) -> AudioHealth:
        """How the microphones are."""
        status = SourceStatus() if self._source is None else self._source.status()
        gone = AudioTrouble.ABSENT if status.trouble else AudioTrouble.NONE
        return replace(
            self._health,
            trouble=self._health.trouble | gone,
            lost=self._lost + status.lost,
            reopened=status.reopened,
            waiting=status.waiting,
            rate=status.rate,
        )

    def _tenth(self) -> Tenth:
        samples = np.concatenate([block.samples for block in self._blocks], axis=1, dtype=np.float64)
        mean = samples.mean(axis=1)
        moving = samples - mean[:, None]
        whole = np.fft.rfft(moving[:, : self._size] * self._window)
        spectrum = whole[:, self._bins]
        flags = [block.flags for block in self._blocks]
        return Tenth(
            mean=mean,
            power=np.mean(moving**2, axis=1),
            peak=np.abs(samples).max(axis=1),
            constant=np.ptp(samples, axis=1) == 0,
            high=np.sum(np.abs(whole[:, self._high]) ** 2, axis=1),
            product=float(np.mean(moving[0] * moving[1])),
            low=np.sum(np.abs(spectrum) ** 2, axis=1),
            low_product=float(np.sum((spectrum[0] * spectrum[1].conj()).real)),
            clipped=any(flag & AudioFlag.CLIPPED for flag in flags),
            missing=any(flag & AudioFlag.MISSING for flag in flags),
        )

    def _judge(self, now: float) -> AudioHealth:
        recent = list(self._tenths)[-LEVELS:]
        tenths = [tenth for tenth in self._tenths if not tenth.missing]
        trouble = _dead(tenths[-DEAD:]) | _offset(tenths) | _identical(tenths) | self._polarity(tenths)
        if any(tenth.clipped for tenth in recent):
            trouble |= AudioTrouble.CLIPPING
        if now - self._lost_at < LOSS_REPORTED_S:
            trouble |= AudioTrouble.LOST
        last = list(self._tenths)[-GONE:]
        if len(last) == GONE and all(tenth.missing and tenth.constant.all() for tenth in last):
            trouble |= AudioTrouble.ABSENT
        power = np.mean([tenth.power + tenth.mean**2 for tenth in recent], axis=0)
        peak = np.max([tenth.peak for tenth in recent], axis=0)
        return AudioHealth(trouble=trouble, level_db=_decibels(power), peak_db=_decibels(peak**2))

    def _polarity(self, tenths: list[Tenth]) -> AudioTrouble:
        """Sound that is long against the spacing is the same at both; the opposite is a wrong polarity."""
        powers = np.prod(np.sum([tenth.low for tenth in tenths], axis=0)) if tenths else 0.0
        if len(tenths) == LONG and np.count_nonzero(self._bins) >= LEAST_BINS and powers > 0:
            coherence = sum(tenth.low_product for tenth in tenths) / math.sqrt(powers)
            self._inverted = coherence < (ALIGNED if self._inverted else OPPOSITE)
        return AudioTrouble.INVERTED if self._inverted else AudioTrouble.NONE


def _dead(tenths: list[Tenth]) -> AudioTrouble:
    if len(tenths) < DEAD:
        return AudioTrouble.NONE
    silent = np.all([tenth.constant for tenth in tenths], axis=0)
    power = np.array([tenth.high for tenth in tenths]) + 1e-30
    louder = float(np.median(10 * np.log10(power[:, 0] / power[:, 1])))
    trouble = AudioTrouble.NONE
    if silent[0] or (louder < -DEAD_DB and not silent[1]):
        trouble |= AudioTrouble.DEAD_1
    if silent[1] or (louder > DEAD_DB and not silent[0]):
        trouble |= AudioTrouble.DEAD_2
    return trouble


def _offset(tenths: list[Tenth]) -> AudioTrouble:
    if len(tenths) < LONG:
        return AudioTrouble.NONE
    means = np.array([tenth.mean for tenth in tenths])
    mean = np.abs(means.mean(axis=0))
    found = np.any((mean > OFFSET) & (mean > STEADY * means.std(axis=0)))
    return AudioTrouble.OFFSET if found else AudioTrouble.NONE


def _identical(tenths: list[Tenth]) -> AudioTrouble:
    if len(tenths) < LONG:
        return AudioTrouble.NONE
    first, second = np.mean([tenth.power for tenth in tenths], axis=0)
    product = float(np.mean([tenth.product for tenth in tenths]))
    return AudioTrouble.IDENTICAL if are_identical(first, second, product) else AudioTrouble.NONE


def _decibels(power: Real) -> tuple[float, float]:
    first, second = np.maximum(10 * np.log10(np.maximum(power, 1e-30)), FLOOR_DB)
    return float(first), float(second)
