"""What an array of 5 cm hears from above: ``ross study above``.

Every scene (`above_scenes`) is explored at nine headings, 3 s each, after a lead-in of 2 s at the first one, by an
explorer that knows the height and by one that does not. "All right" means that K is right and everybody within 10
degrees of where they are when the last heading has been heard. Then every talker is the target once, for 10 s at the
heading that the plan chooses by the true places; the separator is told the true delays of that moment.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from ross_payload.alignment.plan import plan
from ross_payload.angles import difference
from ross_payload.atomic_files import replacing
from ross_payload.dsp.ego_noise import EgoNoise, learnt
from ross_payload.dsp.metrics import si_sdr
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.errors import OutputError, refused_as
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Observation, Real, Samples, Scene, Separator
from ross_payload.localization.joint import Joint
from ross_payload.localization.joint_in_noise import JointInNoise
from ross_payload.mission.align import ROTORS as ROTORS_SHARE
from ross_payload.plugin_checks import load_separator
from ross_sim.study.noise_study import FREE, LONG, RUN, SHORT, TALKERS
from ross_sim.study.rows.above_rows import AboveRow, above
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.runs.row_manifest import alone_with, basis_in_noise, claim
from ross_sim.study.runs.talker_placement import standard_voices
from ross_sim.study.scenes.above_scenes import AboveScene, among, images_of, rotors_of, scene
from ross_sim.study.scenes.exploration import NEAR_DEG, matched
from ross_sim.study.scenes.mixtures import LEAD_IN, RATE, expect_sound
from ross_sim.study.scenes.noise_scenes import HEADINGS, ROTORS, noise_of, recordings
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND


@dataclass(frozen=True, slots=True)
class AboveDesign:
    """What is measured."""

    heights: tuple[float, ...]
    ratios: tuple[float | None, ...]
    walks: tuple[float, ...]
    layouts: int  # of every K from 1 to 3, explored
    separated: int  # of these, also separated
    ground: float
    separator: str
    seed: int


def rows(
    design: AboveDesign, voices: Sequence[Samples], clips: Sequence[Samples], done: Sequence[AboveRow] = ()
) -> Iterator[list[AboveRow]]:
    """Measure everything that is not ``done``, scene by scene."""
    there = {_key(row) for row in done}
    separator = load_separator(design.separator)
    scenes = product(design.heights, design.walks, design.ratios, TALKERS, range(design.layouts))
    for height, walk, ratio, k, layout in scenes:
        row = AboveRow(height, walk, ratio, rotors_of(clips), design.ground, k, layout, design.seed, told=True)
        parts = layout < design.separated
        apart = replace(row, separator=design.separator)
        if _key(row) in there and (not parts or _key(replace(apart, target=k - 1)) in there):
            continue
        key, about = [design.seed, k, layout], {"speed": walk, "ground": design.ground}
        made = scene(k, height, ratio, voices, clips=clips, key=key, **about)
        yield [*explored(row, made), *(separated(apart, made, clips, separator) if parts else ())]


def explored(row: AboveRow, made: AboveScene) -> Iterator[AboveRow]:
    """Explore a scene, knowing the height and not knowing it."""
    seen = observed(made)
    azimuths, elevations = made.walks.azimuths(made.end), made.walks.elevations(made.end)
    for told in (True, False):
        height = row.height_m if told else None
        estimate = Joint(SPACING, SPEED_OF_SOUND).estimate([replace(each, height=height) for each in seen])
        errors = matched(azimuths, estimate)[0] if estimate.k else np.full(row.k, 180.0)
        near = np.flatnonzero(errors <= NEAR_DEG)
        steep = [abs(_nearest(estimate, azimuths[k]) - elevations[k]) for k in near]
        yield replace(
            row,
            told=told,
            k_found=estimate.k,
            within=len(near),
            azimuth_errors_deg=tuple(np.round(errors[near], 2).tolist()),
            elevation_errors_deg=tuple(np.round(np.rad2deg(steep), 2).tolist()),
        )


def _nearest(estimate: Estimate, azimuth: float) -> float:
    """Elevation of the source nearest to an azimuth, 0 when none is told [rad]."""
    source = min(estimate.sources, key=lambda each: abs(difference(each.azimuth, azimuth)))
    return source.elevation or 0.0


def observed(made: AboveScene) -> list[Observation]:
    """What the explorer observes at every heading, knowing what the lead-in tells of the noise."""
    joint, explorer = Joint(SPACING, SPEED_OF_SOUND), JointInNoise(SPACING, SPEED_OF_SOUND)
    quiet, heard = SHORT.analyse(made.lead_in), zip(map(SHORT.analyse, made.heard), HEADINGS.tolist(), strict=True)
    known = explorer.learn(quiet, SHORT.frequencies, SHORT.period, float(HEADINGS[0]), ROTORS)
    if known is not None:
        return [explorer.observe(x, SHORT.frequencies, h, h, known, period=SHORT.period) for x, h in heard]
    return [joint.observe(x, SHORT.frequencies, h, quiet_psd(quiet, x), frame_period=SHORT.period) for x, h in heard]


def separated(row: AboveRow, made: AboveScene, clips: Sequence[Samples], separator: Separator) -> Iterator[AboveRow]:
    """Separate every target at its own heading."""
    azimuths, elevations = made.walks.azimuths(made.end), made.walks.elevations(made.end)
    places = zip(azimuths.tolist(), elevations.tolist(), strict=True)
    sources = [SourceEstimate(azimuth, 0.01, 1.0, True, elevation=elevation) for azimuth, elevation in places]
    beside = None if row.ratio_db is None else ROTORS.phasors()
    planned = plan(sources, FREE, SPACING / SPEED_OF_SOUND, 1.0, beside=beside, share=ROTORS_SHARE)
    for target in range(row.k):
        heading = next((c.heading for c in planned.candidates if c.source == target), 0.0)
        image, lead_in, mixture = _run(row, made, clips, target, heading)
        spectrogram, quiet = LONG.analyse(mixture), LONG.analyse(lead_in)
        noise: EgoNoise | None = learnt(quiet, LONG.frequencies, LONG.period, float(HEADINGS[0]), ROTORS)
        told = Scene(
            LONG.frequencies, SPACING, SPEED_OF_SOUND, row.k,
            tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND, elevations), quiet_psd(quiet, spectrogram), hop=LONG.hop,
            noise_field=None if noise is None else noise.field(spectrogram, LONG.frequencies, LONG.period, heading),
        )  # fmt: skip
        groups = separator.batch(spectrogram, told)
        group = next(g for g, members in enumerate(groups.members) if target in members)
        voice = LONG.synthesise(groups.signals[group], mixture.shape[1])
        before = si_sdr(mixture[0], image)
        after = si_sdr(voice, image) if np.ptp(voice) > 0 else before
        yield replace(row, target=target, si_sdr_in_db=round(before, 2), si_sdr_out_db=round(after, 2))


def _run(
    row: AboveRow, made: AboveScene, clips: Sequence[Samples], target: int, heading: float
) -> tuple[Real, Samples, Samples]:
    """The target alone at microphone 1 (n,), a lead-in at the first heading and the mixture at ``heading``, (2, n)."""
    rng = np.random.default_rng([row.seed, row.k, row.layout, target, 1])
    n = round(RUN * RATE)
    speech = [np.resize(np.roll(v, -int(rng.integers(len(v)))), n).astype(float) for v in made.voices]
    expect_sound(speech, RATE)
    images = images_of(
        [each / np.sqrt(np.mean(each**2)) for each in speech], made.walks, heading, made.ground, made.end
    )
    noise = noise_of(row.rotors, LEAD_IN + RUN, clips, rng)
    lead_in, mixture = among(noise, images.sum(axis=0)[None], [heading], row.ratio_db, rng)
    return images[target, 0], lead_in.astype(np.float32), mixture[0].astype(np.float32)


def conduct_above(design: AboveDesign, *, out: Path, speech: Path, noise: Path | None) -> int:
    """Measure, write the rows into the file ``out`` and print the table; what it holds already is not measured again.

    Raises
    ------
    ConfigError
        When a folder cannot be used, or ``out`` holds something else, or rows of other talkers, rotors, ground,
        separator or seed, or of another version.
    OutputError
        When the rows cannot be written.
    """
    talkers = standard_voices(speech, RATE, max(TALKERS))
    voices, clips = [voice.speech for voice in talkers], [] if noise is None else recordings(noise)
    asked = {"rotors": rotors_of(clips), "ground": design.ground, "seed": design.seed}
    wanted = basis_in_noise(asked, talkers, clips, design.separator)
    with alone_with(out), threadpool_limits(1):
        claim(out, wanted)
        found: list[AboveRow] = read_rows(out, [AboveRow])[1] if out.exists() else []
        for new in rows(design, voices, clips, found):
            names = {_key(row) for row in new}
            found = [row for row in found if _key(row) not in names] + new
            with refused_as(OutputError, f"{out}: cannot be written"), replacing(out) as path:
                path.write_bytes(as_csv(found, AboveRow))
    sys.stdout.write(above(found).body() + "\n")
    return 0


def _key(row: AboveRow) -> tuple[object, ...]:
    scene = row.height_m, row.walk_m_s, row.ratio_db, row.rotors, row.ground, row.k, row.layout, row.seed
    return (*scene, row.told, row.target, row.separator)
