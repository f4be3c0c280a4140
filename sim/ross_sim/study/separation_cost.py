"""What separating costs on one core, against other libraries and as the task grows.

`python -m ross_sim.study.separation_cost` measures it.

Everything in one run, on one numeric thread: medians of CPU seconds per second of audio, and beside them the SI-SDRi on
the same mixtures. Each mixture has three talkers, noise at 15 dB and the array at the target's alignment; of every
method's outputs the one nearest to the target is scored. Costs on another machine differ, their ratios hardly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from statistics import median

import click
import numpy as np
import pyroomacoustics as pra
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.dsp.covariance import outer
from ross_payload.dsp.stft import band
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Real
from ross_payload.separation import auxiva
from ross_sim.study.baselines import library
from ross_sim.study.option_types import NATURAL
from ross_sim.study.rows.cost_rows import BLIND, CostRow, costs, growth
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.scenes.workload import VOICE_RATE, Case, Peer, Work, cpu_seconds, prepared
from ross_sim.study.script_errors import expect_writable, told_in_a_line, write_result
from ross_sim.talkers.speech import load_folder

AXES = (2, 1, 0)  # pyroomacoustics: (n_frames, n_freqs, n_channels)
SEED = 0  # of the random starts
BASES = 2  # of ILRMA and FastMNMF per source, in both libraries
OURS = ("duet", "mvdr", "lcmv", "auxiva", "iva", "gaussian", "refined")
ITERATIONS = (auxiva.ITERATIONS, 40, 50)  # of AuxIVA, ILRMA and FastMNMF, in every library
ROOMS, TARGETS = ("S1", "S2"), (0, 1)  # of the mixtures on which methods are compared
PEERS = 1  # repeats of the slow ones, per mixture
GROWTH: dict[str, tuple[Case, ...]] = {
    "K": tuple(Case(n_sources=k) for k in (2, 3, 4, 5, 6)),
    "room": tuple(Case(setting=setting) for setting in ("S1", "S2", "S3")),
    "rate": tuple(Case(rate=rate) for rate in (16000, 24000, 48000)),
    "duration": tuple(Case(seconds=seconds) for seconds in (3.0, 10.0, 30.0, 60.0)),
}


def peers(auxiva: int, ilrma: int, mnmf: int) -> tuple[Peer, ...]:
    """AuxIVA, ILRMA and FastMNMF of both libraries, with so many iterations each; ssspy only where it is installed.

    ssspy comes with the dependency group ``bench``. Its FastMNMF is the first one (Sekiguchi et al. 2019), that of
    pyroomacoustics the second (2020). Each takes a spectrogram (2, n_freqs, n_frames), a number of iterations and one
    of outputs, and returns outputs at microphone 1, (n_outputs, n_freqs, n_frames).
    """
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


def blind_auxiva(work: Work) -> Complex:
    """Our AuxIVA from the identity and without the Wiener gain, as the libraries have it, (2, n_freqs, n_frames)."""
    spectrogram, frequencies = work.spectrogram, work.stft.frequencies
    observed = outer(spectrogram).astype(np.float32)
    use = band(frequencies, auxiva.LOW, auxiva.HIGH).astype(float)
    rows = auxiva.demix(observed, use, auxiva.start_from(frequencies, None), ITERATIONS[0])
    return np.stack([rows[:, k, :1] * spectrogram[0] + rows[:, k, 1:] * spectrogram[1] for k in range(2)])


def ours(name: str, work: Work) -> Complex:
    """Return what one of our separators makes of a mixture, (n_groups, n_freqs, n_frames)."""
    signals: Complex = plugins.load("ross_payload.separators", name).batch(work.spectrogram, work.scene).signals
    return signals


def theirs(peer: Peer, work: Work) -> Complex:
    """Return what another library makes of a mixture, two outputs, (2, n_freqs, n_frames).

    In double precision, which ssspy computes in anyway and which costs pyroomacoustics next to nothing.
    """
    return peer.call(work.spectrogram.astype(np.complex128), peer.iterations, 2)


def measured(method: str, call: Callable[[Work], Complex], work: Work, case: Case, repeats: int) -> CostRow:
    """Time one method on one mixture and score it."""
    outputs: list[Complex] = []
    seconds = cpu_seconds(lambda: outputs.append(call(work)), repeats)
    return replace(row_of(method, case, None, seconds), si_sdri_db=round(work.gain(outputs[0]), 3))


def row_of(method: str, case: Case, growing: str | None, seconds: float) -> CostRow:
    """The row of so much CPU time [s]."""
    return CostRow(
        method, case.setting, case.n_sources, case.rate, case.seconds, case.target, case.seed, growing,
        round(seconds / case.seconds, 5),
    )  # fmt: skip


def compared(voices: Sequence[Real], repeats: int, seed: int) -> list[CostRow]:
    """Every method on every mixture, one after the other so that all meet the machine in the same state."""
    methods: list[tuple[str, Callable[[Work], Complex], int]] = [(n, partial(ours, n), repeats) for n in OURS]
    methods.append((BLIND, blind_auxiva, repeats))
    methods += [
        (f"{peer.library}: {peer.method}, {peer.iterations} iterations", partial(theirs, peer), PEERS)
        for peer in peers(*ITERATIONS)
    ]
    rows = []
    for case in (Case(setting=room, target=target, seed=seed) for room in ROOMS for target in TARGETS):
        work = prepared(case, voices)
        ours("gaussian", work)  # warms up
        rows += [measured(name, call, work, case, count) for name, call, count in methods]
    return rows


def grown(growing: str, cases: Sequence[Case], voices: Sequence[Real], repeats: int, seed: int) -> list[CostRow]:
    """What every part costs as one number of the task grows."""
    rows = []
    for case in (replace(case, seed=seed) for case in cases):
        works = [prepared(case, voices) for _ in range(repeats)]
        work = works[0]
        rows.append(row_of("simulation", case, growing, median(each.simulation for each in works)))
        calls = {"STFT": partial(work.stft.analyse, work.mixture)} | {name: partial(ours, name, work) for name in OURS}
        rows += [row_of(name, case, growing, cpu_seconds(call, repeats)) for name, call in calls.items()]
    return rows


@click.command()
@click.option("--speech", type=click.Path(path_type=Path), default=Path("../shared/speech"), show_default=True)
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True)
@click.option("--seed", type=NATURAL, default=0, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), help="File for the rows (.csv), for `ross study table`.")
def main(speech: Path, repeats: int, seed: int, out: Path | None) -> None:
    """Print one table of methods and one for everything that makes the task grow."""
    with threadpool_limits(1), np.errstate(all="ignore"):
        with told_in_a_line():
            if out is not None:
                expect_writable(out)
            voices = [voice.speech for voice in load_folder(speech, VOICE_RATE)]
            need = max(case.n_sources for cases in GROWTH.values() for case in cases)
            if len(voices) < need:
                raise ConfigError(f"{speech}: expected {need} talkers, got {len(voices)}")
        rows = compared(voices, repeats, seed)
        for growing, cases in GROWTH.items():
            rows += grown(growing, cases, voices, repeats, seed)
    click.echo(f"{costs(rows).markdown()}\n{growth(rows).markdown()}")
    if out is not None:
        with told_in_a_line():
            write_result(out, as_csv(rows, CostRow))


if __name__ == "__main__":
    main()
