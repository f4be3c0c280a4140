"""How well talkers below the array are found and separated: `python -m ross_sim.study.elevation_study --speech DIR`.

The array hovers in the open, 5 m above the mouths of K talkers at elevations of -20 to -60 deg; all else is as in
`exploration`, and in half of the scenes the talkers are as high as the array. With `--align`, every talker of a scene
with all found is the target once: SI-SDRi of the local Gaussian model at the heading and with the TDOAs that follow
from the true places, from the estimated ones, and from the estimated azimuths alone.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.alignment.plan import Turn, plan
from ross_payload.angles import difference
from ross_payload.dsp.steering import tdoa
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Explorer, Real, Samples
from ross_sim.scenario import MOUTH
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.rows.elevation_rows import ElevationRow, below
from ross_sim.study.rows.result_rows import degrees, number
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.runs.talker_placement import standard_voices
from ross_sim.study.scenes import exploration
from ross_sim.study.scenes.exploration import NEAR_DEG
from ross_sim.study.scenes.mixtures import RATE, gains, record
from ross_sim.study.scenes.room_settings import DISTANCE, SPACING, SPEED_OF_SOUND, Setting
from ross_sim.study.script_errors import expect_writable, told_by, write_result

COUNTS = (2, 3, 4, 5)  # K
RUN = 10.0  # of every talker, to separate [s]
STEEP_DEG = (20.0, 60.0)  # how far below the array the talkers are
HOVER = 5.0  # of the array above the mouths [m]


@dataclass(frozen=True, slots=True)
class Field(Setting):
    """The open, with the array ``above`` the mouths of the talkers [m]."""

    above: float = HOVER

    @property
    def centre(self) -> tuple[float, ...]:
        """Where the array is [m]."""
        return self.size[0] / 2, self.size[1] / 2, MOUTH + self.above

    def places(self, azimuths: Real, rng: np.random.Generator) -> Real:
        """Where talkers at these azimuths [rad] stand [m], (n_sources, 3); ``rng`` draws elevations."""
        steep = np.deg2rad(rng.uniform(*STEEP_DEG, len(azimuths)))
        distance = self.above / np.tan(steep) if self.above else np.full(len(azimuths), DISTANCE)
        x, y, _ = self.centre
        flat = [x + distance * np.cos(azimuths), y + distance * np.sin(azimuths)]
        return np.stack([*flat, np.full(len(azimuths), MOUTH)], axis=1)

    def elevations(self, azimuths: Real) -> Real:
        """Elevations [rad] of the talkers that stand at these azimuths in every table, (n_sources,)."""
        places = self.places(azimuths, np.random.default_rng(np.abs(azimuths * 1e6).astype(int)))
        away = places - self.centre
        return np.asarray(np.arctan2(away[:, 2], np.hypot(away[:, 0], away[:, 1])))


FIELDS = (Field("level", (60.0, 60.0, 40.0), 0.0, 0.0), Field("above", (60.0, 60.0, 40.0), 0.0))


@dataclass(frozen=True, slots=True)
class ExploredField:
    """One layout and what the explorer believes of it."""

    field: Field
    azimuths: Real  # [rad], (k,)
    voices: tuple[Samples, ...]
    estimate: Estimate

    @property
    def found(self) -> tuple[SourceEstimate, ...] | None:
        """The estimate of every talker; None unless K is right and all azimuths are near."""
        azimuths = self.estimate.azimuths
        if len(azimuths) != len(self.azimuths):
            return None
        apart = np.abs(difference(self.azimuths[:, None], azimuths))
        talkers, sources = linear_sum_assignment(apart)
        near = apart[talkers, sources].max() <= np.deg2rad(NEAR_DEG)
        return tuple(self.estimate.sources[source] for source in sources) if near else None


def explore(field: Field, k: int, key: Sequence[int], voices: Sequence[Samples], rotations: int) -> ExploredField:
    """Explore one layout; ``key`` seeds it."""
    joint: Explorer = plugins.load("ross_payload.explorers", "joint").make(SPACING, SPEED_OF_SOUND)
    heard = exploration.explore(joint, field, voices, k, key=key, rotations=rotations)
    return ExploredField(field, heard.azimuths, heard.voices, joint.estimate(heard.observations))


def row_of(one: ExploredField, k: int, layout: int, seed: int, rotations: int, *, separate: bool) -> ElevationRow:
    """Everything that is said of a layout; ``separate``: with what every talker gains, where all are found."""
    found, true = one.found or (), one.field.elevations(one.azimuths)
    azimuth = [abs(float(difference(source.azimuth, a))) for source, a in zip(found, one.azimuths, strict=bool(found))]
    elevation = [abs((source.elevation or 0.0) - float(e)) for source, e in zip(found, true, strict=bool(found))]
    gained = list(zip(*aligned(one, seed), strict=True)) if separate and found else [(), (), ()]
    return ElevationRow(
        one.field.name, k, layout, seed, rotations, one.estimate.k,
        tuple(map(degrees, azimuth)), tuple(map(degrees, elevation)),
        *(tuple(map(number, gains)) for gains in gained),
    )  # fmt: skip


def aligned(explored: ExploredField, seed: int) -> Iterator[tuple[float, ...]]:
    """SI-SDRi [dB] of every talker by the true places, the estimated ones, and the estimated azimuths alone."""
    true = explored.field.elevations(explored.azimuths)
    places = [(float(a), float(e)) for a, e in zip(explored.azimuths, true, strict=True)]
    truth = [SourceEstimate(azimuth, 0.01, 1.0, True, elevation=elevation) for azimuth, elevation in places]
    beliefs = [truth, list(explored.found or ()), [replace(source, elevation=None) for source in explored.found or ()]]
    for target in range(len(truth)):
        yield tuple(_improvement(explored, belief, target, seed) for belief in beliefs)


def _improvement(explored: ExploredField, belief: Sequence[SourceEstimate], target: int, seed: int) -> float:
    planned = plan(belief, Turn(base=0.0, joint=0.0, lower=-np.inf, upper=np.inf), SPACING / SPEED_OF_SOUND)
    heading = next((c.heading for c in planned.candidates if c.source == target), 0.0)
    voices = [np.resize(voice, round(RUN * RATE)) for voice in explored.voices]
    rng = np.random.default_rng([seed, target])
    recorded = record(voices, explored.azimuths, target, heading, explored.field, rng=rng)
    azimuths, elevations = np.array([(source.azimuth, source.elevation or 0.0) for source in belief]).T
    tau = tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND, elevations)
    separator = plugins.load("ross_payload.separators", "gaussian")
    return gains(separator, replace(recorded, tau=tau))[target]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, default=Path("../shared/speech"), help="folder of recordings")
    parser.add_argument("--layouts", type=argument(POSITIVE), default=14, help="per K")
    parser.add_argument("--seed", type=argument(NATURAL), default=1)
    parser.add_argument("--rotations", type=argument(POSITIVE), nargs="+", default=[4, 8, 12])
    parser.add_argument(
        "--align", type=argument(NATURAL), default=0, help="also separate so many layouts of every K > 2"
    )
    parser.add_argument("--out", type=Path, help="file for the rows (.csv), for `ross study table`")
    asked = parser.parse_args(arguments)
    with told_by(parser):
        if asked.out:
            expect_writable(asked.out)
        voices = [voice.speech for voice in standard_voices(asked.speech, RATE, max(COUNTS))]
    with threadpool_limits(1):
        rows = [
            row_of(
                explore(field, k, [asked.seed, k, layout], voices, rotations),
                k, layout, asked.seed, rotations, separate=bool(field.above) and k > 2 and layout < asked.align,
            )
            for rotations, field, k, layout in product(asked.rotations, FIELDS, COUNTS, range(asked.layouts))
        ]  # fmt: skip
    sys.stdout.write(below(rows).markdown())
    if asked.out:
        with told_by(parser):
            write_result(asked.out, as_csv(rows, ElevationRow))
    return 0


if __name__ == "__main__":
    sys.exit(main())
