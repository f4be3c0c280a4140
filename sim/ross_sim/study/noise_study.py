"""How well talkers are found and separated in the noise of a vehicle: ``ross study noise``.

Every scene (`noise_scenes`) is explored at nine headings, 3 s each, after a lead-in of 2 s at the first one; then every
talker is the target once, at the heading that the plan chooses by the true azimuths, for 10 s. The noise goes on from
the lead-in through all of it. "All right" means that K is right and everybody within 10 degrees. The separator is told
the true delays and the noise that the lead-in and the run tell; what the white model makes of the same scenes stands
beside it. A lone talker is separated too: from the noise.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.alignment.plan import Turn, plan
from ross_payload.dsp.ego_noise import learnt
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Complex, Observation, Real, Samples, Scene
from ross_payload.localization.joint import Joint
from ross_payload.localization.joint_in_noise import JointInNoise
from ross_payload.mission.align import ROTORS as ROTORS_SHARE
from ross_payload.plugin_checks import load_separator
from ross_sim.study.exploration import FRAME, NEAR_DEG, matched
from ross_sim.study.mixtures import FRAME as LONG_FRAME
from ross_sim.study.mixtures import HOP, LEAD_IN, RATE, VOICES
from ross_sim.study.noise_scenes import HEADINGS, ROTORS, SENSOR_DB, NoiseScene, images_of, noise_of, recordings, scene
from ross_sim.study.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.talkers.speech import load_folder

RUN = 10.0  # [s]
SHORT, LONG = Stft(RATE, FRAME, FRAME // 4), Stft(RATE, LONG_FRAME, HOP)
FREE = Turn(base=0.0, joint=0.0, lower=-np.inf, upper=np.inf)


@dataclass(frozen=True, slots=True)
class Row:
    """One scene at one ratio: explored, or one target of it separated."""

    noise: str
    model: str  # learnt: covariances; white: without
    snr_db: float
    k: int
    layout: int
    seed: int
    target: int | None = None  # None: explored
    k_found: int | None = None
    within: int | None = None  # talkers found within 10 degrees
    si_sdr_in_db: float | None = None
    si_sdr_out_db: float | None = None

    @property
    def right(self) -> bool:
        """K is right and everybody is near."""
        return self.k_found == self.k == self.within


@dataclass(frozen=True, slots=True)
class Design:
    """What is measured."""

    kinds: tuple[str, ...]
    snrs: tuple[float, ...]
    layouts: int
    seed: int
    models: tuple[str, ...] = ("learnt", "white")
    separator: str = "refined"
    explore: bool = True
    separate: bool = True


def rows(design: Design, voices: Sequence[Samples], clips: Sequence[Samples]) -> Iterator[Row]:
    """Measure everything, scene by scene."""
    for kind in design.kinds:
        for snr in design.snrs:
            for k in (1, 2, 3):
                for layout in range(design.layouts):
                    key = [design.seed, k, layout]
                    made = scene(k, snr, kind, voices, clips=clips, key=key)
                    for model in design.models:
                        row = Row(kind, model, snr, k, layout, design.seed)
                        if design.explore:
                            yield explored(row, made)
                        if design.separate:
                            yield from separated(row, made, clips, design.separator)


def explored(row: Row, made: NoiseScene) -> Row:
    """Explore a scene."""
    joint = Joint(SPACING, SPEED_OF_SOUND)
    seen = observed(made) if row.model == "learnt" else None
    if seen is None:
        psd = quiet_psd(SHORT.analyse(made.lead_in), SHORT.analyse(made.heard[0]))
        heard = zip(made.heard, HEADINGS, strict=True)
        seen = [
            joint.observe(SHORT.analyse(x), SHORT.frequencies, float(h), psd, frame_period=SHORT.period)
            for x, h in heard
        ]
    estimate = joint.estimate(seen)
    within = 0 if not estimate.k else int((matched(made.azimuths, estimate)[0] <= NEAR_DEG).sum())
    return replace(row, k_found=estimate.k, within=within)


def observed(heard: NoiseScene) -> list[Observation] | None:
    """What the explorer observes at every heading; None where the lead-in teaches nothing."""
    explorer = JointInNoise(SPACING, SPEED_OF_SOUND)
    known = explorer.learn(SHORT.analyse(heard.lead_in), SHORT.frequencies, SHORT.period, float(HEADINGS[0]), ROTORS)
    if known is None:
        return None
    return [
        explorer.observe(SHORT.analyse(x), SHORT.frequencies, float(h), float(h), known, period=SHORT.period)
        for x, h in zip(heard.heard, HEADINGS, strict=True)
    ]


def separated(row: Row, made: NoiseScene, clips: Sequence[Samples], name: str) -> Iterator[Row]:
    """Separate every target at its own heading."""
    separator, estimate = (
        load_separator(name),
        Estimate(tuple(SourceEstimate(a, 0.01, 1.0, True) for a in made.azimuths)),
    )
    beside = ROTORS.phasors() if row.model == "learnt" and row.noise != "wind" else None
    candidates = plan(
        estimate.sources, FREE, SPACING / SPEED_OF_SOUND, 1.0, beside=beside, share=ROTORS_SHARE
    ).candidates
    for target in range(row.k):
        heading = next((c.heading for c in candidates if c.source == target), 0.0)
        images, lead_in, mixture = _run(row, made, clips, target, heading)
        spectrogram = LONG.analyse(mixture)
        groups = separator.batch(spectrogram, _scene(row, made, lead_in, spectrogram, heading))
        group = next(g for g, members in enumerate(groups.members) if target in members)
        voice = LONG.synthesise(groups.signals[group], mixture.shape[1])
        before, reference = si_sdr(mixture[0], images[target, 0]), images[target, 0]
        after = si_sdr(voice, reference) if np.ptp(voice) > 0 else before
        yield replace(row, target=target, si_sdr_in_db=round(before, 2), si_sdr_out_db=round(after, 2))


def _run(
    row: Row, made: NoiseScene, clips: Sequence[Samples], target: int, heading: float
) -> tuple[Real, Samples, Samples]:
    """Images of all talkers (k, 2, n), a lead-in at the first heading and the mixture at ``heading``, (2, n) each."""
    rng = np.random.default_rng([row.seed, row.k, row.layout, target, 1])
    n, first = round(RUN * RATE), round(LEAD_IN * RATE)
    speech = [np.resize(np.roll(v, -int(rng.integers(len(v)))), n).astype(float) for v in made.voices]
    images = images_of(speech, made.azimuths, heading)
    noise = noise_of(row.noise, LEAD_IN + RUN, clips, rng)
    lead_in, rest = noise.at(float(HEADINGS[0]), 0, first), noise.at(heading, first, first + n)
    talk = float(np.mean(images.sum(axis=0)[0] ** 2))
    gain, sensor = (
        np.sqrt(talk / np.mean(rest[0] ** 2)) * 10 ** (-row.snr_db / 20),
        np.sqrt(talk) * 10 ** (SENSOR_DB / 20),
    )
    lead_in = gain * lead_in + sensor * rng.standard_normal(lead_in.shape)
    mixture = images.sum(axis=0) + gain * rest + sensor * rng.standard_normal(rest.shape)
    return images, lead_in.astype(np.float32), mixture.astype(np.float32)


def _scene(row: Row, made: NoiseScene, lead_in: Samples, spectrogram: Complex, heading: float) -> Scene:
    quiet = LONG.analyse(lead_in)
    noise = None
    if row.model == "learnt":
        rotors = None if row.noise == "wind" else ROTORS
        noise = learnt(quiet, LONG.frequencies, LONG.period, float(HEADINGS[0]), rotors)
    return Scene(
        LONG.frequencies,
        SPACING,
        SPEED_OF_SOUND,
        row.k,
        tdoa(made.azimuths, heading, SPACING, SPEED_OF_SOUND),
        quiet_psd(quiet, spectrogram),
        hop=LONG.hop,
        noise_field=None if noise is None else noise.field(spectrogram, LONG.frequencies, LONG.period, heading),
    )


def table(found: Sequence[Row]) -> str:
    """A line for every noise, model and ratio."""
    lines = [
        "| noise | model | ratio | all right | found | K 2, 3: SI-SDR in | out | one talker: in | out |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for kind, model, snr in dict.fromkeys((row.noise, row.model, row.snr_db) for row in found):
        mine = [row for row in found if (row.noise, row.model, row.snr_db) == (kind, model, snr)]
        heard = [row for row in mine if row.target is None]
        cells = ["", ""]
        if heard:
            right, talkers = sum(row.right for row in heard), sum(row.k for row in heard)
            cells = [
                f"{right / len(heard):.2f} ({right} of {len(heard)})",
                f"{sum(row.within or 0 for row in heard) / talkers:.2f}",
            ]
        for counts in ((2, 3), (1,)):
            done = [row for row in mine if row.target is not None and row.k in counts]
            cells += [_mean([row.si_sdr_in_db for row in done]), _mean([row.si_sdr_out_db for row in done])]
        lines.append(f"| {kind} | {model} | {snr:g} dB | {' | '.join(cells)} |")
    return "\n".join(lines)


def _mean(values: Sequence[float | None]) -> str:
    numbers = [value for value in values if value is not None]
    return f"{np.mean(numbers):.1f}" if numbers else ""


def conduct_noise(design: Design, *, out: Path, speech: Path, noise: Path | None) -> int:
    """Measure, write ``rows.csv`` and ``table.md`` into ``out``, and print the table.

    Raises
    ------
    ConfigError
        When a folder cannot be used.
    """
    voices = {voice.name: voice.speech for voice in load_folder(speech, RATE)}
    chosen = [voices[name] for name in VOICES if name in voices] or list(voices.values())
    clips = [] if noise is None else recordings(noise)
    if not clips:
        design = replace(design, kinds=tuple(kind for kind in design.kinds if kind != "recorded"))
    out.mkdir(parents=True, exist_ok=True)
    found: list[Row] = []
    with threadpool_limits(1), (out / "rows.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [each.name for each in fields(Row)])
        writer.writeheader()
        for row in rows(design, chosen, clips):
            writer.writerow(asdict(row))
            file.flush()
            found.append(row)
    (out / "table.md").write_text(table(found) + "\n", encoding="utf-8")
    sys.stdout.write(table(found) + "\n")
    return 0
