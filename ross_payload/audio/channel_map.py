"""Which channels of a device are the two microphones, and what is corrected of their samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ross_payload.config import Audio
from ross_payload.config.array_presets import PRESETS
from ross_payload.dsp.roll_off import RollOffMatch, Values
from ross_payload.errors import ConfigError
from ross_payload.interfaces import AudioFlag, Samples

FULL_SCALE = 2**23  # of the 24-bit grid
CLIPPED = 1 - 2**-15  # what a 16-bit converter says at full scale


@dataclass(frozen=True, slots=True)
class MappedSamples:
    """The two microphones of one block."""

    samples: Samples  # (2, n), on a 24-bit grid
    raw: Samples | None  # before all corrections; None: the same
    flags: AudioFlag
    carried: float = 0.0  # by the filter of roll-offs, from what came before


@dataclass(frozen=True, slots=True)
class ChannelMap:
    """From the channels of a device to microphones 1 and 2."""

    channels: tuple[int, int]  # of microphones 1 and 2, from 0
    device_channels: int | None = None  # to open; None: as many as needed
    factors: tuple[float, float] = (1.0, 1.0)  # gain and polarity
    roll_offs: tuple[float, float] = (0.0, 0.0)  # of microphones 1 and 2 [Hz]

    @classmethod
    def of(cls, audio: Audio) -> ChannelMap:
        """Take what a configuration says, and where it is silent what its preset does.

        Raises
        ------
        ConfigError
            When a microphone lies outside the channels to open, or both are one channel.
        """
        preset = PRESETS.get(audio.preset)
        channels = audio.microphone_channels
        opened = audio.device_channels or (preset.device_channels if preset else None)
        if channels[0] == channels[1]:
            raise ConfigError(f"audio.channels: expected two different channels, got {list(channels)}")
        if opened is not None and max(channels) >= opened:
            raise ConfigError(
                f"audio.channels: expected 0 to {opened - 1}, as {opened} channels are opened, got {list(channels)}"
            )
        signs = [-1.0 if inverted else 1.0 for inverted in audio.invert]
        first, second = (sign * 10 ** (gain / 20) for sign, gain in zip(signs, audio.gain_db, strict=True))
        return cls(channels, opened, (first, second), audio.roll_off_hz)

    @property
    def needed(self) -> int:
        """Channels that a source must have."""
        return self.device_channels or max(self.channels) + 1

    def correction(self, rate: int) -> Correction:
        """Return what corrects one stream of samples at a rate [Hz], from its beginning."""
        return Correction(self, rate)


class Correction:
    """Gain, polarity and roll-off of both microphones, corrected block after block of one stream.

    Parameters
    ----------
    wiring
        What there is to correct.
    rate
        Of the samples [Hz].
    """

    def __init__(self, wiring: ChannelMap, rate: int) -> None:
        self._factors = np.array(wiring.factors)[:, None]
        self._match = RollOffMatch(wiring.roll_offs, rate)
        self._none = wiring.factors == (1.0, 1.0) and self._match.none

    def of(self, samples: Values) -> Values:
        """Return the next samples (2, n) of the stream, corrected."""
        return samples if self._none else self._match(samples * self._factors.astype(samples.dtype))

    def resume(self, carried: float) -> None:
        """Go on as where `MappedSamples` told what was ``carried``."""
        self._match.carried = carried

    def apply(self, raw: Samples) -> MappedSamples:
        """Bring the next samples (2, n) of the stream to full scale 1 on the 24-bit grid, corrected."""
        flags, carried = AudioFlag.NONE, self._match.carried
        if not np.isfinite(raw).all():
            raw, flags = np.where(np.isfinite(raw), raw, np.float32(0)), AudioFlag.INVALID
        raw = _on_grid(raw)  # first, so that a 24-bit recording of it gives the same samples again
        samples = raw if self._none else _on_grid(self.of(raw))
        if max(_peak(raw), _peak(samples)) >= CLIPPED:
            flags |= AudioFlag.CLIPPED
        return MappedSamples(samples, None if self._none else raw, flags, carried)


def _on_grid(samples: Samples) -> Samples:
    """Round to 24 bits; what lies beyond full scale is clipped."""
    counts = np.clip(np.rint(samples * np.float32(FULL_SCALE)), -FULL_SCALE, FULL_SCALE - 1)
    grid: Samples = counts / np.float32(FULL_SCALE)
    return grid


def _peak(samples: Samples) -> float:
    return float(np.abs(samples).max(initial=0.0))
