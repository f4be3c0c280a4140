"""Short-time Fourier transform of a stream: samples in, frames out, and back, with less delay than a frame if wanted.

With a synthesis window as long as the frame both ends are those of `Stft`, frame by frame. A shorter one lies at the
end of the frame, and the analysis window rises slowly and falls quickly (Mauler and Martin 2007): the resolution stays
that of the frame, the delay becomes that of the synthesis window.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.lib.stride_tricks import sliding_window_view

from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Real

HOP = 0.016  # [s], about
LONG, SHORT = 8, 6  # frames, in hops
LEAST, MOST = 4, 1  # hops that frames overlap by before one is spent on looking ahead, and the most that are


@dataclass(frozen=True, slots=True)
class StreamingStft:
    """What analysis and synthesis of a stream agree on.

    Parameters
    ----------
    stft
        Rate, frame and hop.
    delay
        Length of the synthesis window [samples], even, from two hops to a frame; None: a frame.

    Raises
    ------
    ConfigError
        When the synthesis window does not fit.

    Examples
    --------
    >>> stream = StreamingStft(Stft(rate=16000, frame=8, hop=2), delay=4)
    >>> (stream.analysis_window * stream.synthesis_window).round(6).tolist()
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.5]
    """

    stft: Stft
    delay: int | None = None

    def __post_init__(self) -> None:
        """Check the sizes."""
        low, high = 2 * self.stft.hop, self.stft.frame
        if self.delay is not None and (self.delay % 2 or not low <= self.delay <= high):
            raise ConfigError(f"synthesis window: expected an even length of {low} to {high} samples, got {self.delay}")

    @property
    def latency(self) -> int:
        """Samples from one that is heard to the end of the frame that completes it."""
        return self.stft.frame if self.delay is None else self.delay

    @property
    def analysis_window(self) -> Real:
        """Half a period of a sine up, half a one down; the square root of the Hann window at full delay, (frame,)."""
        fall = self.latency // 2
        rise = self.stft.frame - fall
        up, down = np.arange(rise) / rise, np.arange(fall) / fall
        return np.concatenate([np.sin(0.5 * np.pi * up), np.cos(0.5 * np.pi * down)])

    @property
    def synthesis_window(self) -> Real:
        """What makes the sum over all frames that touch a sample 1, (frame,)."""
        frame, hop, first = self.stft.frame, self.stft.hop, self.stft.frame - self.latency
        product = np.zeros(frame)
        product[first:] = np.sin(np.pi * np.arange(self.latency) / self.latency) ** 2
        total = np.zeros(hop)
        np.add.at(total, np.arange(frame) % hop, product)
        window = np.zeros(frame)
        np.divide(product, self.analysis_window, out=window, where=product > 0)
        return np.asarray(window / total[np.arange(frame) % hop])

    def first_sample(self, index: int) -> int:
        """Index of the first of the ``hop`` samples that frame number ``index`` completes; below 0 before the stream.

        >>> StreamingStft(Stft(16000, 1024, 256)).first_sample(0)
        -768
        """
        return (index + 1) * self.stft.hop - self.latency


def transform_for(rate: int, latency: float) -> tuple[StreamingStft, int]:
    """Return the transform for listening with an algorithmic latency, and the frames to look ahead.

    Frames of 128 ms, in which the reverberation of a room fits, or of 96 ms when the latency is short, 16 ms apart. The
    latency is that of the synthesis window and of the frames after it, never more than asked for.

    Parameters
    ----------
    rate
        [Hz].
    latency
        [s].

    Raises
    ------
    ConfigError
        When it is too short for two frames to overlap.

    Examples
    --------
    >>> transform, lookahead = transform_for(16000, 0.1)
    >>> transform.stft.frame, transform.stft.hop, transform.latency, lookahead
    (2048, 256, 1344, 1)
    """
    hop, samples = int(scipy.fft.next_fast_len(round(HOP * rate), real=True)), int(latency * rate)
    if samples < 2 * hop:
        raise ConfigError(f"latency: expected at least {2 * hop / rate * 1000:.0f} ms, got {latency * 1000:g} ms")
    lookahead = min(max((samples - LEAST * hop) // hop, 0), MOST)
    frame = (LONG if samples >= LEAST * hop else SHORT) * hop
    delay = min(samples - lookahead * hop, frame) // 2 * 2
    return StreamingStft(Stft(rate, frame, hop), delay), lookahead


class StreamingAnalysis:
    """Samples in, frames out.

    Parameters
    ----------
    transform
        Windows and sizes.
    n_channels
        Of the samples.
    """

    def __init__(self, transform: StreamingStft, n_channels: int) -> None:
        self._stft = transform.stft
        self._window = transform.analysis_window.astype(np.float32)
        self._kept = np.zeros((n_channels, self._stft.frame - self._stft.hop), np.float32)

    def push(self, samples: Real) -> Complex:
        """Take the next samples (n_channels, n), any number; return the frames they complete.

        The first frame is complete after ``hop`` samples; what was before the stream counts as zeros.

        Returns
        -------
        ndarray
            (n_channels, n_freqs, n_frames), single precision.
        """
        frame, hop = self._stft.frame, self._stft.hop
        kept = np.concatenate([self._kept, samples], axis=-1, dtype=np.float32)
        count = max((kept.shape[-1] - frame) // hop + 1, 0)
        self._kept = kept[:, count * hop :]
        if not count:
            return np.zeros((len(kept), frame // 2 + 1, 0), np.complex64)
        frames = sliding_window_view(kept, frame, axis=-1)[:, ::hop][:, :count]
        return np.ascontiguousarray(np.swapaxes(scipy.fft.rfft(frames * self._window, axis=-1), -1, -2))


class StreamingSynthesis:
    """Frames in, samples out.

    Parameters
    ----------
    transform
        Windows and sizes.
    n_channels
        Of the frames.
    """

    def __init__(self, transform: StreamingStft, n_channels: int) -> None:
        self._stft, self._latency = transform.stft, transform.latency
        self._window = transform.synthesis_window[-self._latency :].astype(np.float32)
        self._sum = np.zeros((n_channels, self._latency), np.float32)

    def push(self, frames: Complex) -> Real:
        """Take the next frames (n_channels, n_freqs, n_frames); return the samples they complete.

        Every frame completes ``hop`` samples; `StreamingStft.first_sample` says which.

        Returns
        -------
        ndarray
            (n_channels, n_frames hop), single precision.
        """
        hop, count = self._stft.hop, frames.shape[-1]
        waves = scipy.fft.irfft(np.swapaxes(frames, -1, -2), self._stft.frame, axis=-1)[..., -self._latency :]
        done = np.zeros((len(self._sum), count * hop), np.float32)
        for index in range(count):
            self._sum += waves[:, index] * self._window
            done[:, index * hop : (index + 1) * hop] = self._sum[:, :hop]
            self._sum[:, :-hop] = self._sum[:, hop:]
            self._sum[:, -hop:] = 0
        return done
