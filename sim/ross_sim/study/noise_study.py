"""How well talkers are found and separated in the noise of a vehicle: ``ross study noise``.

Every scene (`noise_scenes`) is explored at nine headings, 3 s each, after a lead-in of 2 s at the first one; then every
talker is the target once, at the heading that the plan chooses by the true azimuths, for 10 s. The noise goes on from
the lead-in through all of it. "All right" means that K is right and everybody within 10 degrees. The separator is told
the true delays and the noise that the lead-in and the run tell, and as "told" how fast rotors turn that are made; what
the white model makes of the same scenes stands beside it. A lone talker is separated too: from the noise.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.alignment.plan import Turn, plan
from ross_payload.atomic_files import replacing
from ross_payload.dsp.ego_noise import learnt
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.rotor_tones import tones
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.errors import OutputError, refused_as
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Complex, Marks, Observation, Real, Samples, Scene
from ross_payload.localization.joint import Joint
from ross_payload.localization.joint_in_noise import JointInNoise
from ross_payload.mission.align import ROTORS as ROTORS_SHARE
from ross_payload.plugin_checks import load_separator
from ross_sim.study.rows.noise_rows import NoiseRow, noises
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.runs.row_manifest import RECORDED, alone_with, basis_in_noise, claim
from ross_sim.study.runs.talker_placement import standard_voices
from ross_sim.study.scenes.exploration import FRAME, NEAR_DEG, matched
from ross_sim.study.scenes.mixtures import FRAME as LONG_FRAME
from ross_sim.study.scenes.mixtures import HOP, LEAD_IN, RATE, expect_sound
from ross_sim.study.scenes.noise_scenes import (
    BLADES,
    HEADINGS,
    ROTORS,
    SENSOR_DB,
    Noise,
    NoiseScene,
    images_of,
    noise_of,
    recordings,
    scene,
)
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND

RUN = 10.0  # [s]
TALKERS = (1, 2, 3)
REPORTS = 10  # of the speeds of the rotors [Hz]
MODELS = ("learnt", "told", "white")
SHORT, LONG = Stft(RATE, FRAME, FRAME // 4), Stft(RATE, LONG_FRAME, HOP)
FREE = Turn(base=0.0, joint=0.0, lower=-np.inf, upper=np.inf)


@dataclass(frozen=True, slots=True)
class Design:
    """What is measured."""

    kinds: tuple[str, ...]
    snrs: tuple[float, ...]
    layouts: int
    seeds: tuple[int, ...]
    models: tuple[str, ...] = ("learnt", "white")
    separator: str = "refined"
    explore: bool = True
    separate: bool = True


def rows(
    design: Design, voices: Sequence[Samples], clips: Sequence[Samples], done: Sequence[NoiseRow] = ()
) -> Iterator[list[NoiseRow]]:
    """Measure everything that is not ``done``: all that is left of one scene and model at a time."""
    there = {(*_case(row), row.target) for row in done}
    places = product(design.kinds, design.snrs, design.seeds, TALKERS, range(design.layouts))
    for kind, snr, seed, k, layout in places:
        blanks = [NoiseRow(kind, model, snr, k, layout, seed) for model in design.models]
        explore = [row for row in blanks if design.explore and (*_case(row), None) not in there]
        separate = [row for row in blanks if design.separate and (*_case(row), k - 1) not in there]
        if not (explore or separate):
            continue
        made = scene(k, snr, kind, voices, clips=clips, key=[seed, k, layout])
        for row in blanks:
            found = [explored(row, made)] if row in explore else []
            new = [*found, *(separated(row, made, clips, design.separator) if row in separate else ())]
            if new:
                yield new


def _case(row: NoiseRow) -> tuple[object, ...]:
    """Scene and model of a row."""
    return row.noise, row.model, row.snr_db, row.k, row.layout, row.seed


def explored(row: NoiseRow, made: NoiseScene) -> NoiseRow:
    """Explore a scene."""
    joint = Joint(SPACING, SPEED_OF_SOUND)
    seen = None if row.model == "white" else observed(made, told=row.model == "told")
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


def observed(heard: NoiseScene, *, told: bool = False) -> list[Observation] | None:
    """What the explorer observes at every heading; None where the lead-in teaches nothing.

    ``told``: it knows how fast the rotors turn.
    """
    explorer, first, unit = JointInNoise(SPACING, SPEED_OF_SOUND), heard.lead_in.shape[1], heard.heard.shape[2]
    known = explorer.learn(
        SHORT.analyse(heard.lead_in),
        SHORT.frequencies,
        SHORT.period,
        float(HEADINGS[0]),
        ROTORS,
        tonal=tonal_of(heard.noise, SHORT, 0, first) if told else None,
    )
    if known is None:
        return None
    starts = first + unit * np.arange(len(HEADINGS))
    return [
        explorer.observe(
            SHORT.analyse(x),
            SHORT.frequencies,
            float(h),
            float(h),
            known,
            period=SHORT.period,
            tonal=tonal_of(heard.noise, SHORT, start, start + unit) if told else None,
        )
        for x, h, start in zip(heard.heard, HEADINGS, starts, strict=True)
    ]


def tonal_of(noise: Noise, stft: Stft, begin: int, end: int) -> Marks | None:
    """Where tones of the rotors are between two samples; None where nobody knows their speeds."""
    if noise.speeds is None:
        return None
    speeds = noise.speeds[:, begin : end : RATE // REPORTS].T
    seconds = (end - begin) / RATE
    return tones(stft.frequencies, stft.period, stft.frames_of(end - begin), speeds, seconds=seconds, blades=BLADES)


def separated(row: NoiseRow, made: NoiseScene, clips: Sequence[Samples], name: str) -> Iterator[NoiseRow]:
    """Separate every target at its own heading."""
    separator, estimate = (
        load_separator(name),
        Estimate(tuple(SourceEstimate(a, 0.01, 1.0, True) for a in made.azimuths)),
    )
    beside = ROTORS.phasors() if row.model != "white" and row.noise != "wind" else None
    candidates = plan(
        estimate.sources, FREE, SPACING / SPEED_OF_SOUND, 1.0, beside=beside, share=ROTORS_SHARE
    ).candidates
    for target in range(row.k):
        heading = next((c.heading for c in candidates if c.source == target), 0.0)
        images, lead_in, mixture, noise = _run(row, made, clips, target, heading)
        spectrogram = LONG.analyse(mixture)
        tonal = None
        if row.model == "told":
            tonal = tonal_of(noise, LONG, lead_in.shape[1], lead_in.shape[1] + mixture.shape[1])
        groups = separator.batch(spectrogram, _scene(row, made, lead_in, spectrogram, heading, tonal=tonal))
        group = next(g for g, members in enumerate(groups.members) if target in members)
        voice = LONG.synthesise(groups.signals[group], mixture.shape[1])
        before, reference = si_sdr(mixture[0], images[target, 0]), images[target, 0]
        after = si_sdr(voice, reference) if np.ptp(voice) > 0 else before
        yield replace(row, target=target, si_sdr_in_db=round(before, 2), si_sdr_out_db=round(after, 2))


def _run(
    row: NoiseRow, made: NoiseScene, clips: Sequence[Samples], target: int, heading: float
) -> tuple[Real, Samples, Samples, Noise]:
    """Images of all talkers (k, 2, n), a lead-in at the first heading, the mixture at ``heading``, and the noise."""
    rng = np.random.default_rng([row.seed, row.k, row.layout, target, 1])
    n, first = round(RUN * RATE), round(LEAD_IN * RATE)
    speech = [np.resize(np.roll(v, -int(rng.integers(len(v)))), n).astype(float) for v in made.voices]
    expect_sound(speech, RATE)
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
    return images, lead_in.astype(np.float32), mixture.astype(np.float32), noise


def _scene(
    row: NoiseRow, made: NoiseScene, lead_in: Samples, spectrogram: Complex, heading: float, *, tonal: Marks | None
) -> Scene:
    quiet = LONG.analyse(lead_in)
    noise = None
    if row.model != "white":
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
        noise_field=None if noise is None else noise.field(spectrogram, LONG.frequencies, LONG.period, heading, tonal),
    )


def conduct_noise(design: Design, *, out: Path, speech: Path, noise: Path | None) -> int:
    """Measure what ``out`` lacks, add it to its ``rows.csv``, write its ``table.md``, and print the table.

    Raises
    ------
    ConfigError
        When a folder or the separator cannot be used, there are no recordings of noise that is recorded, or ``out``
        holds rows of other talkers, recordings or another separator.
    OutputError
        When a file cannot be written.
    """
    talkers = standard_voices(speech, RATE, max(TALKERS))
    voices, clips = [voice.speech for voice in talkers], [] if noise is None else recordings(noise)
    path, wanted = out / "rows.csv", basis_in_noise({}, talkers, clips, design.separator)
    if "recorded" not in design.kinds:
        del wanted[RECORDED]
    with alone_with(path), threadpool_limits(1):
        claim(path, wanted, later=(RECORDED,))
        found: list[NoiseRow] = read_rows(path, [NoiseRow])[1] if path.exists() else []
        for new in rows(design, voices, clips, found):
            found += new
            _write(path, as_csv(found, NoiseRow))
        text = noises(found).body() + "\n"
        _write(out / "table.md", text.encode())
    sys.stdout.write(text)
    return 0


def _write(path: Path, content: bytes) -> None:
    with refused_as(OutputError, f"{path}: cannot be written"), replacing(path) as part:
        part.write_bytes(content)
