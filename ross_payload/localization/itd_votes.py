"""What the bins of a spectrogram vote for: ITD and weight, as `joint` counts them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ross_payload.dsp.density import histogram, histograms
from ross_payload.dsp.itd import Trust, weighted_itd
from ross_payload.interfaces import Complex, Real
from ross_payload.localization.sectors import Histograms
from ross_payload.localization.talker_evidence import BLOCK

AMBIGUOUS = 0.15  # a phase so near to pi [rad] tells no delay: noise alone turns it into that of the opposite one


@dataclass(frozen=True, slots=True, eq=False)
class Votes:
    """ITDs [s] and weights of all bins, (n_freqs, n_frames) each."""

    grid: Real  # of the histograms [s], (n_bins,)
    block: int  # frames of one block of time
    itds: tuple[Real, Real]  # by the rich trust and by the strict one
    weights: tuple[Real, Real]
    clear: tuple[Real, Real]  # the same weights, 0 where the phase does not tell the ITD

    @property
    def n_frames(self) -> int:
        """How many frames have voted."""
        return int(self.itds[0].shape[1])

    @property
    def whole(self) -> Real:
        """Weight per ITD bin of everything, (n_bins,)."""
        return histogram(self.itds[0], self.weights[0], self.grid)

    def between(self, first: int, last: int | None) -> Self:
        """The votes of some frames."""

        def cut(pair: tuple[Real, Real]) -> tuple[Real, Real]:
            return pair[0][:, first:last], pair[1][:, first:last]

        return replace(self, itds=cut(self.itds), weights=cut(self.weights), clear=cut(self.clear))

    def histograms(self) -> Histograms:
        """What is kept of them."""
        blocks = histograms(self.itds[0], self.clear[0], self.grid, self.block)
        return Histograms(blocks, histogram(self.itds[1], self.clear[1], self.grid))


def votes(
    spectrogram: Complex,
    frequencies: Real,
    grid: Real,
    trusts: tuple[Trust, Trust],
    *,
    period: float,
    noise: Real | None,
) -> Votes:
    """Let the bins of a spectrogram (2, n_freqs, n_frames) vote, by a rich trust and a strict one; none, no votes.

    ``period`` is the time between frames [s], ``noise`` the PSD (n_freqs,) where it is known.
    """
    block = max(round(BLOCK / period), 1)
    if not spectrogram.size:
        nothing = np.zeros(spectrogram.shape[1:])
        return Votes(grid, block, (nothing, nothing), (nothing, nothing), (nothing, nothing))
    rich, strict = (weighted_itd(spectrogram, frequencies, period, noise, trust) for trust in trusts)
    clear = (_unambiguous(*rich, frequencies), _unambiguous(*strict, frequencies))
    return Votes(grid, block, (rich[0], strict[0]), (rich[1], strict[1]), clear)


def _unambiguous(itd: Real, weight: Real, frequencies: Real) -> Real:
    """Weigh only bins whose phase tells their ITD: just below the aliasing limit a talker's on the axis does not."""
    phase = 2 * np.pi * frequencies[:, None] * np.abs(itd)
    return np.asarray(weight * (phase < np.pi - AMBIGUOUS))
