"""What fills a gap in samples, and what makes a stretch of them a little shorter or longer: whole periods of the voice.

Substitution of a lost stretch is that of ITU-T G.711, appendix I, in outline: the last period again and again, ever
softer. Shortening and lengthening is one step of waveform-similarity overlap-add (Verhelst and Roelands 1993): nothing
but the short cross-fade differs from what was there.
"""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Samples

KEPT_S = 0.04  # of the past, in which the period is looked for
SHORTEST_PERIOD_S, LONGEST_PERIOD_S = 0.0025, 0.0125  # 400 Hz and 80 Hz
COMPARED_S = 0.01  # of sound, to find the period
FULL_S, SILENT_S = 0.01, 0.06  # of a gap: substituted at full level until, silent from
SHORTEST_SPLICE = 8  # samples
FADE_S = 0.004  # from the substitute to what came again


class Concealer:
    """Fills gaps in a stream of samples.

    Parameters
    ----------
    rate
        Of the samples [Hz].
    """

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._past = np.zeros(round(KEPT_S * rate), np.float32)
        self._period: Samples | None = None  # that is repeated while something is missing
        self._filled = 0  # samples of this gap

    def resume(self, samples: Samples) -> Samples:
        """Take samples (n,) that came; return them, after a gap faded in from the substitute."""
        if self._period is not None and len(samples):
            fade = min(round(FADE_S * self._rate), len(samples))
            rising = (np.arange(fade, dtype=np.float32) + 0.5) / fade
            substitute = self.conceal(fade)
            joined = substitute * (1 - rising) + samples[:fade] * rising
            samples = np.concatenate([joined, samples[fade:]])
            self._period = None
        self._keep(samples)
        return samples

    def conceal(self, n: int) -> Samples:
        """Return ``n`` samples, (n,), in place of what is missing."""
        if self._period is None:
            self._period, self._filled = self._last_period(), 0
        gap = np.arange(self._filled, self._filled + n)
        self._filled += n
        level = 1 - (gap / self._rate - FULL_S) / (SILENT_S - FULL_S)
        filled = self._period[gap % len(self._period)] * np.clip(level, 0, 1).astype(np.float32)
        return np.asarray(filled, np.float32)

    def _keep(self, samples: Samples) -> None:
        self._past = np.concatenate([self._past, samples])[-len(self._past) :]

    def _last_period(self) -> Samples:
        low, high = round(SHORTEST_PERIOD_S * self._rate), round(LONGEST_PERIOD_S * self._rate)
        lag = similar_lag(self._past[::-1], low, high, round(COMPARED_S * self._rate))
        return self._past[-lag:]


def shortened(samples: Samples, most: int) -> Samples:
    """Return samples (n,) without about a period, at most ``most`` samples; unchanged where they are too few."""
    lag, fade = _splice(samples, most)
    if not lag:
        return samples
    rising = (np.arange(fade, dtype=np.float32) + 0.5) / fade
    joined = samples[:fade] * (1 - rising) + samples[lag : lag + fade] * rising
    return np.concatenate([joined, samples[lag + fade :]])


def lengthened(samples: Samples, most: int) -> Samples:
    """Return samples (n,) with about a period twice, at most ``most`` samples more; unchanged if they are too few."""
    lag, fade = _splice(samples, most)
    if not lag:
        return samples
    rising = (np.arange(fade, dtype=np.float32) + 0.5) / fade
    joined = samples[lag : lag + fade] * (1 - rising) + samples[:fade] * rising
    return np.concatenate([samples[:lag], joined, samples[fade:]])


def similar_lag(samples: Samples, low: int, high: int, compared: int) -> int:
    """Return the lag from ``low`` to ``high`` at which samples are most like their beginning.

    >>> tone = np.sin(2 * np.pi * np.arange(400) / 37).astype(np.float32)
    >>> similar_lag(tone, 20, 60, 100)
    37
    """
    beginning = samples[:compared]
    windows = np.lib.stride_tricks.sliding_window_view(samples[low : high + compared], compared)
    energy = np.einsum("ij,ij->i", windows, windows) + 1e-9
    return low + int(np.argmax(windows @ beginning / np.sqrt(energy)))


def _splice(samples: Samples, most: int) -> tuple[int, int]:
    """Return the lag of a splice and the length of its cross-fade [samples]; zeros where there is no room."""
    n = len(samples)
    fade, high = n // 4, min(most, 3 * n // 5)
    low = min(n // 8, high)
    return (similar_lag(samples, low, high, fade), fade) if min(low, fade) >= SHORTEST_SPLICE else (0, 0)
