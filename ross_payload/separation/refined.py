"""The separator `refined`: a small network that knows speech corrects the PSDs of the local Gaussian model.

Every group is described by the same few numbers per bin; the same network sees each group beside the mean of the
others, so that any number of groups works and their order does not matter. Its output is a factor for every PSD; the
multichannel Wiener filter of the local Gaussian model does the rest.
"""

from __future__ import annotations

import numpy as np

from ross_payload.dsp.metrics import qualities
from ross_payload.interfaces import Complex, Groups, LiveSeparator, Quality, Real, Scene
from ross_payload.separation.live_refined import LiveRefined
from ross_payload.separation.local_gaussian_model import fitted, from_directions, wiener
from ross_payload.separation.network import Network, shipped_network
from ross_payload.separation.refiner_features import HIGHEST, LEAST, STEADY, features, trained_for

BONUS = 0.75  # SI-SDR above that of the local Gaussian model [dB]


class Refined:
    """The separator: local Gaussian model from known TDOAs, its PSDs corrected by a network."""

    name = "refined"

    def __init__(self, network: Network | None = None) -> None:
        self._network = network

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate as `ross_payload.separation.local_gaussian_model.from_directions` says."""
        return from_directions(self._separated, spectrogram, scene, self.name, always_below=HIGHEST)

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the same model frame by frame."""
        return LiveRefined(self._network or shipped_network(), lookahead)

    def _separated(self, unit: Complex, scene: Scene, noise_psd: Real) -> tuple[Complex, Real, tuple[Quality, ...]]:
        observed, covariances, psds = fitted(unit, scene, noise_psd)
        quality = qualities(psds, covariances, BONUS)
        low = slice(0, int((scene.frequencies < HIGHEST).sum()))
        if trained_for(scene.frequencies[low]):
            network = self._network or shipped_network()
            shown = features(observed[low], covariances[low], psds[low])
            factors = np.exp(network.corrections(shown, scene.frequencies[low]))
            psds[low, :-1] = np.maximum(psds[low, :-1], LEAST) * np.swapaxes(factors, 0, 1)
        masks = np.swapaxes(psds[:, :-1] / psds.sum(axis=1, keepdims=True), 0, 1)
        psds[:, -1] = np.maximum(psds[:, -1], STEADY * (1 + psds[:, :-1].sum(axis=1)))
        return wiener(unit, psds, covariances), masks, quality


separator = Refined()
