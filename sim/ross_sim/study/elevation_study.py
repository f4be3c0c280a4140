"""How well talkers below the array are found and separated: `python -m ross_sim.study.elevation_study --speech DIR`.

The array hovers in the open, 5 m above the mouths of K talkers at elevations of -20 to -60 deg; all else is as in
`exploration`, and the first row of every K has the talkers as high as the array. A row gives how often K is right, how
often also all azimuths are within 10 deg, the mean error of those azimuths, how many of these elevations are within
10 deg (one that is not told counts as 0) and their mean error. With `--align`, every talker of a scene with all found
is the target once: mean SI-SDRi of the local Gaussian model at the heading and with the TDOAs that follow from the true
places, from the estimated ones, and from the estimated azimuths alone.
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
from ross_sim.study import exploration
from ross_sim.study.exploration import NEAR_DEG
from ross_sim.study.mixtures import RATE, gains, record
from ross_sim.study.option_types import NATURAL, POSITIVE, argument
from ross_sim.study.room_settings import DISTANCE, SPACING, SPEED_OF_SOUND, Setting
from ross_sim.study.script_errors import told_by
from ross_sim.study.talker_placement import standard_voices

COUNTS = (2, 3, 4, 5)  # K
RUN = 10.0  # of every talker, to separate [s]
STEEP_DEG = (20.0, 60.0)  # how far below the array the talkers are
MOUTH = 1.6  # height of a talker's mouth [m]
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
        azimuths = np.array([source.azimuth for source in self.estimate.sources])
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


def row(explored: Sequence[ExploredField]) -> str:
    """Everything that is said of some layouts."""
    k_right = np.mean([one.estimate.k == len(one.azimuths) for one in explored])
    right = [(one, one.found) for one in explored if one.found]
    azimuth, elevation = [], []
    for one, found in right:
        azimuth += [abs(difference(source.azimuth, a)) for source, a in zip(found or (), one.azimuths, strict=True)]
        told = [source.elevation or 0.0 for source in found or ()]
        elevation += np.abs(np.array(told) - one.field.elevations(one.azimuths)).tolist()
    within = np.mean(np.rad2deg(elevation) <= NEAR_DEG)
    errors = f"{np.rad2deg(np.mean(azimuth)):11.2f}  {within:15.3f}  {np.rad2deg(np.mean(elevation)):13.2f}"
    return f"{k_right:7.2f}  {len(right) / len(explored):9.2f}  {errors}"


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
    asked = parser.parse_args(arguments)
    with told_by(parser):
        voices = [voice.speech for voice in standard_voices(asked.speech, RATE, max(COUNTS))]
    sys.stdout.write("rotations  field  K right  all right  error [deg]  elevation right  its error [deg]\n")
    with threadpool_limits(1):
        for rotations, field in product(asked.rotations, FIELDS):
            keys = list(product(COUNTS, range(asked.layouts)))
            every = [explore(field, k, [asked.seed, k, n], voices, rotations) for k, n in keys]
            sys.stdout.write(f"{rotations:9d}  {field.name}  {row(every)}\n")
            right = [one for (k, n), one in zip(keys, every, strict=True) if k > 2 and n < asked.align and one.found]
            found = [gain for one in right for gain in aligned(one, asked.seed)] if field.above else []
            if found:
                sys.stdout.write(
                    "SI-SDRi [dB]: true {:.2f}, estimated {:.2f}, azimuths alone {:.2f}".format(*np.mean(found, axis=0))
                    + f" ({len(found)} targets)\n"
                )
            sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
