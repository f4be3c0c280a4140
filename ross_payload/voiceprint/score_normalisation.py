"""Adaptive test normalisation of scores (AT-norm): a voice, measured against those of other talkers.

What a room, a separator and the remains of the others do to a voice makes it more like everybody, or like nobody. How
alike it is to a print tells more when it is compared with how alike it is to the talkers of a cohort who are nearest to
it (D. Sturim and D. Reynolds, "Speaker adaptive cohort selection for Tnorm in text-independent speaker verification",
Proc. ICASSP 2005).
"""

from __future__ import annotations

import numpy as np

from ross_payload.interfaces import Real

NEAREST = 50  # talkers of the cohort that count
LEAST = 1e-3  # standard deviation of their cosines


class Cohort:
    """Other talkers, by whom scores are normalised.

    Parameters
    ----------
    embeddings
        Of one talker each, of length 1, (n, size).
    """

    def __init__(self, embeddings: Real) -> None:
        self._embeddings = embeddings

    def normalised(self, enrolled: Real, test: Real) -> float:
        """Return the cosine of a print with what was heard, of length 1, (size,) each, by those of the nearest talkers.

        In their standard deviations above their mean.

        >>> cohort = Cohort(np.array([[1.0, 0.0], [0.8, 0.6], [0.8, -0.6]]))
        >>> voice, other = np.array([1.0, 0.0]), np.array([0.0, 1.0])
        >>> cohort.normalised(voice, voice) > 0 > cohort.normalised(other, voice)
        True
        """
        nearest = np.sort(self._embeddings @ test)[-NEAREST:]
        return float((enrolled @ test - nearest.mean()) / max(nearest.std(), LEAST))
