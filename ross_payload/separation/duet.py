"""DUET: every bin belongs to the source whose delay fits it best (Yilmaz and Rickard 2004)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.smoothing import average
from ross_payload.dsp.steering import ALIAS, delays_of, directions_of, steering_vectors
from ross_payload.dsp.stft import aliasing_limit, band
from ross_payload.interfaces import Complex, Groups, LiveSeparator, Real, Scene

SETTLING = 0.1  # of a guessed noise PSD, per frame
GRID = 181  # delays tried by the blind search
LOWEST = 100.0  # frequency used by the blind search [Hz]


def masks_of(spectrogram: Complex, frequencies: Real, tau: Real) -> Real:
    """Binary masks by the smallest residual |x_2 - exp(j 2 pi f tau) x_1|^2, (n_sources, n_freqs, n_frames).

    It is the likelihood of one plane wave in white noise: the delay whose delayed sum is the loudest wins.
    """
    first, second = spectrogram
    cross = second * first.conj()
    phase = steering_vectors(frequencies, tau)[:, 1].T.conj().astype(cross.dtype)
    score = np.stack([(cross * shift[:, None]).real for shift in phase])
    winner = score.argmax(axis=0)
    return np.asarray(winner == np.arange(len(tau))[:, None, None], np.float32)


def blind_delays(spectrogram: Complex, scene: Scene) -> Real:
    """The K highest separate peaks [s] of the power-weighted delay histogram below the aliasing limit, rising."""
    longest = scene.spacing / scene.speed_of_sound
    use = band(scene.frequencies, LOWEST, aliasing_limit(scene.spacing, scene.speed_of_sound))
    first, second = spectrogram[:, use]
    delay = np.angle(second * first.conj()) / (2 * np.pi * scene.frequencies[use][:, None])
    weight = np.abs(first * second) * scene.frequencies[use][:, None]
    inside = np.abs(delay) <= 1.1 * longest
    edges = np.linspace(-1.1 * longest, 1.1 * longest, GRID + 1)
    counts, _ = np.histogram(delay[inside], edges, weights=weight[inside])
    kernel = np.hanning(11)
    density, centres = np.convolve(counts, kernel / kernel.sum(), "same"), (edges[1:] + edges[:-1]) / 2
    found: list[float] = []
    for _ in range(scene.n_sources):
        if not density.max() > 0:
            break
        best = float(centres[density.argmax()])
        found.append(best)
        density[np.abs(centres - best) < 1.5 * ALIAS * longest] = 0
    return np.sort(np.clip(np.array(found), -longest, longest))


class Duet:
    """The separator: binary masks from delays, known or found in the mixture."""

    name = "duet"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into groups of sources that share a TDOA.

        Each output is the delayed sum of both microphones, within its mask, times a Wiener gain against the noise.
        Where the delays are not known and none is found, as with a dead microphone, the mixture is the only group.
        """
        if scene.tau is None:
            tau = blind_delays(spectrogram, scene)
            members: tuple[tuple[int, ...], ...] = tuple(() for _ in tau)
        else:
            members, tau = directions_of(scene, self.name)
        if not len(tau):
            return _whole(spectrogram, scene)
        noise = scene.noise_psd if scene.noise_psd is not None else guessed_psd(spectrogram)
        beams, gains = masked_beams(spectrogram, scene.frequencies, tau, noise)
        return Groups(beams * gains, members, self.name, masks=gains)

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the same method frame by frame; the delays must be known."""
        return LiveDuet(lookahead)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """What is known after a frame."""

    members: tuple[tuple[int, ...], ...]
    frames: Complex  # the frame that is separated, one before it and those after it, (n, 2, n_freqs)
    noise_psd: Real  # in use, (n_freqs,)
    goal: Real  # towards which it moves, (n_freqs,)


@dataclass(slots=True)
class LiveDuet:
    """The live separator: nothing is learnt but the noise, and only when it is not known."""

    name = "duet"
    lookahead: int = 1  # frames that must be heard after a frame before it is separated

    def start(self, scene: Scene) -> State:
        """Return the state in which nothing was heard yet.

        Raises
        ------
        ConfigError
            When the TDOAs are not known.
        """
        members, _ = directions_of(scene, self.name)
        n_freqs = scene.frequencies.size
        noise = np.zeros(n_freqs, np.float32)
        return State(members, np.zeros((self.lookahead + 2, 2, n_freqs), np.complex64), noise, noise)

    def step(self, state: State, frame: Complex, scene: Scene) -> tuple[State, Groups]:
        """Hear one frame (2, n_freqs); return the groups of ``lookahead`` frames ago, (n_groups, n_freqs, 1)."""
        frames = np.concatenate([state.frames[1:], frame[None]], dtype=np.complex64)
        noise = state.noise_psd + (state.goal - state.noise_psd) * np.float32(SETTLING)
        state = replace(state, frames=frames, noise_psd=noise)
        if not state.members:
            return state, Groups(np.zeros((0, frame.shape[1], 1), np.complex64), (), self.name)
        tau = delays_of(state.members, np.asarray(scene.tau, float))
        near = np.ascontiguousarray(np.moveaxis(frames[:3], 0, -1))
        known = noise if scene.noise_psd is None else np.asarray(scene.noise_psd)
        beams, gains = masked_beams(near, scene.frequencies, tau, known)
        masks = gains[..., 1:2]
        return state, Groups(beams[..., 1:2] * masks, state.members, self.name, masks=masks)

    def learn(self, window: Complex, scene: Scene, before: Real | None = None) -> Real:
        """Guess the noise PSD from the latest frames (2, n_freqs, n_frames), (n_freqs,)."""
        known = scene.noise_psd
        return (guessed_psd(window) if known is None else np.asarray(known)).astype(np.float32)

    def renewed(self, state: State, learnt: Real) -> State:
        """Return the state whose noise PSD moves towards what was learnt."""
        return replace(state, goal=learnt)


def _whole(spectrogram: Complex, scene: Scene) -> Groups:
    """The mixture at a microphone that hears as the only group, of somebody unknown; no group of nobody."""
    if not scene.n_sources:
        return Groups(np.zeros((0, *spectrogram.shape[1:]), spectrogram.dtype), (), Duet.name)
    heard = spectrogram[:1] if spectrogram[0].any() else spectrogram[1:]
    return Groups(heard, ((),), Duet.name, why="no delay found: the mixture as it is")


def masked_beams(spectrogram: Complex, frequencies: Real, tau: Real, noise_psd: Real) -> tuple[Complex, Real]:
    """The delayed sum of every group, and its mask times a Wiener gain, both (n_groups, n_freqs, n_frames)."""
    masks = masks_of(spectrogram, frequencies, tau)
    shifts = steering_vectors(frequencies, tau)[:, 1].T.conj().astype(spectrogram.dtype)
    beams = 0.5 * (spectrogram[0] + shifts[:, :, None] * spectrogram[1])
    return beams, np.asarray(masks * _gains(beams * masks, 0.5 * noise_psd), np.float32)


def _gains(beams: Complex, noise_psd: Real) -> Real:
    """Wiener gains 1 - noise / power, the power averaged over 3 x 3 bins, in [0, 1]."""
    power = np.stack([average(np.abs(beam) ** 2) for beam in beams])
    noise = noise_psd[:, None].astype(power.dtype)
    heard = power > noise
    return np.asarray(np.where(heard, 1 - noise / np.where(heard, power, 1), 0))


separator = Duet()
