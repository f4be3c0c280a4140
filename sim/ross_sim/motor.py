"""The noise of a stepper motor that turns."""

from __future__ import annotations

import math

import numpy as np

from ross_payload.interfaces import Samples
from ross_sim.clock import QUANTUM

FULL_STEP = math.radians(1.8)  # of a NEMA 17
LOUD = math.radians(20)  # at this speed the noise has its full strength [rad/s]


class MotorNoise:
    """Tones at the rate of full steps and twice that, and broadband noise; silent at rest.

    The motor sits under the middle of the array: both microphones hear the same. The phase of the tones is that of
    the shaft, so that they follow every acceleration; the strength follows the speed and fades over a quantum. Half
    of the power is tonal.

    Parameters
    ----------
    rms
        Root mean square at full strength, re full scale.
    rate
        [Hz].
    generator
        Of the broadband part.
    """

    def __init__(self, rms: float, rate: int, generator: np.random.Generator) -> None:
        self._rms = rms
        self._rate = rate
        self._generator = generator
        self._strength = 0.0

    def between(self, begin: float, end: float, n: int) -> Samples | float:
        """Return ``n`` samples while the shaft turns from ``begin`` to ``end`` [rad], (n,); 0 at rest."""
        speed = abs(end - begin) / QUANTUM
        before, self._strength = self._strength, min(speed / LOUD, 1.0)
        if before == self._strength == 0.0:
            return 0.0
        phase = 2 * math.pi * np.linspace(begin, end, n, endpoint=False) / FULL_STEP
        tonal = 0.8 * np.sin(phase) + 0.6 * np.sin(2 * phase)  # power 1/2
        broadband = math.sqrt(0.5) * self._generator.standard_normal(n, dtype=np.float32)
        strength = np.linspace(before, self._strength, n, endpoint=False)
        return np.asarray(self._rms * strength * (tonal + broadband), dtype=np.float32)
