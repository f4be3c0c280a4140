"""Whether two channels are two raw microphones side by side: what a short recording says, wherever it was made.

Two microphones a few centimetres apart hear nearly the same, a fraction of a millisecond apart, and each has a noise of
its own. A channel that a device has processed (an ASR output, a beam, one with its echo cancelled) comes later, is
gated, cut off above some frequency, or has lost the phase; a copy has no noise of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ross_payload.calibration.cross_spectrum import heading_spectrum
from ross_payload.interfaces import Real, Samples

BLOCK = 0.01  # [s]
GATED = 0.1  # share of the blocks in which one channel alone is digital silence
SOFTEST = 1e-4  # root mean square of a sound that tells something: -80 dB re full scale
LATEST = 0.2  # delay that is looked for [s]
ROOM = 2  # samples by which a delay may exceed what the spacing allows
PEAK = 0.1  # of the generalised cross-correlation: there is one delay
COPY = 0.9999  # share of the power in common at nearly all frequencies: no noise of their own
COPIED = 0.9  # of the frequencies
EDGE_DB = 30.0  # that one channel falls off against the other above some frequency
FEW = 0.1  # share of the bins there that may differ
EDGES = np.arange(3000.0, 8000.0, 500.0)  # [Hz]
LONG = 0.25  # wavelengths that the spacing may be, where both must have much in common
LITTLE = 0.2  # mean share of the power in common there
LEAST_BINS = 8


@dataclass(frozen=True, slots=True)
class ChannelTrouble:
    """One thing that two raw microphones would not do."""

    channel: int | None  # 0 or 1, the one that is processed; None: either
    found: str


def channel_troubles(samples: Samples, rate: int, spacing: float, speed_of_sound: float) -> Iterator[ChannelTrouble]:
    """Yield what tells two channels (2, n) from two raw microphones ``spacing`` [m] apart; nothing when too soft."""
    blocks = _blocks(samples, rate)
    silent = np.ptp(blocks, axis=-1) == 0
    if silent.all(axis=1).any() or not blocks.size:  # a dead channel is told elsewhere
        return
    for channel in (0, 1):
        share = float(np.mean(silent[channel] & ~silent[1 - channel]))
        if share > GATED:
            yield ChannelTrouble(channel, f"is digital silence for {100 * share:.0f} % of the time: gated")
    if np.sqrt(np.mean(samples.astype(float) ** 2, axis=1)).min() < SOFTEST:
        return
    yield from _compared(samples, rate, spacing, speed_of_sound)


def _compared(samples: Samples, rate: int, spacing: float, speed_of_sound: float) -> Iterator[ChannelTrouble]:
    delay, peak = correlation_delay(samples, rate)
    most = spacing / speed_of_sound + ROOM / rate
    late = abs(delay) > most and peak > PEAK
    if late:
        channel = 0 if delay > 0 else 1
        told = f"comes {1e3 * abs(delay):.2f} ms late, more than the {1e3 * spacing:.0f} mm between microphones explain"
        yield ChannelTrouble(channel, told)
        samples = _aligned(samples, round(delay * rate))
    heard = heading_spectrum(samples, rate, 0.0)
    if heard is None:
        return
    edge = _edge(heard.level_db, heard.frequencies)
    if edge is not None:
        channel, frequency = edge
        yield ChannelTrouble(channel, f"has nothing above {frequency:.0f} Hz: cut off by a codec or a speech filter")
    if np.mean(heard.weight > COPY) > COPIED:
        yield ChannelTrouble(None, "have no noise of their own: one is a copy of the other")
    low = heard.frequencies <= LONG * speed_of_sound / spacing
    if np.count_nonzero(low) >= LEAST_BINS and _loud(samples, rate) and float(heard.weight[low].mean()) < LITTLE:
        yield ChannelTrouble(None, "have nothing in common: one is processed, or they hear different things")


def correlation_delay(samples: Samples, rate: int) -> tuple[float, float]:
    """Delay [s] by which channel 2 leads channel 1, and the height of its peak, 0 to 1 (GCC-PHAT; Knapp, Carter 1976).

    >>> noise = np.random.default_rng(0).standard_normal(4000)
    >>> delay, peak = correlation_delay(np.stack([noise[:-80], noise[80:]]).astype(np.float32), 16000)
    >>> round(1e3 * delay, 6), peak > 0.5
    (5.0, True)
    """
    size = 2 * samples.shape[1]
    first, second = np.fft.rfft(samples.astype(float), size)
    cross = second.conj() * first
    curve = np.fft.irfft(cross / (np.abs(cross) + 1e-20), size)
    most = min(round(LATEST * rate), samples.shape[1] - 1)
    near = np.concatenate([curve[-most:], curve[: most + 1]])
    place = int(near.argmax())
    return (place - most) / rate, float(near[place])


def _blocks(samples: Samples, rate: int) -> Real:
    size = round(BLOCK * rate)
    count = samples.shape[1] // size
    return samples[:, : count * size].reshape(2, count, size)


def _aligned(samples: Samples, lead: int) -> Samples:
    """Shift the channels so that both hear the same at one time."""
    first, second = samples
    n = samples.shape[1] - abs(lead)
    return np.stack([first[max(lead, 0) :][:n], second[max(-lead, 0) :][:n]])


def _edge(level_db: Real, frequencies: Real) -> tuple[int, float] | None:
    """The channel that has nothing above some frequency which the other has, and that frequency [Hz]."""
    reference = float(np.median(level_db[frequencies < EDGES[0]]))
    for frequency in EDGES:
        above = level_db[frequencies >= frequency] - reference
        lower, upper = np.quantile(above, (FEW, 1 - FEW)) if above.size >= LEAST_BINS else (0.0, 0.0)
        if lower > EDGE_DB or upper < -EDGE_DB:
            return (0 if lower > 0 else 1), float(frequency)
    return None


def _loud(samples: Samples, rate: int) -> bool:
    """Whether a sound stands out of the noise at both: their loud blocks are 10 dB above their soft ones."""
    power = np.mean(_blocks(samples, rate).astype(float) ** 2, axis=-1) + 1e-20
    loud, soft = np.quantile(power, (0.95, 0.2), axis=1)
    return bool((loud / soft).min() > 10.0)
