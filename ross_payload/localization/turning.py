"""A period in which the array turned, as an explorer that can hear meanwhile is told of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Marks, Observation, Real, Samples, TurningExplorer
from ross_payload.localization.sectors import cut, together
from ross_payload.localization.talker_evidence import BLOCK

BEFORE_S = 0.15  # heard before a period, to know which echoes are still to come [s]

# of a spectrogram, heading and heading aboard [rad], and where tones of rotors are
ObserveInNoise = Callable[[Complex, float, float, Marks | None], Observation]


@dataclass(frozen=True, slots=True)
class Turned:
    """A period, and what was heard right before it."""

    samples: Samples  # (2, n)
    headings: Real  # in the middle of every hop of these samples [rad], (n_hops,)
    before: int = 0  # samples that do not belong to the period
    aboard: Real | None = None  # the headings in the frame of the vehicle [rad], (n_hops,); None: the same
    rotor_speeds: Real | None = None  # at the beginning of every hop [1/s], (n_hops, n_rotors); None: not known

    def frames(self, stft: Stft) -> Complex:
        """Frames that end within the samples, (2, n_freqs, n_frames)."""
        return stft.analyse(self.samples)[..., : self.samples.shape[1] // stft.hop]

    def skip(self, stft: Stft) -> int:
        """How many of the frames do not belong to the period."""
        return round(self.before / stft.hop)

    def at(self, stft: Stft, headings: Real) -> Real:
        """Headings [rad] in the middle of every frame, from those of the hops; not wrapped."""
        n, hops = self.samples.shape[1], len(headings)
        middles = (np.arange(n // stft.hop) + 1) * stft.hop - stft.frame / 2
        return np.interp(middles, (np.arange(hops) + 0.5) * n / hops, np.unwrap(headings))


def observe(explorer: TurningExplorer, stft: Stft, turned: Turned, noise_psd: Real | None) -> Observation:
    """Let an explorer condense a period."""
    spectrogram, headings = turned.frames(stft), turned.at(stft, turned.headings)
    return explorer.observe_turning(
        spectrogram, stft.frequencies, headings, noise_psd, frame_period=stft.period, skip=turned.skip(stft)
    )


def observe_in_noise(stft: Stft, turned: Turned, observe: ObserveInNoise, tonal: Marks | None = None) -> Observation:
    """Condense a period among the noise of the vehicle sector by sector, as if the array rested in each of them.

    ``tonal`` says where in the frames of all samples tones of rotors are, (n_freqs, n_frames); None: nobody knows.
    """
    skip = turned.skip(stft)
    spectrogram, headings = turned.frames(stft)[..., skip:], turned.at(stft, turned.headings)[skip:]
    aboard = headings if turned.aboard is None else turned.at(stft, turned.aboard)[skip:]
    marks = None if tonal is None else tonal[:, skip:]
    return together([
        observe(
            spectrogram[..., part],
            float(headings[part].mean()),
            float(aboard[part].mean()),
            None if marks is None else marks[:, part],
        )
        for part in cut(headings, max(round(BLOCK / stft.period), 1))
    ])  # fmt: skip
