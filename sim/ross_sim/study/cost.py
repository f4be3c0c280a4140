"""What the front end costs on one core: `python -m ross_sim.study.cost`.

Everything in one run on the same recording (three talkers, S1, noise at 15 dB): medians of CPU seconds per second of
audio. Our AuxIVA and that of pyroomacoustics get the same spectrogram, start (the identity), number of iterations and
contrast (Gauss); both outputs are projected back and scored by the mean SI-SDR of their best match to the groups.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import click
import numpy as np
import pyroomacoustics as pra
from threadpoolctl import threadpool_limits

from ross_payload.dsp import duet, gaussian, iva
from ross_payload.dsp.covariance import outer
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.stft import Stft, band
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Complex, Real
from ross_sim.study.rooms import SETTINGS
from ross_sim.study.separation import (
    FRAME,
    HOP,
    RATE,
    RUN,
    aligned_heading,
    layouts,
    load_voices,
    record,
    scene_of,
)

ITERATIONS = 15


def cpu_seconds(call: Callable[[], object], repeats: int) -> float:
    """Median CPU time [s] of a call after one that does not count."""
    call()
    times = []
    for _ in range(repeats):
        before = time.process_time()
        call()
        times.append(time.process_time() - before)
    return median(times)


def ours(spectrogram: Complex, frequencies: Real) -> Complex:
    """Our AuxIVA from the identity, projected back, (2, n_freqs, n_frames)."""
    observed = outer(spectrogram).astype(np.float32)
    use = band(frequencies, iva.LOW, iva.HIGH).astype(float)
    rows = iva.demix(observed, use, iva.start_from(frequencies, None), ITERATIONS)
    return np.stack([rows[:, k, :1] * spectrogram[0] + rows[:, k, 1:] * spectrogram[1] for k in range(2)])


def theirs(spectrogram: Complex) -> Complex:
    """AuxIVA of pyroomacoustics on the same data, projected back, (2, n_freqs, n_frames)."""
    axes = (2, 1, 0)  # theirs is (n_frames, n_freqs, n_channels)
    separated = pra.bss.auxiva(spectrogram.transpose(axes), n_iter=ITERATIONS, proj_back=True, model="gauss")
    return np.asarray(separated.transpose(axes))


def quality(outputs: Complex, stft: Stft, reference: Real) -> float:
    """SI-SDR [dB] of the output that is nearest to the reference."""
    return max(si_sdr(stft.synthesise(output, reference.size), reference) for output in outputs)


@click.command()
@click.option("--speech", type=click.Path(path_type=Path), default=Path("../shared/speech"), show_default=True)
@click.option("--repeats", type=click.IntRange(min=1), default=5, show_default=True)
@click.option("--seed", type=int, default=0, show_default=True)
def main(speech: Path, repeats: int, seed: int) -> None:
    """Print CPU seconds per second of audio, and AuxIVA against the library's."""
    with threadpool_limits(1):
        try:
            voices = load_voices(speech)[:3]
        except ConfigError as error:
            raise click.ClickException(str(error)) from error
        rng, stft = np.random.default_rng(seed), Stft(RATE, FRAME, HOP)
        azimuths = layouts(3, 0, rng)[0]
        recording = record(voices, azimuths, 0, aligned_heading(azimuths, 0), SETTINGS["S1"], rng=rng)
        spectrogram = stft.analyse(recording.mixture)
        scene = scene_of(recording, stft, known_noise=True)
        calls: dict[str, Callable[[], object]] = {
            "STFT, two channels": lambda: stft.analyse(recording.mixture),
            "DUET": lambda: duet.separator.batch(spectrogram, scene),
            "AuxIVA, separator": lambda: iva.separator.batch(spectrogram, scene),
            "local Gaussian, K = 3": lambda: gaussian.separator.batch(spectrogram, scene),
            f"AuxIVA alone, {ITERATIONS} iterations": lambda: ours(spectrogram, stft.frequencies),
            f"pyroomacoustics, {ITERATIONS} iterations": lambda: theirs(spectrogram),
        }
        costs = [cpu_seconds(call, repeats) / RUN for call in calls.values()]
        for name, cost in zip(calls, costs, strict=True):
            click.echo(f"{name:32s} {cost:.4f} s/s")
        gained = quality(ours(spectrogram, stft.frequencies), stft, recording.reference)
        gained -= quality(theirs(spectrogram), stft, recording.reference)
        click.echo(f"AuxIVA: {costs[-1] / costs[-2]:.1f} times faster, {gained:+.1f} dB SI-SDR")


if __name__ == "__main__":
    main()
