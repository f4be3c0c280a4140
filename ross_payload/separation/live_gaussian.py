"""The local Gaussian model frame by frame: covariances that fade from one to the next, PSDs with a short look-ahead.

The covariances come from geometry until something was learnt. What is learnt fades in over `FADE`; they follow their
source when its TDOA changes. A group is the sources that share a TDOA at the start, and stays so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ross_payload.dsp.covariance import direct, outer
from ross_payload.dsp.noise import guessed_psd
from ross_payload.dsp.steering import ALIAS, delays_of, directions_of
from ross_payload.interfaces import Complex, Groups, Real, Scene
from ross_payload.separation import cacgmm, live_psds
from ross_payload.separation.directness import astray, geometric_start

UPDATES = 6  # of the PSDs of every frame that is under way, whenever another one is heard
UNSMOOTHED = 1  # of them before the smoothing begins, for the newest frame
TIED = 0.05  # weight of the shares of the groups among the averages that every update is drawn towards
FLOOR = 1e-8  # of every PSD, relative to the mean power of the mixture
FADE = 0.25  # from old covariances to new ones [s]
HASTE = 0.25  # or, when little was heard yet, this part of it
LEVEL = 4.0  # time constant of the mean power of the mixture [s]
ROOM = 0.010  # energy that no direction explains, before it is measured
PRIOR_COUNT = 3.0  # bins that geometry counts for when covariances are learnt
PRIOR_FRAMES = 64.0  # that what was known about the room counts for, or nothing
SILENT = np.float32(1e-17)  # PSD where nothing is heard: its square is a number, too
COHERENT = 1 - 1e-4  # no field is more coherent than this
GUESS = 1e-3  # noise relative to the mean power, before it is measured
WHITE = np.array([1, 1, 0, 0], np.float32)[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class Learnt:
    """What a stretch of sound tells about the sources."""

    members: tuple[tuple[int, ...], ...]
    tau: Real  # TDOAs of the groups then [s], (n_groups,)
    covariances: Real  # coordinates, trace 2, (n_groups, 4, n_freqs)
    noise_psd: Real  # (n_freqs,)
    astray: float  # energy that no direction explains: how poor the room is


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """What is known after a frame. Under way are the newest ``lookahead`` + 1 frames; before them was silence."""

    members: tuple[tuple[int, ...], ...]
    tau: Real  # of the groups [s], (n_groups,)
    covariances: Real  # in use, the noise last, (n_groups + 1, 4, n_freqs)
    goal: Real  # to which they fade, (n_groups, 4, n_freqs)
    fading: int  # frames until they are there
    renewal: Learnt | None  # to which they fade from the next frame on
    noise_psd: Real | None  # learnt, (n_freqs,)
    level: float  # mean power of the mixture
    age: int  # frames heard
    frames: Complex  # under way, (n, 2, n_freqs)
    observed: Real  # coordinates of their x x^H, (n, 4, n_freqs)
    expected: Real  # what their shares let expect of the PSDs, (n, n_groups, n_freqs)
    psds: Real  # theirs, and before them those of the last one that was separated, (n + 1, n_groups, n_freqs)


@dataclass(slots=True)
class LiveGaussian:
    """The live separator."""

    name = "gaussian"
    lookahead: int = 1  # frames that must be heard after a frame before it is separated

    def start(self, scene: Scene) -> State:
        """Return the state in which nothing was heard yet.

        Raises
        ------
        ConfigError
            When the TDOAs are not known.
        """
        members, tau = directions_of(scene, f"the {self.name} model")
        sources = _by_frequency(_expected(scene, tau, ROOM)[0])
        noise = np.broadcast_to(WHITE, (1, 4, scene.frequencies.size))
        n, n_freqs, both = self.lookahead + 1, scene.frequencies.size, np.concatenate([sources, noise])
        frames, observed = np.zeros((n, 2, n_freqs), np.complex64), np.zeros((n, 4, n_freqs), np.float32)
        psds = np.full((n + 1, len(members), n_freqs), SILENT)
        return State(
            members, tau, both, sources, 0, None, None, 0.0, 0, frames, observed, psds[1:] ** np.float32(TIED), psds
        )

    def step(self, state: State, frame: Complex, scene: Scene) -> tuple[State, Groups]:
        """Hear one frame (2, n_freqs); return the groups of ``lookahead`` frames ago, (n_groups, n_freqs, 1)."""
        state = self.update(state, frame, scene)
        psds = np.concatenate([state.psds[1], self.noise_of(state, scene)[None]])
        return state, separated(state, psds, self.name)

    def learn(self, window: Complex, scene: Scene, before: Learnt | None = None) -> Learnt:
        """Learn covariances from the latest frames (2, n_freqs, n_frames); ``before``: the result of the last time."""
        members, tau = directions_of(scene, f"the {self.name} model")
        waves = direct(scene.frequencies, tau).astype(np.float32)
        window = window[:, :, :: thinned(scene)]
        power = float((np.abs(window) ** 2).mean()) if window.size else 0.0
        unit = (window / np.sqrt(power) if power > 0 else window).astype(np.complex64)
        noise = guessed_psd(unit) if scene.noise_psd is None else np.asarray(scene.noise_psd) / max(power, 1e-30)
        noise = np.maximum(noise, FLOOR).astype(np.float32)
        if not members:
            return Learnt(members, tau, np.zeros((0, 4, noise.size), np.float32), noise * power, ROOM)
        observed = outer(unit).astype(np.float32)
        part, frames = astray(observed, scene.frequencies, waves, noise), observed.shape[2]
        usual = ROOM if before is None else before.astray
        part = (frames * part + PRIOR_FRAMES * usual) / (frames + PRIOR_FRAMES)
        begin, anchor = _expected(scene, tau, part)
        known = None
        if before is not None and same_sources(before, members, tau, scene):
            known = np.moveaxis(followed(before.covariances, tau - before.tau, scene.frequencies), -1, 0)
        covariances, _ = cacgmm.learn(observed, begin, noise, anchor, before=known, prior_count=PRIOR_COUNT)
        return Learnt(members, tau, _by_frequency(covariances), noise * power, part)

    def renewed(self, state: State, learnt: Learnt) -> State:
        """Return the state that fades to what was learnt; from another heading it takes how poor the room is alone."""
        return replace(state, renewal=learnt)

    def noise_of(self, state: State, scene: Scene) -> Real:
        """Noise PSD as far as it is known, (n_freqs,)."""
        known = scene.noise_psd if scene.noise_psd is not None else state.noise_psd
        floor = FLOOR * state.level + SILENT
        if known is None:
            return np.full(scene.frequencies.size, GUESS * state.level + floor, np.float32)
        return np.maximum(known, floor).astype(np.float32)

    def update(self, state: State, frame: Complex, scene: Scene) -> State:
        """Take in a frame (2, n_freqs), and update the PSDs of those that are under way."""
        if not state.members:
            return state
        state = _moved(state, scene)
        observed = live_psds.outer(frame.astype(np.complex64))
        power = 0.5 * (observed[0] + observed[1])
        weight = max(_period(scene) / LEVEL, 1 / (state.age + 1))
        level = state.level + weight * (float(power.mean()) - state.level)
        state = replace(state, level=level, age=state.age + 1)
        noise, floor = self.noise_of(state, scene), np.float32(FLOOR * level + SILENT)
        begin = live_psds.shares_of(observed, state.covariances[:-1], noise) * power + floor
        expected = live_psds.averaged(begin) ** np.float32(TIED)
        state = replace(
            state,
            frames=np.concatenate([state.frames[1:], frame[None]], dtype=np.complex64),
            observed=np.concatenate([state.observed[1:], observed[None]]),
            expected=np.concatenate([state.expected[1:], expected[None]]),
            psds=np.concatenate([state.psds[1:], begin[None]]),
        )
        return replace(state, psds=_fitted(state, noise, floor))


def separated(state: State, psds: Real, name: str) -> Groups:
    """The groups of the oldest frame under way; PSDs with the noise last, (n_groups + 1, n_freqs)."""
    if not state.members:
        return Groups(np.zeros((0, psds.shape[-1], 1), np.complex64), (), name)
    signals = live_psds.wiener(state.frames[0], psds, state.covariances)[..., None]
    masks = (psds[:-1] / psds.sum(axis=0))[..., None]
    return Groups(signals, state.members, name, masks=masks)


def _fitted(state: State, noise: Real, floor: np.float32) -> Real:
    """The PSDs with those of the frames under way updated, (n + 1, n_groups, n_freqs)."""
    flipped = live_psds.adjugate(state.covariances)
    gram = np.einsum("kcf,jcf->kjf", state.covariances, flipped)
    cross = np.einsum("tcf,kcf->tkf", state.observed, flipped)
    last, every = state.psds[:1], np.broadcast_to(noise, (len(cross), 1, noise.size))
    psds = np.concatenate([state.psds[1:], every], axis=1)
    around = np.empty((len(psds) + 2, *last.shape[1:]), psds.dtype)
    around[:1] = live_psds.averaged(last)
    for update in range(UPDATES):
        found = live_psds.updated(psds, cross, gram)
        around[1:-1] = live_psds.averaged(psds[:, :-1])
        around[-1] = around[-2]
        drawn = around[:-2] + around[1:-1]
        drawn += around[2:]
        drawn *= np.float32(1 / 3)
        np.log(drawn, out=drawn)
        drawn *= np.float32(0.5 - TIED)
        np.exp(drawn, out=drawn)
        drawn *= np.sqrt(found)
        drawn *= state.expected
        if update < UNSMOOTHED:
            drawn[-1] = found[-1]
        np.maximum(drawn, floor, out=psds[:, :-1])
    return np.concatenate([last, psds[:, :-1]])


def followed(covariances: Real, change: Real, frequencies: Real) -> Real:
    """Covariances (n_groups, 4, n_freqs) of sources whose TDOAs have changed by (n_groups,) [s].

    R' = D R D^H with D = diag(1, exp(j 2 pi f change)): it stays a covariance, and its plane wave moves along.
    """
    if not np.any(change):
        return covariances
    turn = np.exp(-2j * np.pi * frequencies * np.asarray(change)[:, None])
    cross = (covariances[:, 2] + 1j * covariances[:, 3]) * turn
    return np.stack([covariances[:, 0], covariances[:, 1], cross.real, cross.imag], axis=1).astype(covariances.dtype)


def _moved(state: State, scene: Scene) -> State:
    """The state with covariances for this frame: they fade, and follow the TDOAs."""
    tau = delays_of(state.members, np.asarray(scene.tau, float))
    state = _fading(state, scene)
    change, sources, goal, fading = tau - state.tau, state.covariances[:-1], state.goal, state.fading
    if not fading and not change.any():
        return state
    if fading:
        sources = sources + (goal - sources) / np.float32(fading)
        fading -= 1
    both = np.concatenate([followed(sources, change, scene.frequencies), state.covariances[-1:]])
    goal = followed(goal, change, scene.frequencies)
    return replace(state, tau=tau, covariances=both, goal=goal, fading=fading)


def _fading(state: State, scene: Scene) -> State:
    """The state that has begun to fade to what was learnt; at once when nothing was heard yet."""
    learnt = state.renewal
    if learnt is None:
        return state
    if same_sources(learnt, state.members, state.tau, scene):
        goal = followed(learnt.covariances, state.tau - learnt.tau, scene.frequencies)
    else:
        goal = _by_frequency(_expected(scene, state.tau, learnt.astray)[0])
    fading = max(round(min(FADE / _period(scene), HASTE * state.age)), 1)
    return replace(state, goal=goal, fading=fading, noise_psd=learnt.noise_psd, renewal=None)


def _expected(scene: Scene, tau: Real, part: float) -> tuple[Real, float]:
    """`geometric_start` of TDOAs (n_groups,) [s], regular at 0 Hz too, where both microphones hear the same."""
    begin, anchor = geometric_start(scene, direct(scene.frequencies, tau).astype(np.float32), part)
    begin[..., 2:] *= np.float32(COHERENT)
    return begin, anchor


def same_sources(learnt: Learnt, members: tuple[tuple[int, ...], ...], tau: Real, scene: Scene) -> bool:
    """Whether something was learnt where the groups are, and not at another heading."""
    near = ALIAS * scene.spacing / scene.speed_of_sound
    return learnt.members == members and bool((np.abs(learnt.tau - tau) < near).all())


def _period(scene: Scene) -> float:
    """Time between frames [s]; when it is not known, frames overlap by three quarters."""
    frame = 2 * (scene.frequencies.size - 1)
    return float((scene.hop or frame / 4) / (2 * scene.frequencies[-1]))


def thinned(scene: Scene) -> int:
    """Frames from one that is learnt from to the next: they overlap by three quarters at most."""
    frame = 2 * (scene.frequencies.size - 1)
    return max(round(frame / 4 / (scene.hop or frame / 4)), 1)


def _by_frequency(covariances: Real) -> Real:
    """(n_freqs, n_groups, 4) with the frequencies last."""
    return np.ascontiguousarray(np.moveaxis(covariances, 0, -1), np.float32)
