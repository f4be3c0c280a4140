"""Short-time Fourier transform with a square-root Hann window and perfect reconstruction, edges included."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import sliding_window_view

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Real

SHORT_S = 0.043  # frame that keeps onsets apart [s]
SEPARATION_S = 0.1  # about as long as the frames that the network of `refined` was trained for [s]


@dataclass(frozen=True, slots=True)
class Stft:
    """Analysis and synthesis at one rate, frame and hop.

    Parameters
    ----------
    rate
        Sampling rate [Hz].
    frame
        Length of a frame [samples], even.
    hop
        Distance between frames [samples], less than a frame: every sample then lies where some window is not 0.

    Raises
    ------
    ConfigError
        When the frame is odd or the hop is not in 1 .. frame - 1.

    Examples
    --------
    >>> transform = Stft(rate=16000, frame=4, hop=2)
    >>> transform.frequencies.tolist()
    [0.0, 4000.0, 8000.0]
    >>> transform.analyse(np.ones(4)).shape
    (3, 3)
    """

    rate: int
    frame: int
    hop: int

    def __post_init__(self) -> None:
        """Check the sizes."""
        if self.rate <= 0 or self.frame < 2 or self.frame % 2:
            raise ConfigError(
                f"STFT: expected a positive rate and an even frame, got {self.rate} Hz and {self.frame} samples"
            )
        if not 1 <= self.hop < self.frame:
            raise ConfigError(f"STFT hop: expected 1 to {self.frame - 1} samples, got {self.hop}")

    @property
    def frequencies(self) -> Real:
        """Centre of every bin [Hz], (n_freqs,)."""
        return np.fft.rfftfreq(self.frame, 1 / self.rate)

    @property
    def period(self) -> float:
        """Time between frames [s]."""
        return self.hop / self.rate

    @property
    def window(self) -> Real:
        """Analysis window: square root of the periodic Hann window, (frame,)."""
        return np.sin(np.pi * np.arange(self.frame) / self.frame)

    def frames_of(self, n: int) -> int:
        """Return the number of frames that touch ``n`` samples; the first one ends after ``hop`` of them."""
        return -(-(n + self.frame - self.hop) // self.hop) if n else 0

    def analyse(self, samples: Real) -> Complex:
        """Transform (..., n) into (..., n_freqs, n_frames); single precision stays single.

        Every sample lies in all the frames that the hop allows: the signal is taken as zero outside.
        """
        samples = np.asarray(samples)
        real = samples.dtype if samples.dtype in (np.float32, np.float64) else np.dtype(np.float64)
        n = samples.shape[-1]
        count = self.frames_of(n)
        if not count:
            kind = np.result_type(real, np.complex64)
            return np.zeros((*samples.shape[:-1], self.frame // 2 + 1, 0), kind)
        before, length = self.frame - self.hop, (count - 1) * self.hop + self.frame
        padded = np.zeros((*samples.shape[:-1], length), real)
        padded[..., before : before + n] = samples
        frames = sliding_window_view(padded, self.frame, axis=-1)[..., :: self.hop, :]
        spectra = scipy.fft.rfft(frames * self.window.astype(real), axis=-1)
        return np.ascontiguousarray(np.swapaxes(spectra, -1, -2))

    def synthesise(self, spectrogram: Complex, n: int) -> Real:
        """Transform (..., n_freqs, n_frames) back into (..., n), the inverse of `analyse` (least squares).

        Raises
        ------
        ConfigError
            When the number of frames is not that of ``n`` samples.
        """
        count = spectrogram.shape[-1]
        if count != self.frames_of(n):
            raise ConfigError(f"spectrogram: expected the {self.frames_of(n)} frames of {n} samples, got {count}")
        frames: Real = scipy.fft.irfft(np.swapaxes(spectrogram, -1, -2), self.frame, axis=-1)
        frames *= self._dual().astype(frames.dtype)
        before, length = self.frame - self.hop, (count - 1) * self.hop + self.frame
        samples = np.zeros((*spectrogram.shape[:-2], max(length, before + n)), frames.dtype)
        if self.frame % self.hop:
            for index in range(count):
                samples[..., index * self.hop : index * self.hop + self.frame] += frames[..., index, :]
        else:
            self._overlap(samples, frames)
        return samples[..., before : before + n]

    def _overlap(self, samples: Real, frames: Real) -> None:
        """Add frames (..., n_frames, frame) to samples (..., n), each a hop later, part by part: the oldest first."""
        count = frames.shape[-2]
        for part in reversed(range(self.frame // self.hop)):
            heard = samples[..., part * self.hop : (part + count) * self.hop]
            heard += frames[..., part * self.hop : (part + 1) * self.hop].reshape(heard.shape)

    def _dual(self) -> Real:
        """Synthesis window: w(t) / sum_m w^2(t - m hop) (Griffin and Lim 1984), (frame,)."""
        power = self.window**2
        total = np.zeros(self.hop)
        np.add.at(total, np.arange(self.frame) % self.hop, power)
        return self.window / total[np.arange(self.frame) % self.hop]


def separation_frame(rate: int) -> int:
    """Return the power of two nearest to 0.1 s [samples] at a rate [Hz]: frames of the separation, 71 to 141 ms.

    >>> [separation_frame(rate) for rate in (16000, 24000, 32000, 44100, 48000)]
    [2048, 2048, 4096, 4096, 4096]
    """
    return int(2 ** round(math.log2(SEPARATION_S * rate)))


def short_frames(rate: int) -> Stft:
    """Return frames of the power of two nearest to 43 ms that overlap by three quarters, at a rate [Hz].

    >>> [short_frames(rate).frame for rate in (16000, 44100, 48000)]
    [512, 2048, 2048]
    """
    frame = 2 ** round(math.log2(SHORT_S * rate))
    return Stft(rate, frame, frame // 4)


def band(frequencies: Real, low: float, high: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Mark the bins with low <= f <= high [Hz], (n_freqs,); zero frequency is never marked.

    >>> band(np.array([0.0, 100.0, 200.0, 300.0]), 0.0, 200.0).tolist()
    [False, True, True, False]
    """
    return (frequencies > 0) & (frequencies >= low) & (frequencies <= high)


def aliasing_limit(spacing: float, speed_of_sound: float) -> float:
    """Frequency [Hz] below which a phase difference tells one TDOA from any azimuth: v_p / (2 d).

    >>> aliasing_limit(0.05, 343.0)
    3430.0
    """
    return speed_of_sound / (2 * spacing)
