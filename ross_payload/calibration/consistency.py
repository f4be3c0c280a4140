"""Whether what an exploration heard contradicts what is configured of the array: spacing, gain, polarity, no delay.

Several people talk, nobody knows where, and the turn serves another end. So less is told than by a calibration: only
what cannot be explained by rooms, elevations and pauses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.calibration.common_delay import common_delay
from ross_payload.calibration.cross_spectrum import HeadingSpectrum
from ross_payload.calibration.turn_fit import AZIMUTHS, Steered, Turn
from ross_payload.interfaces import Real

FEWEST = 5  # headings
POOLED = 8  # bins for which one frequency stands: 32 Hz, over which a delay of 1 ms turns the phase by 12 deg
LONG = 0.125  # wavelengths that the spacing may be, where polarity shows: 45 deg of phase along the axis
LEAST_BINS = 8
OPPOSITE = -0.5  # mean cosine of the phase below which polarity is reversed
GAIN_DB = 1.5  # that is worth a word: it costs 2.5 dB of separation
SURE = 4.0  # standard deviations
RATIOS = np.arange(0.4, 2.51, 0.05)  # spacing that is tried, over the configured one
WIDE, NARROW = 1.15, 0.75  # ratios beyond which the configured spacing is wrong
LEFT = 1.3  # times as much must the configured spacing leave unexplained
LEFT_ALIKE = 1.2  # times as much must no delay at all leave, or it is noise from all sides and no smaller spacing
LEFT_TOGETHER = 1.2  # times as much must several sources leave without a delay between the channels
EXPLAINED = 0.05  # of what was heard must that delay explain besides


@dataclass(frozen=True, slots=True)
class Contradiction:
    """What the configuration seems to have wrong; what is None or False agrees."""

    spacing: float | None = None  # that explains more [m]
    gain_db: float | None = None  # of microphone 2 over microphone 1
    inverted: bool = False
    delay: float | None = None  # of microphone 2 before microphone 1, whatever the heading [s]
    fixed: bool = False  # what was heard has the same delay at all headings: it turns with the array

    @property
    def geometry(self) -> bool:
        """Whether the delays are not those of sources around such an array: then nothing finer can be told of them."""
        return self.inverted or self.fixed or self.spacing is not None or self.delay is not None

    def __bool__(self) -> bool:
        """Whether anything is wrong."""
        return self != Contradiction()


def contradiction(
    spectra: Sequence[HeadingSpectrum], spacing: float, speed_of_sound: float, *, level: bool = True
) -> Contradiction:
    """Compare what was heard at the headings of an exploration with the configured spacing [m].

    Sources far above or below the array shorten all delays, or have none. Unless they are about ``level`` with it, a
    spacing that seems too small is not taken for wrong, nor are delays that do not change or that all have in common.
    """
    if len(spectra) < FEWEST:
        return Contradiction()
    turn = Turn.of(spectra)
    if _inverted(turn, spacing, speed_of_sound):  # nothing else can be told
        return Contradiction(inverted=True)
    gain, turn = _gain(turn), turn.pooled(POOLED)
    steered = Steered(turn, turn.phase)
    explained, alike = explained_by(turn, steered, RATIOS * spacing / speed_of_sound), _left_alike(turn, steered)
    if level and 1 - float(explained.max()) > LEFT * alike:  # interference, or one channel twice
        return Contradiction(gain_db=gain, fixed=True)
    ratio = _ratio(explained, alike)
    found = None if ratio is None else ratio * spacing
    delay = _delay(turn, steered, spacing / speed_of_sound) if level and found is None else None
    return Contradiction(found if found is None or level or found > spacing else None, gain, delay=delay)


def _inverted(turn: Turn, spacing: float, speed_of_sound: float) -> bool:
    """Sound that is long against the spacing has nearly the same phase at both, wherever it comes from."""
    long = turn.frequencies <= LONG * speed_of_sound / spacing
    weight = turn.weight[:, long]
    if np.count_nonzero(long) < LEAST_BINS or not weight.sum() > 0:
        return False
    return bool((weight * turn.phase[:, long].real).sum() < OPPOSITE * weight.sum())


def _gain(turn: Turn) -> float | None:
    weights = turn.weight.sum(axis=1)
    if not weights.min() > 0:
        return None
    levels = (turn.weight * turn.level_db).sum(axis=1) / weights
    mean, error = float(levels.mean()), float(levels.std(ddof=1)) / np.sqrt(len(levels))
    return mean if abs(mean) > GAIN_DB and abs(mean) > SURE * error else None


def _left_alike(turn: Turn, steered: Steered) -> float:
    """Share of the weight that no delay at all leaves unexplained."""
    return 1 - float(steered.share(np.zeros((len(turn.headings), 1)))[0])


def _delay(turn: Turn, steered: Steered, amplitude: float) -> float | None:
    """The delay between the channels with which sources at rest explain clearly more than without."""
    delay, left, without = common_delay(turn, steered, amplitude)
    return delay if without > LEFT_TOGETHER * left and without - left > EXPLAINED else None


def _ratio(explained: Real, alike: float) -> float | None:
    """The spacing with which one source at rest explains most, over the configured one, where it leaves clearly less.

    The others who talk are left in any case, and do not decide: all of them would want the same spacing.
    """
    right = (RATIOS > NARROW) & (RATIOS < WIDE)
    best, near = int(explained.argmax()), float(explained[right].max())
    left = 1 - explained[best]
    if right[best] or 1 - near < LEFT * left or (RATIOS[best] < 1 and alike < LEFT_ALIKE * left):
        return None
    return float(RATIOS[best])


def explained_by(turn: Turn, steered: Steered, amplitudes: Real) -> Real:
    """Largest share of the weight that one source at rest explains with each amplitude d / v_p [s], (n_amplitudes,)."""
    cosines = np.cos(AZIMUTHS - turn.headings[:, None])
    return np.array([steered.share(amplitude * cosines).max() for amplitude in amplitudes])
