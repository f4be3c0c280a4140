"""The trustworthy bins of some frames: phase between the microphones, frequency, and how far each counts."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.dsp.itd import Trust, weighted_itd
from ross_payload.interfaces import Complex, Real

BUNDLE = np.radians(1.0)  # frames at headings within this are one [rad]


@dataclass(frozen=True, slots=True)
class Hearing:
    """How phases tell of azimuths."""

    trust: Trust = field(default_factory=lambda: Trust(neighbourhood=(1, 3), coherence=0.95))
    low: float = 300.0  # frequencies used [Hz]
    high: float = 8000.0  # [Hz]
    noise: float = 0.03  # standard deviation of a phase at any frequency [rad]
    error: tuple[float, float] = (0.12, 0.13)  # and per root of 2 pi f d / v_p, in the open and in reverberation [rad]
    echoic: float = 0.6  # more of that for every unit by which reflections draw delays to 0 more than in a plane [rad]
    wider: float = 2.1  # times that where another source has a part of the bin
    share: float = 1.5  # counts by which shares are drawn to those of before
    recent: float = 2.0  # in which shares are forgotten [s]
    homes: float = 4.0  # in which what was heard of a source at rest is forgotten [s]
    talks: float = 3.0  # log-likelihood by which a source must explain the frames of one step to be heard [nat]
    count: float = 0.3  # effective counts per unit of weight: neighbouring bins are not independent
    most: int = 300  # bins of one step that are told; they count for the others
    used: int = 160  # and of these that are looked at


HEARING = Hearing()


@dataclass(frozen=True, slots=True)
class FrameStatistics:
    """The trustworthy bins of some frames."""

    seconds: float  # that the frames stand for
    headings: Real  # of the array, bundled [rad], (n_headings,)
    bundle: NDArray[np.intp]  # index of each bin's heading, (n,)
    frequencies: Real  # [Hz], (n,)
    phases: Real  # of microphone 2 against microphone 1 [rad], (n,)
    weights: Real  # effective counts, (n,)

    def evenly(self, most: int, group: int) -> FrameStatistics:
        """Bins that count alike, drawn evenly by what they count: at most ``most``, in whole groups."""
        n, total = min(-(-len(self.weights) // group) * group, most), float(self.weights.sum())
        drawn = np.searchsorted(np.cumsum(self.weights), (np.arange(n) + 0.5) / n * total)
        drawn = np.minimum(drawn, len(self.weights) - 1)
        return replace(
            self,
            bundle=self.bundle[drawn],
            frequencies=self.frequencies[drawn],
            phases=self.phases[drawn],
            weights=np.full(n, total / n),
        )


def statistics(
    spectrogram: Complex,
    frequencies: Real,
    headings: Real,
    noise_psd: Real | None,
    *,
    period: float,
    skip: int = 0,
    still: NDArray[np.bool_] | None = None,
    hearing: Hearing = HEARING,
) -> FrameStatistics:
    """Pick the trustworthy bins of some frames.

    Parameters
    ----------
    spectrogram : (2, n_freqs, n_frames)
        Frames of about 43 ms that overlap by three quarters serve best.
    frequencies : (n_freqs,)
        [Hz].
    headings : (n_frames,)
        Of the array in the middle of every frame [rad].
    noise_psd : (n_freqs,) or None
        E|noise|^2 per bin; None takes a low quantile over these frames.
    period
        Time between frames [s].
    skip
        Frames at the beginning that were told before: they only tell which echoes are still to come.
    still : (n_frames,)
        Frames that count, the others were heard beside a motor; None: all.
    """
    band = (frequencies >= hearing.low) & (frequencies <= hearing.high)
    seconds = max((spectrogram.shape[-1] - skip) * period, 0.0)
    if not seconds or not band.any():
        return silence(seconds)
    noise = None if noise_psd is None else noise_psd[band]
    used = frequencies[band]
    itd, weight = weighted_itd(spectrogram[:, band], used, period, noise, hearing.trust)
    weight = weight[:, skip:] * (used.max() / used)[:, None]  # as precise as its frequency is high: the kernels say so
    weight = weight if still is None else weight * still[skip:]
    chosen = np.flatnonzero(weight > 0)
    every = max(len(chosen) / hearing.most, 1.0)
    chosen = chosen[np.arange(min(len(chosen), hearing.most)) * len(chosen) // max(min(len(chosen), hearing.most), 1)]
    row, frame = np.unravel_index(chosen, weight.shape)
    bundled = np.round(headings[skip:] / BUNDLE).astype(int)
    unique, index = np.unique(bundled, return_inverse=True)
    means = np.array([headings[skip:][bundled == each].mean() for each in unique])
    phases = 2 * np.pi * used[row] * itd[row, frame + skip]
    return FrameStatistics(seconds, means, index[frame], used[row], phases, hearing.count * every * weight[row, frame])


def silence(seconds: float) -> FrameStatistics:
    """Nothing was heard for ``seconds``, or not listened to."""
    none = np.zeros(0)
    return FrameStatistics(seconds, none, np.zeros(0, dtype=np.intp), none, none, none)
