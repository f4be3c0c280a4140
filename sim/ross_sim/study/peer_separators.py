"""The separators of other libraries, called as they are: same spectrogram in, outputs at microphone 1 out.

Every call takes a spectrogram (2, n_freqs, n_frames), a number of iterations and a number of outputs, and returns
(n_outputs, n_freqs, n_frames). ssspy comes with the dependency group ``bench`` (`pip install --group bench`); without
it its rows are missing. Its FastMNMF is the first one (Sekiguchi et al. 2019), that of pyroomacoustics the second
(2020).
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pyroomacoustics as pra

from ross_payload.interfaces import Complex
from ross_sim.study.baselines import library
from ross_sim.study.workload import Peer

AXES = (2, 1, 0)  # pyroomacoustics: (n_frames, n_freqs, n_channels)
SEED = 0  # of the random starts
BASES = 2  # of ILRMA and FastMNMF per source, in both libraries


def peers(auxiva: int, ilrma: int, mnmf: int) -> tuple[Peer, ...]:
    """AuxIVA, ILRMA and FastMNMF of both libraries, with so many iterations each; ssspy only where it is installed."""
    found = [
        Peer("pyroomacoustics", "AuxIVA", auxiva, _pra_auxiva),
        Peer("pyroomacoustics", "ILRMA", ilrma, _pra_ilrma),
        Peer("pyroomacoustics", "FastMNMF2", mnmf, _pra_fastmnmf2),
    ]
    if find_spec("ssspy") is not None:
        found += [
            Peer("ssspy", "AuxIVA", auxiva, _ssspy_auxiva),
            Peer("ssspy", "ILRMA", ilrma, _ssspy_ilrma),
            Peer("ssspy", "FastMNMF", mnmf, _ssspy_fastmnmf),
        ]
    return tuple(found)


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
