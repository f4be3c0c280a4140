"""What `joint` keeps of a period: weight per ITD bin, at every heading at which the array was during it.

At rest that is one heading. While the array turns a period is cut into sectors so narrow that the delay of a talker
hardly changes in one: the model of `itd_mixture` gives every sector the delays of its own heading.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ross_payload.interfaces import Observation, Real
from ross_payload.localization.talker_evidence import Among

SECTOR = np.deg2rad(6.0)  # the array turns within one sector by less than this and what it turns in one block [rad]
STEP = np.deg2rad(15.0)  # axes that differ by as much tell as much as two orientations [rad]
ROUNDING = 1e-9  # of headings, in steps


@dataclass(frozen=True, slots=True)
class Histograms:
    """What is kept of one heading: weight per ITD bin."""

    blocks: Real  # of all trustworthy bins, for every block of time, (n_blocks, n_bins)
    strict: Real  # of bins that belong to one talker, (n_bins,)
    among: Among | None = None  # the noise of a vehicle, where that is known


@dataclass(frozen=True, slots=True)
class Sectors:
    """What is kept of a period in which the array turned: a histogram for each of its headings."""

    headings: Real  # [rad], (n_sectors,)
    histograms: tuple[Histograms, ...]


@dataclass(frozen=True, slots=True)
class Rows:
    """The histograms of several periods one below the other."""

    headings: Real  # [rad], (n_rows,)
    blocks: tuple[Real, ...]  # (n_blocks, n_bins) of every row
    strict: Real  # (n_rows, n_bins)
    among: tuple[Among | None, ...]  # of every row
    periods: NDArray[np.intp] | None  # first row of every period; None: each row is one


def rows_of(observations: Sequence[Observation]) -> Rows:
    """Put together what an explorer has kept of all its observations, one or more."""
    kept = [sectors_of(observation) for observation in observations]
    counts = [len(sectors.histograms) for sectors in kept]
    every = [each for sectors in kept for each in sectors.histograms]
    return Rows(
        np.concatenate([sectors.headings for sectors in kept]),
        tuple(each.blocks for each in every),
        np.stack([each.strict for each in every]),
        tuple(each.among for each in every),
        None if max(counts) == 1 else np.cumsum([0, *counts[:-1]]),
    )


def together(parts: Sequence[Observation]) -> Observation:
    """One observation of a period whose parts have a heading each; its density is that of the part in the middle."""
    middle, weight = parts[len(parts) // 2], sum(part.weight for part in parts)
    sectors = Sectors(np.array([part.heading for part in parts]), tuple(part.features for part in parts))
    return replace(middle, weight=weight, features=sectors)


def sectors_of(observation: Observation) -> Sectors:
    """The sectors of an observation; of one at rest the only one."""
    if isinstance(observation.features, Sectors):
        return observation.features
    return Sectors(np.array([observation.heading]), (observation.features,))


def shifted(observation: Observation, angle: float) -> Observation:
    """Return an observation whose headings were told wrong, ``angle`` [rad] further on."""
    kept = observation.features
    features = replace(kept, headings=kept.headings + angle) if isinstance(kept, Sectors) else kept
    return replace(observation, heading=observation.heading + angle, features=features)


def covered(headings: Real) -> int:
    """How many steps of half a turn the axes at these headings [rad] cover.

    >>> covered(np.deg2rad([0.0, 10.0, 20.0, 190.0])), covered(np.deg2rad(np.arange(0.0, 360.0, 10.0)))
    (2, 12)
    """
    return len(np.unique(np.floor(np.mod(headings, np.pi) / STEP + ROUNDING)))


def cut(headings: Real, block: int) -> list[slice]:
    """Cut frames at these headings [rad], (n_frames,), into sectors of whole blocks of ``block`` frames.

    >>> [(each.start, each.stop) for each in cut(np.deg2rad([0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 15.0, 15.0, 15.0]), 2)]
    [(0, 2), (2, 4), (4, 9)]
    """
    found = [0]
    for frame in range(0, len(headings), block):
        if abs(headings[frame] - headings[found[-1]]) >= SECTOR:
            found.append(frame)
    return [slice(first, last) for first, last in pairwise([*found, len(headings)])]
