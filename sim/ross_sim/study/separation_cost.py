"""What separating costs on one core, against other libraries and as the task grows.

`python -m ross_sim.study.separation_cost` measures it.

Everything in one run, on one numeric thread: medians of CPU seconds per second of audio, and beside them the SI-SDRi on
the same mixtures. Each mixture has three talkers, noise at 15 dB and the array at the target's alignment; of every
method's outputs the one nearest to the target is scored. Costs on another machine differ, their ratios hardly.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from statistics import mean, median

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
from ross_sim.study.script_errors import told_in_a_line
from ross_sim.study.workload import VOICE_RATE, Case, Peer, Work, cpu_seconds, prepared
from ross_sim.talkers.speech import load_folder

AXES = (2, 1, 0)  # pyroomacoustics: (n_frames, n_freqs, n_channels)
SEED = 0  # of the random starts
BASES = 2  # of ILRMA and FastMNMF per source, in both libraries
OURS = ("duet", "mvdr", "lcmv", "auxiva", "iva", "gaussian", "refined")
BLIND = f"auxiva, blind, {auxiva.ITERATIONS} iterations"
ITERATIONS = (auxiva.ITERATIONS, 40, 50)  # of AuxIVA, ILRMA and FastMNMF, in every library
ROOMS, TARGETS = ("S1", "S2"), (0, 1)  # of the mixtures on which methods are compared
PEERS = 1  # repeats of the slow ones, per mixture
GROWTH: dict[str, tuple[Case, ...]] = {
    "K": tuple(Case(n_sources=k) for k in (2, 3, 4, 5, 6)),
    "room": tuple(Case(setting=setting) for setting in ("S1", "S2", "S3")),
    "rate [Hz]": tuple(Case(rate=rate) for rate in (16000, 24000, 48000)),
    "duration [s]": tuple(Case(seconds=seconds) for seconds in (3.0, 10.0, 30.0, 60.0)),
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


@dataclass(frozen=True, slots=True)
class Cost:
    """One method on one mixture."""

    method: str
    setting: str
    seconds: float  # of CPU per second of audio
    gain: float  # SI-SDRi [dB]


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


def measured(method: str, call: Callable[[Work], Complex], work: Work, case: Case, repeats: int) -> Cost:
    """Time one method on one mixture and score it."""
    outputs: list[Complex] = []
    seconds = cpu_seconds(lambda: outputs.append(call(work)), repeats)
    return Cost(method, case.setting, seconds / case.seconds, work.gain(outputs[0]))


def compared(voices: Sequence[Real], repeats: int, seed: int) -> list[Cost]:
    """Every method on every mixture, one after the other so that all meet the machine in the same state."""
    methods: list[tuple[str, Callable[[Work], Complex], int]] = [(n, partial(ours, n), repeats) for n in OURS]
    methods.append((BLIND, blind_auxiva, repeats))
    methods += [
        (f"{peer.library}: {peer.method}, {peer.iterations} iterations", partial(theirs, peer), PEERS)
        for peer in peers(*ITERATIONS)
    ]
    costs = []
    for case in (Case(setting=room, target=target, seed=seed) for room in ROOMS for target in TARGETS):
        work = prepared(case, voices)
        ours("gaussian", work)  # warms up
        costs += [measured(name, call, work, case, count) for name, call, count in methods]
    return costs


def comparison(costs: Iterable[Cost]) -> list[str]:
    """Lines of the table of `compared`; a ratio is the median of the ratios on each mixture.

    >>> both = [Cost("gaussian", "S1", 0.02, 15.0), Cost(BLIND, "S1", 0.01, 5.0), Cost("x", "S1", 0.2, 7.0)]
    >>> comparison(both)[-1]
    '| x | 0.2000 | 10.0 | 20.0 | 7.0 |'
    """
    by_method: dict[str, list[Cost]] = {}
    for cost in costs:
        by_method.setdefault(cost.method, []).append(cost)
    rooms = sorted({cost.setting for rows in by_method.values() for cost in rows})
    lines = [f"| method | CPU s/s | / `gaussian` | / `auxiva`, blind | {' | '.join(f'{r} [dB]' for r in rooms)} |"]
    lines.append("| --- " * (4 + len(rooms)) + "|")
    for method, rows in by_method.items():
        ratios = [_ratio(rows, by_method[base]) for base in ("gaussian", BLIND)]
        gains = [mean(row.gain for row in rows if row.setting == room) for room in rooms]
        cells = [f"{median(row.seconds for row in rows):.4f}", *(f"{ratio:.1f}" for ratio in ratios)]
        lines.append(f"| {' | '.join([method, *cells, *(f'{gain:.1f}' for gain in gains)])} |")
    return lines


def _ratio(rows: Sequence[Cost], base: Sequence[Cost]) -> float:
    return median(row.seconds / other.seconds for row, other in zip(rows, base, strict=True))


def growth(title: str, cases: Sequence[Case], voices: Sequence[Real], repeats: int, seed: int) -> list[str]:
    """Lines of one table: what every part costs [CPU s per s of audio] as one number of the task grows."""
    lines = [f"| {title} | simulation | STFT | {' | '.join(OURS)} |", "| --- " * (3 + len(OURS)) + "|"]
    for case in cases:
        works = [prepared(replace(case, seed=seed), voices) for _ in range(repeats)]
        work = works[0]
        calls = [partial(work.stft.analyse, work.mixture), *(partial(ours, name, work) for name in OURS)]
        costs = [median(each.simulation for each in works), *(cpu_seconds(call, repeats) for call in calls)]
        cells = [f"{cost / case.seconds:.4f}" for cost in costs]
        lines.append(f"| {' | '.join([label(title, case), *cells])} |")
    return lines


def label(title: str, case: Case) -> str:
    """Name of a row.

    >>> label("rate [Hz]", Case(rate=16000))
    '16000'
    """
    return {
        "K": f"{case.n_sources}",
        "room": case.setting,
        "rate [Hz]": f"{case.rate}",
        "duration [s]": f"{case.seconds:g}",
    }[title]


@click.command()
@click.option("--speech", type=click.Path(path_type=Path), default=Path("../shared/speech"), show_default=True)
@click.option("--repeats", type=click.IntRange(min=1), default=3, show_default=True)
@click.option("--seed", type=NATURAL, default=0, show_default=True)
def main(speech: Path, repeats: int, seed: int) -> None:
    """Print one table of methods and one for everything that makes the task grow."""
    with threadpool_limits(1), np.errstate(all="ignore"):
        with told_in_a_line():
            voices = [voice.speech for voice in load_folder(speech, VOICE_RATE)]
            need = max(case.n_sources for cases in GROWTH.values() for case in cases)
            if len(voices) < need:
                raise ConfigError(f"{speech}: expected {need} talkers, got {len(voices)}")
        lines = comparison(compared(voices, repeats, seed))
        click.echo("\n".join(lines))
        for title, cases in GROWTH.items():
            click.echo("")
            for line in growth(title, cases, voices, repeats, seed):
                click.echo(line)


if __name__ == "__main__":
    main()
