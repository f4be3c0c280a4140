"""How well each separator does in the paper's rooms: `python -m ross_sim.study.separation`.

K talkers of equal power at microphone 1 stand 2.5 m from the array in the centre of a room of 10 x 10 m; white noise
is 15 dB below the mixture. Every talker is the target once, with the array at its own alignment and with every azimuth
known; its reference is itself alone at microphone 1. The table gives the mean SI-SDRi.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from scipy.signal import fftconvolve
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.angles import Real, difference
from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Scene, Separator
from ross_sim.room import impulse_responses
from ross_sim.speech import load_folder

SETTINGS = {"S1": 0.0, "S2": 0.45, "S3": 0.7}  # the paper's nominal T60 [s]
PAPER_DEG = (170.0, 70.0, -50.0, -120.0, 10.0)  # the layout of the prototypes
VOICES = ("ls3005", "ls3331", "ls2414", "ls3080", "ls533")
SEPARATORS = ("duet", "auxiva", "gaussian")
APART = np.deg2rad(25.0)
ROOM, CENTRE, DISTANCE = (10.0, 10.0), (5.0, 5.0), 2.5  # [m]
SPACING, SPEED_OF_SOUND = 0.05, 343.0
SNR_DB = 15.0  # mixture over noise, at microphone 1
RATE, FRAME, HOP = 24000, 2048, 512
LEAD_IN, RUN = 2.0, 10.0  # [s]


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """One mixture at one alignment."""

    mixture: Real  # (2, n)
    lead_in: Real  # noise alone, (2, m)
    reference: Real  # the target alone at microphone 1, (n,)
    tau: Real  # [s], (n_sources,)
    target: int


def layouts(n_sources: int, count: int, rng: np.random.Generator) -> list[Real]:
    """The paper's layout and ``count`` random ones, at least 25 deg apart: azimuths [rad], (n_sources,) each."""
    found = [np.deg2rad(PAPER_DEG[:n_sources])]
    while len(found) <= count:
        azimuths = rng.uniform(-np.pi, np.pi, n_sources)
        gaps = np.abs(difference(azimuths[:, None], azimuths)) + 2 * np.pi * np.eye(n_sources)
        if gaps.min() >= APART:
            found.append(azimuths)
    return found


def aligned_heading(azimuths: Real, target: int) -> float:
    """Heading [rad] for a target: the interferers' bisector for K = 3, else the argmax of min_k |tau_i - tau_k|.

    >>> round(float(np.rad2deg(aligned_heading(np.deg2rad([0.0, 100.0, 40.0]), target=0))), 6)
    70.0
    """
    others = np.delete(azimuths, target)
    if others.size == 2:
        return float(others.mean())
    headings = np.deg2rad(np.arange(0.0, 180.0, 0.5))
    isolation = np.abs(np.cos(azimuths[target] - headings) - np.cos(others[:, None] - headings)).min(axis=0)
    return float(headings[isolation.argmax()])


def record(
    voices: Sequence[Real], azimuths: Real, target: int, heading: float, t60: float, *, rng: np.random.Generator
) -> Recording:
    """Simulate one recording of ``voices`` (n,) each at ``azimuths`` [rad] with the array at ``heading`` [rad]."""
    places = np.array(CENTRE) + DISTANCE * np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    responses = impulse_responses(ROOM, t60, RATE, CENTRE, SPACING, places, [heading], SPEED_OF_SOUND)[0]
    n = len(voices[0])
    images = np.stack([fftconvolve(voice[None], responses[:, k], axes=1)[:, :n] for k, voice in enumerate(voices)])
    images /= np.sqrt((images[:, :1] ** 2).mean(axis=2, keepdims=True))
    clean = images.sum(axis=0)
    sigma = np.sqrt((clean[0] ** 2).mean() * 10 ** (-SNR_DB / 10))
    mixture = clean + sigma * rng.standard_normal(clean.shape)
    lead_in = sigma * rng.standard_normal((2, round(LEAD_IN * RATE)))
    tau = tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND)
    return Recording(mixture.astype(np.float32), lead_in.astype(np.float32), images[target, 0], tau, target)


def scene_of(recording: Recording, stft: Stft, known_noise: bool) -> Scene:
    """What the separator may know; the noise PSD from the lead-in, or nothing about it."""
    psd = quiet_psd(stft.analyse(recording.lead_in), stft.analyse(recording.mixture)) if known_noise else None
    return Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, recording.tau.size, recording.tau, psd)


def improvement(separator: Separator, recording: Recording, known_noise: bool = True) -> float:
    """SI-SDRi [dB] of the group that holds the target."""
    stft = Stft(RATE, FRAME, HOP)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise))
    index = next(i for i, members in enumerate(groups.members) if recording.target in members)
    voice = stft.synthesise(groups.signals[index], recording.mixture.shape[1])
    return si_sdri(voice, recording.mixture[0], recording.reference)


def load_voices(folder: Path) -> list[Real]:
    """The first 10 s of the five talkers.

    Raises
    ------
    ConfigError
        When one of them is missing or too short.
    """
    voices = {voice.name: voice.speech for voice in load_folder(folder, RATE)}
    n = round(RUN * RATE)
    for name in VOICES:
        if name not in voices or voices[name].size < n:
            raise ConfigError(f"{folder}: wanted {RUN:g} s of the talker {name}")
    return [voices[name][:n] for name in VOICES]


def recordings(voices: Sequence[Real], n_sources: int, t60: float, count: int, seed: int) -> Iterator[Recording]:
    """Every talker of every layout as the target, at its alignment; noise and layouts do not depend on T60."""
    for index, azimuths in enumerate(layouts(n_sources, count, np.random.default_rng(seed))):
        for target in range(n_sources):
            heading = aligned_heading(azimuths, target)
            rng = np.random.default_rng([seed, index, target])
            yield record(voices[:n_sources], azimuths, target, heading, t60, rng=rng)


def measure(voices: Sequence[Real], n_sources: int, t60: float, count: int, seed: int) -> dict[str, list[float]]:
    """Mean SI-SDRi [dB] per separator, with the noise PSD known and unknown."""
    separators: dict[str, Separator] = {name: plugins.load("ross_payload.separators", name) for name in SEPARATORS}
    scores: dict[str, list[list[float]]] = {name: [] for name in SEPARATORS}
    for recording in recordings(voices, n_sources, t60, count, seed):
        for name, separator in separators.items():
            scores[name].append([improvement(separator, recording, known) for known in (True, False)])
    return {name: np.mean(rows, axis=0).tolist() for name, rows in scores.items()}


def row(setting: str, n_sources: int, scores: Mapping[str, Sequence[float]]) -> str:
    """One line of the table.

    >>> row("S1", 3, {"duet": [12.34, 11.0]})
    'S1 K3   12.3/11.0 '
    """
    return f"{setting} K{n_sources} " + " ".join(f"{known:6.1f}/{unknown:<5.1f}" for known, unknown in scores.values())


@click.command()
@click.option("--speech", type=click.Path(path_type=Path), default=Path("../shared/speech"), show_default=True)
@click.option("--layouts", "count", type=click.IntRange(min=0), default=5, show_default=True, help="Random layouts.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--quick", is_flag=True, help="The paper's layout and K = 3 alone.")
@click.option("--json", "out", type=click.Path(path_type=Path), help="Write the table here too.")
def main(speech: Path, count: int, seed: int, quick: bool, out: Path | None) -> None:
    """Print the mean SI-SDRi [dB] with the noise PSD known from a lead-in / unknown, true azimuths, aligned."""
    table: dict[str, dict[str, list[float]]] = {}
    with threadpool_limits(1):
        try:
            voices = load_voices(speech)
        except ConfigError as error:
            raise click.ClickException(str(error)) from error
        click.echo("SI-SDRi [dB], noise PSD from lead-in / unknown\n      " + " ".join(f"{s:>12}" for s in SEPARATORS))
        for setting, t60 in SETTINGS.items():
            for n_sources in (3,) if quick else (3, 4, 5):
                scores = measure(voices, n_sources, t60, 0 if quick else count, seed)
                table[f"{setting} K{n_sources}"] = scores
                click.echo(row(setting, n_sources, scores))
    if out:
        out.write_text(json.dumps({"seed": seed, "layouts": count, "si_sdri_db": table}, indent=2) + "\n")


if __name__ == "__main__":
    main()
