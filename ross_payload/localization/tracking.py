"""Track the azimuths of sources from frame to frame: a multiple-hypothesis filter over all sources together.

A hypothesis says which sources have left the place where they rested; the others are there, and do not drift. What it
believes of every source that has left is a point-mass density over azimuth and rate (Bucy and Senne 1971): two
microphones hear only ``cos(azimuth - heading)``, so a source that walks past the axis of the array may have gone on
or turned back, and when one of two sources with one delay sets out, it may be either. The first is in the density,
the second in the weights of hypotheses (Reid 1979); both stay possible until the array turns or the walk tells.

*Prediction.* A source that has left rests, sets out, keeps its rate, turns back, stops. Another one sets out: part of
a hypothesis becomes the one in which that source has left, too. Hypotheses with the same sources are merged.

*Correction.* The phases between the microphones in trustworthy bins are a mixture: of every source von Mises around
``2 pi f tau`` with ``tau = (d / v_p) a cos(azimuth - heading)``, also above the frequency where that wraps, and of
nobody evenly spread. The share of every source in these frames is found by expectation maximisation under what a
hypothesis predicts. With one source that has left this is exact but for the shares; several are corrected in turn,
each given what is believed of the others (variational factorisation). A hypothesis is weighed by how well it has
predicted the phases.

Nothing is drawn at random: the same frames give the same tracks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ross_payload.alignment.predicted_gain import OPEN
from ross_payload.angles import difference
from ross_payload.events import Estimate
from ross_payload.interfaces import Real
from ross_payload.localization.phase_likelihood import N_BANDS, Scene
from ross_payload.localization.phase_statistics import HEARING, FrameStatistics, Hearing
from ross_payload.localization.room_amplitude import UNTOLD, RoomAmplitude
from ross_payload.localization.talker_motion import (
    AZIMUTHS,
    MOTION,
    N_AZIMUTHS,
    REST,
    Motion,
    around,
    fresh_rates,
    moved,
    talks,
)
from ross_payload.localization.track_correction import correct, widened
from ross_payload.localization.track_hypotheses import Hypothesis, Members, Tracks

PLACE = np.radians(1.5)  # of where somebody rests, beside that of the exploration [rad]
DRAWN = 0.75  # part of what is not direct by which reflections draw delays to 0
ASTRAY = 0.3  # and part of that by which one delay differs from the next
MOST = 8  # hypotheses
LEAVE = 2  # at one time, at most: one more would seldom be told from echoes
UNLIKELY = 1e-4  # least weight of a hypothesis: phases that echoes share tell less than they seem to
TINY = 1e-12


def begin(estimate: Estimate, spacing: float, speed_of_sound: float) -> Tracks:
    """Begin with what an exploration has found: its azimuths and sigmas, and everybody at rest."""
    azimuths = estimate.azimuths
    amplitude = UNTOLD if estimate.directness is None else 1 - DRAWN * (1 - estimate.directness)
    k = len(azimuths)
    place = float(np.hypot(PLACE, ASTRAY * (1 - amplitude)))
    densities = np.array(
        [around(source.azimuth, float(np.hypot(source.nominal, place))) for source in estimate.sources]
    )
    densities = densities.reshape(k, N_AZIMUTHS)
    return Tracks(
        hypotheses=(Hypothesis(1.0, {}, np.ones(k)),),
        homes=azimuths,
        home_densities=densities,
        rests=densities,
        heading=0.0,
        elevations=np.cos(estimate.elevations),
        shares=np.full((k + 1, N_BANDS), 1 / (k + 1)),
        ages=np.zeros(k),
        unit=spacing / speed_of_sound,
        wet=estimate.directness is None or estimate.directness < OPEN,
        amplitude=amplitude,
        room=RoomAmplitude() if estimate.directness is None and k > 1 else None,  # one who walks would pass for a room
    )


def step(tracks: Tracks, statistics: FrameStatistics, motion: Motion = MOTION, hearing: Hearing = HEARING) -> Tracks:
    """Return what is believed at the end of some frames: predict, then correct by what was heard in them."""
    if not len(tracks.ages):
        return tracks
    ahead = predict(tracks, statistics.seconds, motion)
    if not len(statistics.weights):
        return ahead
    after, parts = correct(_learnt(ahead, statistics, hearing), statistics, hearing)
    return replace(after, hypotheses=_merged(parts))


def _learnt(tracks: Tracks, statistics: FrameStatistics, hearing: Hearing) -> Tracks:
    """Return the tracks with the amplitude of delays in a room that nobody has explored, as far as it is heard."""
    if tracks.room is None:
        return tracks
    shares = tracks.shares[:-1].mean(axis=1)
    scene = Scene(tracks.unit, tracks.homes, tracks.elevations, shares, tracks.wet, tracks.amplitude)
    room = tracks.room.after(statistics, scene, tracks.shares, hearing)
    return replace(tracks, amplitude=room.amplitude, room=None if room.known else room)


def predict(tracks: Tracks, seconds: float, motion: Motion = MOTION) -> Tracks:
    """Return what is believed ``seconds`` later when nothing is heard."""
    seconds = round(seconds, 6)
    near = np.abs(difference(AZIMUTHS, tracks.homes[:, None]))
    aside = np.where(near < motion.elbows, np.exp(-motion.aside * seconds), 1.0).astype(np.float32)
    fresh = (fresh_rates()[:, None] * widened(tracks.rests)[:, None]).astype(np.float32)
    walks = [belief for each in tracks.hypotheses for belief in each.left.values()]
    later = iter(moved(np.stack(walks), seconds, motion) if walks else ())
    parts: list[Hypothesis] = []
    for each in tracks.hypotheses:
        left: dict[int, Real] = {}
        weight = each.weight
        at_rest = [k for k in range(len(near)) if k not in each.left]
        for source in each.left:
            belief = next(later) * aside[at_rest].prod(axis=0)  # two people are not in one direction
            kept = float(belief.sum())
            left[source] = belief / kept
            weight *= kept
        after = Hypothesis(weight, left, talks(each.talking, seconds, motion))
        parts += _branches(after, fresh, near <= 2 * PLACE, seconds, motion)
    return replace(tracks, hypotheses=_merged(parts), ages=tracks.ages + seconds)


def _branches(
    hypothesis: Hypothesis, fresh: Real, home: NDArray[np.bool_], seconds: float, motion: Motion
) -> list[Hypothesis]:
    """What a hypothesis becomes: one of those who have left has come back, or somebody else has left, or neither."""
    out = 1 - float(np.exp(-motion.sets_out * seconds))
    back = 1 - float(np.exp(-motion.settles * seconds))
    left, weight, parts = dict(hypothesis.left), hypothesis.weight, []
    for source in range(len(home)):
        if source in left:
            rest = {other: belief for other, belief in left.items() if other != source}
            share = back * float(left[source][REST, home[source]].sum())
            left[source] = left[source].copy()
            left[source][REST, home[source]] *= 1 - back
            left[source] /= left[source].sum()
        elif len(left) < LEAVE:
            rest, share = {**left, source: fresh[source]}, out
        else:
            continue
        parts.append(Hypothesis(weight * share, rest, hypothesis.talking))
        weight *= 1 - share
    return [*parts, Hypothesis(weight, left, hypothesis.talking)]


def _merged(parts: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Hypotheses with the same members become one; the likeliest are kept, none of them as unlikely as it seems."""
    groups: dict[Members, list[Hypothesis]] = {}
    for part in parts:
        groups.setdefault(part.members, []).append(Hypothesis(max(part.weight, TINY), part.left, part.talking))
    totals = {members: sum(part.weight for part in group) for members, group in groups.items()}
    kept = sorted(totals, key=lambda members: (-totals[members], len(members), members))[:MOST]
    whole = sum(totals[members] for members in kept)
    weights = {members: max(totals[members] / whole, UNLIKELY) for members in kept}
    whole = sum(weights.values())
    return tuple(_mixed(groups[members], totals[members], weights[members] / whole) for members in kept)


def _mixed(group: Sequence[Hypothesis], total: float, weight: float) -> Hypothesis:
    """One hypothesis of several with the same members."""
    if len(group) == 1:
        return Hypothesis(weight, group[0].left, group[0].talking)
    odds = np.array([part.weight for part in group]) / total
    left = {
        source: np.tensordot(odds.astype(np.float32), np.stack([part.left[source] for part in group]), 1)
        for source in group[0].members
    }
    return Hypothesis(weight, left, odds @ np.stack([part.talking for part in group]))
