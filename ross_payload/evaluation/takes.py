"""Two takes of one scene: with interference, and the target alone; read, checked and brought to one time axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.fft
from scipy.signal import resample_poly

from ross_payload.audio.audio_files import read_audio
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.dsp.dc_offset import without_offset
from ross_payload.errors import AudioError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.speaker_model import CLIPPED_SHARE, clipped_share

SHORTEST = 1.0  # of a take, and of what two takes have in common [s]
LOWEST_RATE = 8000  # [Hz]
SILENCE = 1e-5  # root mean square, -100 dB re full scale
SAME = 1e-6  # part of the power of a channel that is not in the other where both are one, -60 dB: dither adds less
ABSENT = 0.1  # correlation of two takes below which they have no talker in common; another voice reaches 0.05
WHOLE = 0.1  # a delay this near to a whole number of samples is one
REACH = 16  # samples of the correlation on either side that tell its fractional peak
FINE = 0.01  # resolution of that peak [samples]
UNCORRECTED = ChannelMap((0, 1))


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """A recording of both microphones."""

    samples: Real  # (2, n)
    rate: int  # [Hz]
    clipped: float = 0.0  # share of the samples of a channel that are in flat tops, the larger one

    @property
    def seconds(self) -> float:
        """How long it is [s]."""
        return float(self.samples.shape[1] / self.rate)


@dataclass(frozen=True, slots=True)
class Lag:
    """How much later one take begins than the other."""

    samples: float
    correlation: float  # of the two where they overlap, in [-1, 1]


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Both takes at one rate, and where they overlap."""

    mixture: Take  # from its own start to its end
    target: Real  # the target alone at microphone 1 during ``span``, (n,)
    span: slice  # of the mixture's samples
    alone: Take  # the target's take, both microphones, from its own start to its end
    lag: Lag  # of the target's take behind the mixture's; negative: it began later
    notes: tuple[str, ...]  # what was done to the files, in words


def read_take(path: Path, wiring: ChannelMap = UNCORRECTED) -> Take:
    """Read a recording of two microphones, corrected as ``wiring`` says; no constant offset is left.

    Raises
    ------
    AudioError
        When the file is missing or not audio, has not two channels, holds samples that are not finite, is too short,
        or one of its microphones is silent.
    """
    samples, rate = read_audio(path)
    _check(path, samples.T, rate)
    corrected = wiring.correction(rate).of(without_offset(samples.T).astype(float))
    return Take(corrected, rate, max(map(clipped_share, samples.T)))


def _check(path: Path, samples: Real, rate: int) -> None:
    if len(samples) != 2:
        raise AudioError(f"{path}: expected 2 channels, one per microphone, got {len(samples)}")
    if rate < LOWEST_RATE:
        raise AudioError(f"{path}: expected at least {LOWEST_RATE} Hz, got {rate} Hz")
    if samples.shape[1] < SHORTEST * rate:
        raise AudioError(f"{path}: expected at least {SHORTEST:g} s, got {samples.shape[1] / rate:.2f} s")
    if not np.isfinite(samples).all():
        raise AudioError(f"{path}: expected finite samples, got NaN or infinity")
    for index, channel in enumerate(without_offset(samples), start=1):
        if math.sqrt(float(np.mean(channel**2))) < SILENCE:
            raise AudioError(f"{path}: microphone {index} is silent")


def resampled(take: Take, rate: int) -> Take:
    """Return a take at another rate [Hz].

    >>> resampled(Take(np.ones((2, 320)), 32000), 16000).samples.shape
    (2, 160)
    """
    if take.rate == rate:
        return take
    common = math.gcd(take.rate, rate)
    return replace(take, samples=resample_poly(take.samples, rate // common, take.rate // common, axis=1), rate=rate)


def paired(mixture: Take, target: Take, rate: int) -> Pair:
    """Bring the take with interference and the target's own to one rate [Hz] and one time axis.

    Raises
    ------
    AudioError
        When less than a second of them overlaps, the target is not heard in the mixture, or both channels of the
        mixture are the same but for their level and what a conversion adds.
    """
    if _correlation(*mixture.samples) ** 2 >= 1 - SAME:
        raise AudioError("mixture: both channels are the same: expected one per microphone")
    notes = tuple(
        f"{name}: resampled from {take.rate} to {rate} Hz"
        for name, take in (("mixture", mixture), ("target", target))
        if take.rate != rate
    )
    notes += tuple(
        f"{name}: clipped ({100 * take.clipped:.2g} % of the samples), which lowers the scores"
        for name, take in (("mixture", mixture), ("target", target))
        if take.clipped > CLIPPED_SHARE
    )
    mixture, target = resampled(mixture, rate), resampled(target, rate)
    found = lag_of(mixture.samples[0], target.samples[0])
    reference, span = placed(target.samples[0], found, mixture.samples.shape[1])
    if _correlation(mixture.samples[0, span], reference) < 0:
        reference = -reference
        notes += ("target: its polarity is the opposite of that in the mixture, and turned over",)
    if reference.size < SHORTEST * rate:
        common = reference.size / rate
        raise AudioError(f"mixture and target: expected {SHORTEST:g} s or more in common, got {common:.2f} s")
    lag = Lag(found, _correlation(mixture.samples[0, span], reference))
    if lag.correlation < ABSENT:
        raise AudioError(
            f"the target is not in the mixture: expected a correlation of at least {ABSENT:g}, got "
            f"{lag.correlation:.2f}; both need the same recording played at the same place"
        )
    return Pair(mixture, reference, span, target, lag, notes + _cut(mixture, target, reference.size / rate))


def _cut(mixture: Take, target: Take, common: float) -> tuple[str, ...]:
    takes = (("mixture", mixture), ("target", target))
    return tuple(
        f"{name}: scored over the {common:.2f} s of {take.seconds:.2f} s that both recordings have"
        for name, take in takes
        if round(take.seconds, 2) > round(common, 2)  # what is less is not worth a note
    )


def lag_of(mixture: Real, target: Real) -> float:
    """Delay [samples] of a target (m,) inside a mixture (n,): the peak of the cross-correlation, between samples too.

    The peak may be negative: wires that are turned over do not move a sound. The correlation is band-limited, so its
    values between samples are a windowed sinc sum of those around the peak.

    Examples
    --------
    >>> click = np.zeros(100)
    >>> click[40] = 1.0
    >>> lag_of(np.roll(click, 7), click)
    7.0
    """
    n = scipy.fft.next_fast_len(mixture.size + target.size - 1, real=True)
    spectrum = scipy.fft.rfft(mixture - mixture.mean(), n) * scipy.fft.rfft(target - target.mean(), n).conj()
    correlation = scipy.fft.irfft(spectrum, n)
    top = int(np.abs(correlation).argmax())
    around = np.arange(-REACH, REACH + 1)
    offsets = np.arange(-1.0, 1.0 + FINE / 2, FINE)
    apart = offsets[:, None] - around
    weights = np.sinc(apart) * np.cos(np.pi / 2 * np.clip(apart / (REACH + 1), -1, 1)) ** 2
    lag = (top if top < mixture.size else top - n) + float(
        offsets[np.abs(weights @ correlation[(top + around) % n]).argmax()]
    )
    return float(round(lag)) if abs(lag - round(lag)) < WHOLE else round(lag, 2)


def placed(target: Real, lag: float, n: int) -> tuple[Real, slice]:
    """Put a target (m,) at a lag [samples] on the time axis of a mixture of n samples; return what overlaps, and where.

    >>> placed(np.array([1.0, 2.0, 3.0]), 2.0, 4)
    (array([1., 2.]), slice(2, 4, None))
    >>> placed(np.array([1.0, 2.0, 3.0]), -1.0, 4)
    (array([2., 3.]), slice(0, 2, None))
    """
    whole = round(lag)
    moved = target if lag == whole else _delayed(target, lag - whole)
    start, end = max(whole, 0), min(whole + target.size, n)
    return moved[start - whole : max(end, start) - whole], slice(start, max(end, start))


def _delayed(signal: Real, delay: float) -> Real:
    """Delay a signal by a fraction of a sample, by its spectrum."""
    n = scipy.fft.next_fast_len(signal.size + 2 * REACH, real=True)
    turn = np.exp(-2j * np.pi * scipy.fft.rfftfreq(n) * delay)
    return np.asarray(scipy.fft.irfft(scipy.fft.rfft(signal, n) * turn, n)[: signal.size])


def _correlation(one: Real, other: Real) -> float:
    a, b = one - one.mean(), other - other.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0
