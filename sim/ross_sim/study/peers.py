"""The separators of other libraries, called as they are: same spectrogram in, outputs at microphone 1 out.

Every call takes a spectrogram (2, n_freqs, n_frames), a number of iterations and a number of outputs, and returns
(n_outputs, n_freqs, n_frames). ssspy comes with the dependency group ``bench`` (`pip install --group bench`); without
it its rows are missing. Its FastMNMF is the first one (Sekiguchi et al. 2019), that of pyroomacoustics the second
(2020).
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
import pyroomacoustics as pra

from ross_payload.interfaces import Complex
from ross_sim.library import library
from ross_sim.study.workload import Peer

AXES = (2, 1, 0)  # pyroomacoustics: (n_frames, n_freqs, n_channels)
SEED = 0  # of the random starts
BASES = 2  # of ILRMA and FastMNMF per source, in both libraries

Call = Callable[[Complex, int, int], Complex]


def peers(auxiva: int, ilrma: int, mnmf: int) -> tuple[Peer, ...]:
    """AuxIVA, ILRMA and FastMNMF of both libraries, with so many iterations each; ssspy only where it is installed."""
    counts = {"AuxIVA": auxiva, "ILRMA": ilrma, "FastMNMF": mnmf}
    calls: list[tuple[str, str, Call]] = [
        ("pyroomacoustics", "AuxIVA", _pra_auxiva),
        ("pyroomacoustics", "ILRMA", _pra_ilrma),
        ("pyroomacoustics", "FastMNMF", _pra_fastmnmf2),
    ]
    if find_spec("ssspy") is not None:
        calls += [
            ("ssspy", "AuxIVA", _ssspy_auxiva),
            ("ssspy", "ILRMA", _ssspy_ilrma),
            ("ssspy", "FastMNMF", _ssspy_fastmnmf),
        ]
    return tuple(Peer(library, method, counts[method], call) for library, method, call in calls)


def _pra_auxiva(spectrogram: Complex, iterations: int, outputs: int) -> Complex:
    found = pra.bss.auxiva(spectrogram.transpose(AXES), n_iter=iterations, proj_back=True, model="gauss")
    return np.asarray(found.transpose(AXES))


def _pra_ilrma(spectrogram: Complex, iterations: int, outputs: int) -> Complex:
    with library(SEED):
        found = pra.bss.ilrma(spectrogram.transpose(AXES), n_iter=iterations, proj_back=True, n_components=BASES)
    return np.asarray(found.transpose(AXES))


def _pra_fastmnmf2(spectrogram: Complex, iterations: int, outputs: int) -> Complex:
    with library(SEED):
        found = pra.bss.fastmnmf2(spectrogram.transpose(AXES), n_src=outputs, n_iter=iterations, n_components=BASES)
    return np.asarray(found.transpose(AXES))


def _ssspy_auxiva(spectrogram: Complex, iterations: int, outputs: int) -> Complex:
    from ssspy.bss.iva import AuxGaussIVA  # noqa: PLC0415 - only where it is installed

    return np.asarray(AuxGaussIVA(record_loss=False)(spectrogram, n_iter=iterations, initial_call=False))


def _ssspy_ilrma(spectrogram: Complex, iterations: int, outputs: int) -> Complex:
    from ssspy.bss.ilrma import GaussILRMA  # noqa: PLC0415

    method = GaussILRMA(n_basis=BASES, record_loss=False, rng=np.random.default_rng(SEED))
    return np.asarray(method(spectrogram, n_iter=iterations, initial_call=False))


def _ssspy_fastmnmf(spectrogram: Complex, iterations: int, outputs: int) -> Complex:
    from ssspy.bss.mnmf import FastGaussMNMF  # noqa: PLC0415

    method = FastGaussMNMF(n_basis=BASES, n_sources=outputs, record_loss=False, rng=np.random.default_rng(SEED))
    return np.asarray(method(spectrogram, n_iter=iterations, initial_call=False))
