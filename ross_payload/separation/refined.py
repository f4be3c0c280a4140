"""The separator `refined`: a small network that knows speech corrects the PSDs of the local Gaussian model.

Every group is described by the same few numbers per bin; the same network sees each group beside the mean of the
others, so that any number of groups works and their order does not matter. Its output is a factor for every PSD. With
these PSDs the covariances are estimated again where a room is reverberant; the multichannel Wiener filter of the local
Gaussian model does the rest.

Frame by frame the network follows the frames of the live local Gaussian model. It was trained for frames that overlap
by three quarters: when they overlap more it sees one in so many, and what it says is interpolated. It knows the past,
and of the future what the look-ahead lets it know.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ross_payload.dsp.covariance import direct
from ross_payload.dsp.metrics import qualities
from ross_payload.interfaces import Complex, Groups, LiveSeparator, Quality, Real, Scene
from ross_payload.separation.covariance_em import reestimated
from ross_payload.separation.directness import directness_of
from ross_payload.separation.live_gaussian import Learnt, LiveGaussian, State, separated, thinned
from ross_payload.separation.local_gaussian_model import UPDATES, fitted, from_directions, reverberant, wiener
from ross_payload.separation.network import Network, Past, network_in_noise, shipped_network
from ross_payload.separation.refiner_features import (
    HIDDEN,
    HIGHEST,
    LEAST,
    STEADY,
    WIDTHS,
    Features,
    features,
    features_in_noise,
    trained_for,
)

BONUS, BONUS_IN_NOISE = 2.0, 0.75  # SI-SDR above that of the local Gaussian model [dB]; where noise has a direction
BEFORE = 12  # updates of the PSDs before the network corrects them
LARGER = 1.5  # noise term over the noise that has a direction: the network corrects it, too
KEPT = 3  # frames that the network has seen whose corrections are interpolated


class Refined:
    """The separator: local Gaussian model from known TDOAs, its PSDs corrected by a network."""

    name = "refined"

    def __init__(self, network: Network | None = None, in_noise: Network | None = None) -> None:
        self._network, self._in_noise = network, in_noise

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate as `ross_payload.separation.local_gaussian_model.from_directions` says.

        `Groups.why` says when the network is not used, since it was not trained for frames of this length.
        """
        core = self._separated if scene.noise_field is None else self._separated_in_noise
        known = trained_for(scene.frequencies)
        larger = LARGER if known else None
        groups = from_directions(core, spectrogram, scene, self.name, always_below=HIGHEST, larger=larger)
        return groups if known or reverberant(spectrogram, scene) else replace(groups, why=_untrained(scene))

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the same model frame by frame."""
        return LiveRefined(self._network or shipped_network(), lookahead)

    def _separated(self, unit: Complex, scene: Scene, noise_psd: Real) -> tuple[Complex, Real, tuple[Quality, ...]]:
        low = slice(0, int((scene.frequencies < HIGHEST).sum()))
        frequencies, known = scene.frequencies[low], trained_for(scene.frequencies[low])
        observed, covariances, psds = fitted(unit, scene, noise_psd, BEFORE if known else UPDATES)
        quality = qualities(psds, covariances, BONUS if known else 0.0)
        if known:
            network = self._network or shipped_network()
            shown = features(observed[low], covariances[low], psds[low])
            factors = np.exp(network.corrections(shown, frequencies))
            psds[low, :-1] = np.maximum(psds[low, :-1], LEAST) * np.swapaxes(factors, 0, 1)
            scattered = np.float32(1 - _directness(observed, scene, noise_psd))
            if scattered > 0:
                again = reestimated(observed[low], covariances[low], psds[low])
                covariances[low] += scattered * (again - covariances[low])
        masks = np.swapaxes(psds[:, :-1] / psds.sum(axis=1, keepdims=True), 0, 1)
        psds[:, -1] = np.maximum(psds[:, -1], STEADY * (1 + psds[:, :-1].sum(axis=1)))
        return wiener(unit, psds, covariances), masks, quality

    def _separated_in_noise(
        self, unit: Complex, scene: Scene, noise_psd: Real
    ) -> tuple[Complex, Real, tuple[Quality, ...]]:
        """As `_separated`; the noise is one more group, whose PSD is corrected like those of the others."""
        observed, covariances, psds = fitted(unit, scene, noise_psd)
        low = slice(0, int((scene.frequencies < HIGHEST).sum()))
        known = trained_for(scene.frequencies[low])
        quality = qualities(psds, covariances, BONUS_IN_NOISE if known else 0.0)
        if known:
            network, field = self._in_noise or network_in_noise(), np.asarray(scene.noise_field)[low]
            shown = shown_in_noise(observed[low], covariances[low, :-1], psds[low, :-1], noise_psd[low], field)
            factors = np.exp(network.corrections(shown, scene.frequencies[low]))
            psds[low, :-1] = _above(psds[low, :-1], noise_psd[low])
            psds[low] *= np.swapaxes(factors, 0, 1)
        masks = np.swapaxes(psds[:, :-1] / psds.sum(axis=1, keepdims=True), 0, 1)
        psds[:, -1] = np.maximum(psds[:, -1], STEADY * (1 + psds[:, :-1].sum(axis=1)))
        return wiener(unit, psds, covariances, scene.noise_field), masks, quality


def _directness(observed: Real, scene: Scene, noise_psd: Real) -> float:
    """1 in the open, where the covariances of plane waves are the true ones, 0 in a reverberant room."""
    waves = direct(scene.frequencies, np.asarray(scene.tau)).astype(np.float32)
    return directness_of(observed, scene.frequencies, waves, noise_psd)


@dataclass(frozen=True, slots=True, eq=False)
class RefinedState:
    """What is known after a frame; low are the bins below `HIGHEST`."""

    model: State
    observed: Real  # coordinates of x x^H of the latest frames, (n, 4, n_low)
    psds: Real  # theirs, (n, n_groups, n_low)
    corrections: Real  # of the logarithms of PSDs, of the frames that the network saw last, (KEPT, n_groups, n_low)
    past: Past


class LiveRefined:
    """The live separator.

    Parameters
    ----------
    network
        The weights.
    lookahead
        Frames that must be heard after a frame before it is separated.
    """

    name = "refined"

    def __init__(self, network: Network, lookahead: int = 1) -> None:
        self.lookahead = lookahead
        self._model, self._network = LiveGaussian(lookahead), network

    def start(self, scene: Scene) -> RefinedState:
        """Return the state in which nothing was heard yet.

        Raises
        ------
        ConfigError
            When the TDOAs are not known.
        """
        model, n_low = self._model.start(scene), _low(scene)
        n, n_groups = thinned(scene) + 1, len(model.members)
        observed, psds = np.zeros((n, 4, n_low), np.float32), np.zeros((n, n_groups, n_low), np.float32)
        return RefinedState(model, observed, psds, np.zeros((KEPT, n_groups, n_low), np.float32), ())

    def step(self, state: RefinedState, frame: Complex, scene: Scene) -> tuple[RefinedState, Groups]:
        """Hear one frame (2, n_freqs); return the groups of ``lookahead`` frames ago, (n_groups, n_freqs, 1)."""
        model, low = self._model.update(state.model, frame, scene), slice(_low(scene))
        noise = self._model.noise_of(model, scene)
        psds = np.concatenate([model.psds[1], noise[None]])
        if model.level > 0 and trained_for(scene.frequencies[low]):
            state = self._followed(state, model, noise, scene)
            level = np.float32(model.level)
            psds[:-1, low] = np.maximum(psds[:-1, low], LEAST * level) * np.exp(self._correction(state, scene))
            psds[-1] = np.maximum(psds[-1], STEADY * (level + psds[:-1].sum(axis=0)))
        return replace(state, model=model), separated(model, psds, self.name)

    def learn(self, window: Complex, scene: Scene, before: Learnt | None = None) -> Learnt:
        """Learn covariances as `LiveGaussian.learn` does."""
        return self._model.learn(window, scene, before)

    def renewed(self, state: RefinedState, learnt: Learnt) -> RefinedState:
        """Return the state that fades to what was learnt, as `LiveGaussian.renewed` does."""
        return replace(state, model=self._model.renewed(state.model, learnt))

    def _followed(self, state: RefinedState, model: State, noise: Real, scene: Scene) -> RefinedState:
        """Keep what the network is shown, and show it when it is time."""
        low = slice(_low(scene))
        observed = np.concatenate([state.observed[1:], model.observed[-1:, :, low]])
        psds = np.concatenate([state.psds[1:], model.psds[-1:, :, low]])
        fresh = min(len(psds), self.lookahead + 1)
        psds[-fresh:] = model.psds[-fresh:, :, low]
        state = replace(state, model=model, observed=observed, psds=psds)
        if model.age % thinned(scene):
            return state
        level = np.float32(model.level)
        both = np.concatenate([psds[[0, -1]], np.broadcast_to(noise[low], (2, 1, noise[low].size))], axis=1)
        matrices = np.ascontiguousarray(np.moveaxis(model.covariances[..., low], -1, 0))
        shown = features(
            np.ascontiguousarray(observed[[0, -1]].transpose(2, 1, 0)) / level,
            matrices,
            np.ascontiguousarray(both.transpose(2, 1, 0)) / level,
        )
        found, past = self._network.advance(shown, scene.frequencies[low], state.past)
        latest = np.moveaxis(found, -1, 0)
        return replace(state, corrections=np.concatenate([state.corrections[1:-1], latest]), past=past)

    def _correction(self, state: RefinedState, scene: Scene) -> Real:
        """Of the frame that is separated, between those of the frames that the network saw, (n_groups, n_low)."""
        every = thinned(scene)
        place = KEPT - 1 + (state.model.age % every - self.lookahead) / every
        place = min(max(place, 0.0), KEPT - 1.0)
        first = min(int(place), KEPT - 2)
        part = np.float32(place - first)
        return np.asarray((1 - part) * state.corrections[first] + part * state.corrections[first + 1])


def shown_in_noise(observed: Real, covariances: Real, psds: Real, noise_psd: Real, field: Real) -> Features:
    """What the network is shown where the noise has a direction: the groups, and the noise as one more.

    Parameters
    ----------
    observed
        Coordinates of x x^H, (n_freqs, 4, n_frames).
    covariances, psds
        Of the groups, (n_freqs, n_groups, 4) and (n_freqs, n_groups, n_frames).
    noise_psd
        (n_freqs,).
    field
        Coordinates of the covariance of the noise, trace 2, (n_freqs, 4, n_frames).
    """
    noise = np.broadcast_to(noise_psd[:, None, None], (len(psds), 1, psds.shape[2]))
    every = np.concatenate([_above(psds, noise_psd), noise], axis=1)
    white = np.broadcast_to(np.array([1, 1, 0, 0], np.float32), (len(psds), 1, 4))
    return features_in_noise(observed, np.concatenate([covariances, white], axis=1), every, field)


def _above(psds: Real, noise_psd: Real) -> Real:
    """PSDs from which the network can lift a voice that the local Gaussian model gave up."""
    return np.asarray(np.maximum(psds, HIDDEN * noise_psd[:, None, None] + LEAST))


def _untrained(scene: Scene) -> str:
    """Why the network is not used, in words."""
    frequencies = scene.frequencies
    if frequencies.size < 2:
        return "the local Gaussian model alone: too few frequencies for the network"
    shortest, longest = (1000 / width for width in reversed(WIDTHS))
    return (
        f"the local Gaussian model alone: frames of {1000 / (frequencies[1] - frequencies[0]):.0f} ms, and the network "
        f"is for {shortest:.0f} to {longest:.0f} ms"
    )


def _low(scene: Scene) -> int:
    return int((scene.frequencies < HIGHEST).sum())


separator = Refined()
