"""Two microphones that roll off at different low frequencies, made alike.

The vent of a microphone and the capacitor behind it are high-passes of first order: sound of frequency f leads by
``arctan(f_c / f)``. Two corners that are 30 Hz apart make 3.4 degrees at 500 Hz, which move every azimuth.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from ross_payload.interfaces import Real, Samples

Values = TypeVar("Values", Samples, Real)


class RollOffMatch:
    """Raises the lower of two roll-offs to the higher, block after block: nothing is amplified.

    The microphone is filtered with ``(s + 2 pi f_low) / (s + 2 pi f_high)`` (bilinear transform).

    >>> flat = RollOffMatch((20.0, 20.0), 16000)
    >>> flat(np.ones((2, 3)))[0].tolist()
    [1.0, 1.0, 1.0]

    Parameters
    ----------
    corners
        Frequencies at which microphones 1 and 2 are 3 dB down [Hz].
    rate
        Of the samples [Hz].
    """

    def __init__(self, corners: tuple[float, float], rate: int) -> None:
        low, high = (np.pi * corner / rate for corner in sorted(corners))
        self._channel = int(corners[1] < corners[0]) if low < high else None
        self._forward = np.array([1 + low, low - 1]) / (1 + high)
        self._back = np.array([1.0, (high - 1) / (1 + high)])
        self.carried = 0.0  # of the filter, from what came before

    @property
    def none(self) -> bool:
        """Whether they are alike already."""
        return self._channel is None

    def __call__(self, samples: Values) -> Values:
        """Return the next samples (2, n) as microphones alike would have given them."""
        if self._channel is None:
            return samples
        from scipy.signal import lfilter  # noqa: PLC0415  takes as long as all the rest of the payload

        filtered = samples.copy()
        filtered[self._channel], (self.carried,) = lfilter(
            self._forward, self._back, samples[self._channel].astype(float), zi=[self.carried]
        )
        return filtered
