"""Separators of pyroomacoustics behind the payload's seam: ILRMA and FastMNMF2."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from pyroomacoustics.bss import fastmnmf2 as library_fastmnmf2
from pyroomacoustics.bss import ilrma as library_ilrma
from threadpoolctl import threadpool_limits

from ross_payload.dsp.steering import directions_of
from ross_payload.interfaces import Complex, Groups, Real, Scene
from ross_payload.separation.auxiva import two_sides
from ross_payload.separation.natural_gradient_iva import images_of, outputs_of

ILRMA_ITERATIONS = 40
MNMF_ITERATIONS = 50
BREAKDOWN = (FloatingPointError, np.linalg.LinAlgError)  # a handful of frames fit any model
DITHER = 1e-8  # white noise added to the mixture, relative to its power: no bin is singular
AXES = (2, 1, 0)  # ours (microphone, frequency, frame) is the library's (frame, frequency, microphone), and back


class Ilrma:
    """The separator: independent low-rank matrix analysis (Kitamura et al. 2016), two outputs."""

    name = "ilrma"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into two groups; known TDOAs say whom each output holds."""
        members, tau = two_sides(scene)

        def separated(unit: Complex) -> tuple[Complex, Complex]:
            found, rows = library_ilrma(unit, n_iter=ILRMA_ITERATIONS, proj_back=True, return_filters=True)
            return found, images_of(rows)

        return _groups_of(self.name, spectrogram, scene, members=members, tau=tau, separated=separated)


class FastMnmf2:
    """The separator: fast multichannel NMF (Sekiguchi et al. 2020), one output per group, two at least."""

    name = "fastmnmf2"

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a recording (2, n_freqs, n_frames) into groups; known TDOAs say whom each output holds."""
        members, tau = _groups(scene)

        def separated(unit: Complex) -> tuple[Complex, Complex]:
            images = library_fastmnmf2(unit, n_src=max(2, len(members)), n_iter=MNMF_ITERATIONS, mic_index="all")
            return images[0], (images[1] * images[0].conj()).sum(axis=0)

        return _groups_of(self.name, spectrogram, scene, members=members, tau=tau, separated=separated)


def prepared(spectrogram: Complex, seed: int) -> tuple[Complex, float]:
    """The mixture at unit power in the library's axes, with a trace of white noise, and its RMS; 0 when silent."""
    power = float((np.abs(spectrogram) ** 2).mean()) if spectrogram.size else 0.0
    if not power > 0:
        return spectrogram.transpose(AXES), 0.0
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((*spectrogram.shape, 2)) @ np.array([1, 1j])
    unit = spectrogram / np.sqrt(power) + np.sqrt(0.5 * DITHER) * noise
    return unit.astype(np.complex128).transpose(AXES).copy(), float(np.sqrt(power))


@contextmanager
def library(seed: int) -> Iterator[None]:
    """One numeric thread, and numpy's global generator seeded for the library, which has no other; then as before.

    Raises
    ------
    FloatingPointError
        Instead of the infinities and NaNs that the library would go on with.
    """
    state = np.random.get_state()  # noqa: NPY002
    np.random.seed(seed)  # noqa: NPY002
    try:
        with threadpool_limits(1), np.errstate(divide="raise", invalid="raise", over="raise"):
            yield
    finally:
        np.random.set_state(state)  # noqa: NPY002


def _groups(scene: Scene) -> tuple[tuple[tuple[int, ...], ...], Real | None]:
    """Members of every group and its TDOA [s]; () and None when directions are unknown."""
    if scene.tau is None:
        return ((),) * scene.n_sources, None
    return directions_of(scene, "a separator")


def _groups_of(
    name: str,
    spectrogram: Complex,
    scene: Scene,
    *,
    members: tuple[tuple[int, ...], ...],
    tau: Real | None,
    separated: Callable[[Complex], tuple[Complex, Complex]],
) -> Groups:
    """Run the library: ``separated`` gives its outputs at microphone 1, in its axes, and what tells where each is from.

    When the model breaks down every group is the whole mixture: nothing was separated, and `Groups.why` says so.
    """
    unit, scale = prepared(spectrogram, scene.seed)
    if not members or not scale > 0:
        return Groups(np.zeros((len(members), *spectrogram.shape[1:]), spectrogram.dtype), members, name)
    try:
        with library(scene.seed):
            found, cross = separated(unit)
    except BREAKDOWN as error:
        mixture = np.repeat(spectrogram[:1], len(members), axis=0)
        return Groups(mixture, members, name, f"not separated: the model broke down ({error})")
    order = range(len(members)) if tau is None else outputs_of(cross, scene.frequencies, tau)[: len(members)]
    signals = scale * found.transpose(AXES)[list(order)]
    return Groups(signals.astype(spectrogram.dtype), members, name)


ilrma = Ilrma()
fastmnmf2 = FastMnmf2()
