"""How reverberant a recording is, and what covariances it lets expect before anything is learnt."""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.covariance import adjugate, diffuse
from ross_payload.dsp.stft import band
from ross_payload.interfaces import Real, Scene

ASTRAY = (0.008, 0.013, 0.025, 0.045)  # energy that no direction explains: in the open .. where little is direct
DIFFUSE = (0.03, 0.4, 0.4, 0.6)  # part of every covariance to begin with
ANCHOR = (0.5, 0.3, 0.3, 0.15)  # of the learning
CLEAR, LOUD = 30.0, 4.0  # it is measured in bins this many times above the noise, and above the mean of the frequency
VOICE = (500.0, 4000.0)  # and between these frequencies [Hz]


def astray(observed: Real, frequencies: Real, waves: Real, noise_psd: Real) -> float:
    """Energy that no direction explains: hardly any in the open, the more the poorer the room.

    The median over strong bins of the part of their energy that is orthogonal to the steering vector that fits best;
    0 when no bin is strong, or there is no group.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    waves
        Coordinates of a a^H of every group, (n_freqs, n_groups, 4).
    """
    power = observed[:, 0] + observed[:, 1]
    least = np.maximum(2 * CLEAR * noise_psd, LOUD * power.mean(axis=1))
    strong = (power > least[:, None]) & band(frequencies, *VOICE)[:, None]
    if not (waves.shape[1] and strong.any()):
        return 0.0
    orthogonal = (waves @ adjugate(observed, axis=1)).min(axis=1)[strong] / (2 * power[strong])
    return float(np.median(orthogonal))


def directness_of(observed: Real, frequencies: Real, waves: Real, noise_psd: Real) -> float:
    """How much every strong bin looks like a plane wave: 1 in the open, 0 in reverberation; arguments of `astray`."""
    return float(np.interp(astray(observed, frequencies, waves, noise_psd), ASTRAY[:2], (1, 0)))


def geometric_start(scene: Scene, waves: Real, part: float) -> tuple[Real, float]:
    """Covariances of plane waves in a diffuse field, trace 2, (n_freqs, n_groups, 4), and the anchor of the learning.

    The poorer the room, the larger the diffuse share and the freer the learning.

    Parameters
    ----------
    waves
        Coordinates of a a^H of every group, (n_freqs, n_groups, 4).
    part
        Energy that no direction explains, as `astray` measures it.
    """
    share, anchor = (float(np.interp(part, ASTRAY, values)) for values in (DIFFUSE, ANCHOR))
    field = diffuse(scene.frequencies, scene.spacing, scene.speed_of_sound).astype(np.float32)[:, None]
    return np.asarray((1 - share) * waves + share * field), anchor
