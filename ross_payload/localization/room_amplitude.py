"""By which factor a room draws all delays to 0, learnt from the first seconds of talkers whose azimuths are known.

Reflections make every delay nearer to 0 than geometry says, by a factor that the room has as a whole (decision 115). An
exploration tells it. Where azimuths were told instead, it is what fits best: the phases of all trustworthy bins are a
mixture of sources that rest where they were told and of nobody, as when sources are tracked, once for each factor of a
grid.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ross_payload.interfaces import Real
from ross_payload.localization.phase_likelihood import Scene, at_rest
from ross_payload.localization.phase_statistics import FrameStatistics, Hearing

UNTOLD = 0.985  # amplitude of delays in a room that nobody has explored
AMPLITUDES = UNTOLD - 0.03 * np.arange(10)  # grid
MIDDLE = 0.9  # amplitude for which it is computed how talkers share bins
PLAIN = 0.95  # a factor above this is that of the open or of a plane, for which tracks were chosen: `UNTOLD`
SURE = 0.01  # standard deviation from which on the amplitude is known
HEARD = (1.5, 4.0)  # at least, and until it is taken as it is [s]


@dataclass(frozen=True, slots=True, eq=False)
class RoomAmplitude:
    """What was heard of the factor so far."""

    log: Real = field(default_factory=lambda: np.zeros(AMPLITUDES.size))  # likelihood of every amplitude of the grid
    seconds: float = 0.0  # heard

    @property
    def amplitude(self) -> float:
        """What tracks take for the amplitude of delays."""
        return self._mean if self._mean < PLAIN else UNTOLD

    @property
    def known(self) -> bool:
        """Whether it is sure enough, or was listened to for long enough."""
        sigma = np.sqrt(self._posterior @ (AMPLITUDES - self._mean) ** 2)
        least, most = HEARD
        return self.seconds >= most or (self.seconds >= least and bool(sigma <= SURE))

    def after(self, statistics: FrameStatistics, scene: Scene, shares: Real, hearing: Hearing) -> RoomAmplitude:
        """Return what is known after some frames.

        Parameters
        ----------
        statistics
            The trustworthy bins of the frames, one at least.
        scene
            Where the sources rest.
        shares
            Of the bins of every band, the last is nobody's, (k + 1, n_bands).
        hearing
            How phases tell of azimuths.
        """
        found, marginal = at_rest(statistics, replace(scene, amplitude=MIDDLE), AMPLITUDES, hearing)
        parts = found.shares(shares, marginal, hearing.share)
        mixture = (parts[..., found.band] * marginal).sum(axis=1)
        log = self.log + found.log(mixture[..., None])[:, 0]
        return RoomAmplitude(log - log.max(), self.seconds + statistics.seconds)

    @property
    def _mean(self) -> float:
        return float(self._posterior @ AMPLITUDES)

    @property
    def _posterior(self) -> Real:
        odds = np.exp(self.log)
        return np.asarray(odds / odds.sum())
