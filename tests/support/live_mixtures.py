"""Sources that come and go in patches of time and frequency, and a live separator that listens to them."""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.steering import steering_vectors
from ross_payload.interfaces import Complex, LiveSeparator, Real, Scene

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.8, 0.1, 0.9])
NOISE = 0.01
FRAMES = 160
SCENE = Scene(FREQUENCIES, 0.05, 343.0, 3, TAU, np.full(FREQUENCIES.size, NOISE), hop=128)


def bins(rng: np.random.Generator, *shape: int) -> Complex:
    """Circular Gaussian bins of mean power 1."""
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)).astype(np.complex64) / np.sqrt(2)


def mixture(tau: Real = TAU, frames: int = FRAMES, seed: int = 0, *, steady: bool = False) -> tuple[Complex, Complex]:
    """Sources of mean power 1: images at microphone 1 (n_sources, n_freqs, n_frames) and the noisy mixture.

    Steady ones are heard all the time, each at its own frequencies.
    """
    rng = np.random.default_rng(seed)
    patches = rng.random((len(tau), 33, frames // 8)) < 0.25
    if steady:
        patches[:] = rng.permuted(np.arange(33) % 4)[:, None] == np.arange(len(tau))[:, None, None]
    active = np.kron(patches, np.ones((1, 8, 8)))[:, : FREQUENCIES.size]
    images = 2 * active * bins(rng, *active.shape)
    clean = np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), images)
    return images, (clean + np.sqrt(NOISE) * bins(rng, *clean.shape)).astype(np.complex64)


def listened(live: LiveSeparator, heard: Complex, scene: Scene = SCENE, renew: int = 0) -> Complex:
    """Separate frame by frame, put back in time, (n_groups, n_freqs, n_frames - lookahead).

    Covariances are learnt from everything up to then and renewed every ``renew`` frames; 0: never.
    """
    state, learnt, found = live.start(scene), None, []
    for index in range(heard.shape[2]):
        state, groups = live.step(state, heard[:, :, index], scene)
        found.append(groups.signals)
        if renew and index % renew == renew - 1:
            learnt = live.learn(heard[:, :, : index + 1], scene, learnt)
            state = live.renewed(state, learnt)
    return np.concatenate(found, axis=2)[..., live.lookahead :]


def ratio_db(estimate: Complex, image: Complex) -> float:
    """Power of an image over that of what the estimate lacks of it or has beside it [dB]."""
    image = image[..., : estimate.shape[-1]]
    return float(10 * np.log10((np.abs(image) ** 2).sum() / (np.abs(estimate - image) ** 2).sum()))
