"""A recording in which the noise has one level everywhere: every bin over the level of the noise there.

Noise of a vehicle rises and falls with the throttle, wind with its gusts. The local Gaussian model, and the network
that corrects it, then see noise of a steady PSD, and a covariance for every bin.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ross_payload.dsp.stft import band
from ross_payload.interfaces import Complex, Marks, Real, Scene
from ross_payload.separation.directness import VOICE

LARGER = (4.5, 2.0)  # noise term over the noise, which is not all Gaussian: where hardly anybody is heard, and where ..
HEARD = (-8.0, 5.0)  # .. talkers are clearly heard: their mean power over that of the noise [dB]
LOWEST_VOICE = 80.0  # nobody talks below; propellers and wind do [Hz]
FLOOR = 1e-8  # of every PSD, relative to the mean power of the mixture


@dataclass(frozen=True, slots=True, eq=False)
class Evened:
    """What is separated, in the frequencies of voices, at mean power 1."""

    unit: Complex  # (2, n_used, n_frames)
    scene: Scene  # of these frequencies; its noise field has trace 2
    noise_psd: Real  # the noise term, (n_used,)
    used: Marks  # which of all frequencies, (n_freqs,)
    level: Real  # by which signals are multiplied afterwards, (n_used, n_frames)


def evened(spectrogram: Complex, scene: Scene, delays: Real, larger: float | None = None) -> Evened:
    """Divide every bin of (2, n_freqs, n_frames) by the level of the noise there; ``scene`` has a noise field.

    Parameters
    ----------
    delays
        TDOAs of the groups [s], (n_groups,).
    larger
        The noise term over the noise; None: the larger the less talkers are heard.
    """
    field = np.asarray(scene.noise_field, dtype=np.float32)
    level = np.maximum(0.5 * (field[:, 0] + field[:, 1]), np.finfo(np.float32).tiny)
    usual = np.exp(np.log(level).mean(axis=1))
    loudness = np.sqrt(level / usual[:, None])
    even = spectrogram / loudness
    use = scene.frequencies >= LOWEST_VOICE
    power = float((np.abs(even[:, use]) ** 2).mean())
    if larger is None:
        voices = band(scene.frequencies, *VOICE)
        heard = float(((np.abs(even[:, voices]) ** 2).mean(axis=(0, 2)) / usual[voices]).mean()) - 1
        larger = float(np.interp(10 * np.log10(max(heard, 1e-3)), HEARD, LARGER))
    noise = np.maximum(larger * usual[use] / power, FLOOR).astype(np.float32)
    part = replace(scene, frequencies=scene.frequencies[use], tau=delays, noise_field=(field / level[:, None])[use])
    unit = (even[:, use] / np.sqrt(power)).astype(np.complex64)
    return Evened(unit, part, noise, use, np.sqrt(power) * loudness[use])
