"""How well each separator does in the paper's rooms: `python -m ross_sim.study.separation`.

K talkers of equal power at microphone 1 stand around the array in the middle of a room (`rooms`); white noise is 15 dB
below the mixture. Every talker is the target once, with the array at its own alignment and with every azimuth known;
its reference is itself alone at microphone 1. The table gives the mean SI-SDRi. Columns are separators
(`--separators duet mvdr ilrma`) or oracles, which are given every source and the noise (`irm mwf tvmwf`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import click
import numpy as np
from scipy.signal import fftconvolve
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.angles import Real, difference
from ross_payload.dsp.gain import best_headings
from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError, RossError
from ross_payload.interfaces import Scene, Separator
from ross_sim.speech import load_folder
from ross_sim.study.oracles import ORACLES, Oracle
from ross_sim.study.rooms import PLANES, SETTINGS, SPACING, SPEED_OF_SOUND, Setting

PAPER_DEG = (170.0, 70.0, -50.0, -120.0, 10.0)  # the layout of the prototypes
VOICES = ("ls3005", "ls3331", "ls2414", "ls3080", "ls533")
SEPARATORS = ("duet", "auxiva", "gaussian")
NOISE_BLIND = frozenset({"mvdr", "lcmv", "iva", "ilrma", "fastmnmf2"})  # never look at the noise PSD
APART = np.deg2rad(25.0)
RULES = ("best", "paper", "anywhere")  # where the array points
SNR_DB = 15.0  # mixture over noise, at microphone 1
RATE, FRAME, HOP = 24000, 2048, 512
LEAD_IN, RUN = 2.0, 10.0  # [s]


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """One mixture at one alignment."""

    mixture: Real  # (2, n)
    lead_in: Real  # noise alone, (2, m)
    images: Real  # every talker alone at both microphones, (n_sources, 2, n)
    tau: Real  # [s], (n_sources,)
    target: int

    @property
    def reference(self) -> Real:
        """The target alone at microphone 1, (n,)."""
        return np.asarray(self.images[self.target, 0])


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
    """Heading [rad] by the paper: the interferers' bisector for K = 3, else the argmax of min_k |tau_i - tau_k|.

    >>> round(float(np.rad2deg(aligned_heading(np.deg2rad([0.0, 100.0, 40.0]), target=0))), 6)
    70.0
    """
    others = np.delete(azimuths, target)
    if others.size == 2:
        return float(others.mean())
    headings = np.deg2rad(np.arange(0.0, 180.0, 0.5))
    isolation = np.abs(np.cos(azimuths[target] - headings) - np.cos(others[:, None] - headings)).min(axis=0)
    return float(headings[isolation.argmax()])


def heading_for(rule: str, azimuths: Real, target: int, setting: Setting, rng: np.random.Generator) -> float:
    """Heading [rad] for a target by one of `RULES`; the explorer is taken to tell the open from reverberation."""
    if rule == "best":
        return float(best_headings(azimuths, directness=float(setting.t60 == 0))[target])
    return aligned_heading(azimuths, target) if rule == "paper" else float(rng.uniform(0, np.pi))


def record(
    voices: Sequence[Real],
    azimuths: Real,
    target: int,
    heading: float,
    setting: Setting,
    *,
    rng: np.random.Generator,
    rate: int = RATE,
) -> Recording:
    """Simulate one recording of ``voices`` (n,) each at ``azimuths`` [rad] with the array at ``heading`` [rad].

    Where exactly the talkers of a true room stand depends on the azimuths alone, so that every target and heading of a
    layout has the same room.
    """
    places = setting.places(azimuths, np.random.default_rng(np.abs(azimuths * 1e6).astype(int)))
    responses = setting.responses(places, [heading], rate)[0]
    n = len(voices[0])
    images = np.stack([fftconvolve(voice[None], responses[:, k], axes=1)[:, :n] for k, voice in enumerate(voices)])
    images /= np.sqrt((images[:, :1] ** 2).mean(axis=2, keepdims=True))
    clean = images.sum(axis=0)
    sigma = np.sqrt((clean[0] ** 2).mean() * 10 ** (-SNR_DB / 10))
    mixture = clean + sigma * rng.standard_normal(clean.shape)
    lead_in = sigma * rng.standard_normal((2, round(LEAD_IN * rate)))
    tau = tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND)
    return Recording(mixture.astype(np.float32), lead_in.astype(np.float32), images, tau, target)


def scene_of(recording: Recording, stft: Stft, known_noise: bool) -> Scene:
    """What the separator may know; the noise PSD from the lead-in, or nothing about it."""
    psd = quiet_psd(stft.analyse(recording.lead_in), stft.analyse(recording.mixture)) if known_noise else None
    return Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, recording.tau.size, recording.tau, psd, hop=stft.hop)


def improvement(separator: Separator, recording: Recording, known_noise: bool = True) -> float:
    """SI-SDRi [dB] of the group that holds the target."""
    stft = Stft(RATE, FRAME, HOP)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise))
    index = next(i for i, members in enumerate(groups.members) if recording.target in members)
    voice = stft.synthesise(groups.signals[index], recording.mixture.shape[1])
    return si_sdri(voice, recording.mixture[0], recording.reference)


def bound(oracle: Oracle, recording: Recording) -> float:
    """SI-SDRi [dB] of the target by someone who knows every talker and the noise."""
    noise = recording.mixture - recording.images.sum(axis=0)
    voice = oracle(recording.images, noise, Stft(RATE, FRAME, HOP))[recording.target]
    return si_sdri(voice, recording.mixture[0], recording.reference)


def column(name: str) -> Callable[[Recording], list[float]]:
    """What a column measures: SI-SDRi [dB] with the noise PSD known and unknown, or once where it does not matter.

    Raises
    ------
    PluginError
        When the name is neither an oracle nor a separator, or an extra is missing.
    """
    if name in ORACLES:
        return lambda recording: [bound(ORACLES[name], recording)]
    separator: Separator = plugins.load("ross_payload.separators", name)
    knowledge = (True,) if name in NOISE_BLIND else (True, False)
    return lambda recording: [improvement(separator, recording, known) for known in knowledge]


def load_voices(folder: Path, names: Sequence[str] = VOICES) -> list[Real]:
    """The first 10 s of the talkers of these names; no names: of every talker in the folder.

    Raises
    ------
    ConfigError
        When one of them is missing or too short.
    """
    voices = {voice.name: voice.speech for voice in load_folder(folder, RATE)}
    n = round(RUN * RATE)
    for name in names or voices:
        if name not in voices or voices[name].size < n:
            raise ConfigError(f"{folder}: wanted {RUN:g} s of the talker {name}")
    return [voices[name][:n] for name in names or voices]


def recordings(
    voices: Sequence[Real], n_sources: int, setting: Setting, count: int, seed: int, *, rule: str = "best"
) -> Iterator[Recording]:
    """Every talker of every layout as the target; noise, layouts and casts do not depend on the room.

    With more than five voices every layout draws its own cast. The heading goes by one of `RULES`.
    """
    for index, azimuths in enumerate(layouts(n_sources, count, np.random.default_rng(seed))):
        cast = list(voices)
        if len(voices) > len(VOICES):
            cast = [voices[i] for i in np.random.default_rng([seed, index]).permutation(len(voices))]
        for target in range(n_sources):
            rng = np.random.default_rng([seed, index, target])
            anywhere = np.random.default_rng([seed, index, target, 1])
            heading = heading_for(rule, azimuths, target, setting, anywhere)
            yield record(cast[:n_sources], azimuths, target, heading, setting, rng=rng)


def measure(
    voices: Sequence[Real],
    n_sources: int,
    setting: Setting,
    count: int,
    seed: int,
    *,
    names: Sequence[str] = SEPARATORS,
    rule: str = "best",
) -> dict[str, list[float]]:
    """Mean SI-SDRi [dB] per column: with the noise PSD known and unknown, or once where it does not matter."""
    columns = {name: column(name) for name in names}
    scores: dict[str, list[list[float]]] = {name: [] for name in columns}
    for recording in recordings(voices, n_sources, setting, count, seed, rule=rule):
        for name, score in columns.items():
            scores[name].append(score(recording))
    return {name: np.mean(rows, axis=0).tolist() for name, rows in scores.items()}


def row(setting: str, n_sources: int, scores: Mapping[str, Sequence[float]]) -> str:
    """One line of the table.

    >>> row("S1", 3, {"duet": [12.34, 11.0], "irm": [15.0]})
    'S1    K3   12.3/11.0          15.0'
    """
    cells = [
        f"{known[0]:6.1f}/{known[1]:<5.1f}" if len(known) > 1 else f"{known[0]:12.1f}" for known in scores.values()
    ]
    return f"{setting:5} K{n_sources} " + " ".join(cells)


@click.command()
@click.argument("more", nargs=-1, metavar="")
@click.option("--separators", "first", metavar="NAME...", help="Columns, instead of duet auxiva gaussian.")
@click.option("--rooms", default=",".join(PLANES), show_default=True, help=f"Of {','.join(SETTINGS)}.")
@click.option("--talkers", type=click.Choice(["five", "all"]), default="five", show_default=True)
@click.option(
    "--heading",
    "rule",
    type=click.Choice(RULES),
    default="best",
    show_default=True,
    help="Best predicted gain, the paper's, or random.",
)
@click.option("--speech", type=click.Path(path_type=Path), default=Path("../shared/speech"), show_default=True)
@click.option("--layouts", "count", type=click.IntRange(min=0), default=5, show_default=True, help="Random layouts.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("--quick", is_flag=True, help="The paper's layout and K = 3 alone.")
@click.option("--json", "out", type=click.Path(path_type=Path), help="Write the table here too.")
def main(
    *,
    more: tuple[str, ...],
    first: str | None,
    rooms: str,
    talkers: str,
    rule: str,
    speech: Path,
    count: int,
    seed: int,
    quick: bool,
    out: Path | None,
) -> None:
    """Print the mean SI-SDRi [dB] with the noise PSD known from a lead-in / unknown, true azimuths."""
    if more and first is None:
        raise click.UsageError(f"columns are named after --separators, found {' '.join(more)}")
    unknown = [name for name in rooms.split(",") if name not in SETTINGS]
    if unknown:
        raise click.UsageError(f"room '{unknown[0]}' is unknown; there are: {', '.join(SETTINGS)}")
    names = SEPARATORS if first is None else tuple(dict.fromkeys((first, *more)))
    table: dict[str, dict[str, list[float]]] = {}
    click.echo("SI-SDRi [dB], noise PSD from lead-in / unknown\n         " + " ".join(f"{name:>12}" for name in names))
    try:
        voices = load_voices(speech, () if talkers == "all" else VOICES)
        for name, n_sources in product(rooms.split(","), (3,) if quick else (3, 4, 5)):
            with threadpool_limits(1):
                scores = measure(voices, n_sources, SETTINGS[name], 0 if quick else count, seed, names=names, rule=rule)
            table[f"{name} K{n_sources}"] = scores
            click.echo(row(name, n_sources, scores))
    except RossError as error:
        raise click.ClickException(str(error)) from error
    if out:
        out.write_text(json.dumps({"seed": seed, "layouts": count, "si_sdri_db": table}, indent=2) + "\n")


if __name__ == "__main__":
    main()
