"""An array that was turned in the open while something sounded: plane waves, with phases by theory."""

import numpy as np
from scipy.signal import butter, lfilter

from ross_payload.calibration.cross_spectrum import heading_spectrum
from ross_payload.dsp.steering import tdoa

RATE, SPEED = 16000, 343.0
SECONDS = 1.0


def waves(signal, azimuths, heading, spacing, delay=0.0):
    """What both microphones hear of one signal from each of some azimuths, (2, n)."""
    signals = np.atleast_2d(signal)
    frequencies = np.fft.rfftfreq(signals.shape[1], 1 / RATE)
    tau = tdoa(np.asarray(azimuths), heading, spacing, SPEED)[:, None]
    half = np.exp(1j * np.pi * frequencies * tau)  # the phase counts from the middle of the array
    late = np.exp(2j * np.pi * frequencies * delay)
    spectra = np.fft.rfft(signals)
    return np.stack([np.fft.irfft(spectra / half).sum(axis=0), np.fft.irfft(spectra * half * late).sum(axis=0)])


def heard_at(
    headings, *, azimuths=(0.7,), spacing=0.05, gain_db=0.0, inverted=False, delay=0.0, roll_off=0.0, noise=0.1,
    silent=(), colour=None, level=0.05, seed=0,
):  # fmt: skip
    """Samples (2, n) at every heading [rad]; ``noise`` of each microphone's own, and nothing else where ``silent``.

    Microphone 2 is 3 dB down at ``roll_off`` [Hz].
    """
    rng = np.random.default_rng(seed)
    n = round(SECONDS * RATE)
    for index, heading in enumerate(headings):
        signal = rng.standard_normal((len(azimuths), n)) / np.sqrt(len(azimuths))
        signal = signal if colour is None else colour(signal)
        both = waves(signal, azimuths, heading, spacing, delay) * (index not in silent)
        both += noise * rng.standard_normal((2, n))
        if roll_off:
            both[1] = lfilter(*butter(1, roll_off, "highpass", fs=RATE), both[1])
        both[1] *= 10 ** (gain_db / 20) * (-1 if inverted else 1)
        yield (level * both).astype(np.float32)


def spectra(headings, **like):
    """The same as spectra."""
    pairs = zip(headings, heard_at(headings, **like), strict=True)
    return [heading_spectrum(samples, RATE, float(heading)) for heading, samples in pairs]


def around(count=8, degrees=360.0):
    """Headings [rad] at equal steps: all around, or from end to end of a smaller turn."""
    steps = count if degrees == 360.0 else count - 1
    return np.deg2rad(degrees) * np.arange(count) / steps
