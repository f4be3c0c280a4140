"""One orientation: listen at one heading, tell the explorer, hear what it believes now, and compare its beliefs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ross_payload.angles import difference
from ross_payload.events import Estimate, OrientationHeard, SourcesEstimated
from ross_payload.interfaces import Complex, Marks, Observation, TurningExplorer
from ross_payload.localization import turning
from ross_payload.localization.turning import Turned
from ross_payload.mission.context import Context, Listening, Step
from ross_payload.mission.heading_hold import attend

STEADY = 2  # beliefs in a row with the same K and nearly the same azimuths
FEWEST = 3  # sources: two are heard apart anywhere, and after few orientations two may well be three
NEARLY = np.deg2rad(5.0)  # azimuths of one source in two beliefs [rad]
SHARP = np.deg2rad(3.0)  # largest standard deviation of any source [rad]
TRUSTED = 0.8  # least confidence of any source
SELF = np.deg2rad(10.0)  # a source is the one of an earlier belief when it is so near [rad]


def orientation(context: Context, seconds: float) -> Step[Estimate]:
    """Listen for ``seconds`` at one heading; return what the explorer believes after this orientation."""
    heard = yield from attend(context, seconds)
    context.explored.append(heard)
    return believe(context, observe(context, heard))


def believe(context: Context, seen: Observation) -> Estimate:
    """Ask the explorer what it believes after one more observation, and say that it was made."""
    r = len(context.observations)
    context.observations.append(seen)
    context.beliefs.append(context.tools.explorer.estimate(context.observations))
    context.publish(
        OrientationHeard(context.time, r, seen.heading, context.pointing.joint, seen.grid, seen.density, seen.peaks)
    )
    return context.beliefs[-1]


def observe(context: Context, listening: Listening) -> Observation:
    """Let the explorer condense what was heard at one heading."""
    stft = context.tools.explorer_stft
    spectrogram = stft.analyse(listening.samples)
    noise_psd, known = context.explorer_psd(spectrogram), context.noise_of_explorer()
    if known is not None and context.tools.in_noise is not None:
        seen = context.tools.in_noise.observe(
            spectrogram,
            stft.frequencies,
            listening.heading,
            listening.aboard,
            known,
            period=stft.period,
            tonal=context.tonal(stft, listening.samples, listening.rotor_speeds),
        )
    else:
        seen = context.tools.explorer.observe(
            spectrogram, stft.frequencies, listening.heading, noise_psd, frame_period=stft.period
        )
    return at_height(context, seen)


def observe_turned(context: Context, explorer: TurningExplorer, turned: Turned) -> Observation:
    """Let the explorer condense what was heard while the array turned."""
    stft = context.tools.explorer_stft
    noise_psd, known = context.explorer_psd(turned.frames(stft)), context.noise_of_explorer()
    in_noise = context.tools.in_noise
    if known is None or in_noise is None:
        return at_height(context, turning.observe(explorer, stft, turned, noise_psd))

    def observe(spectrogram: Complex, heading: float, aboard: float, tonal: Marks | None) -> Observation:
        return in_noise.observe(spectrogram, stft.frequencies, heading, aboard, known, period=stft.period, tonal=tonal)

    tonal = context.tonal(stft, turned.samples, turned.rotor_speeds)
    return at_height(context, turning.observe_in_noise(stft, turned, observe, tonal))


def at_height(context: Context, seen: Observation) -> Observation:
    """The observation with the height of the array, where that is known."""
    height = None if context.last is None else context.last.attitude.height
    return seen if height is None else replace(seen, height=height)


def say_belief(context: Context, *, final: bool) -> None:
    """Say what the explorer believes after the orientations heard so far."""
    context.publish(SourcesEstimated(context.time, context.beliefs[-1], context.rotations, final))


def certain(context: Context) -> bool:
    """Whether enough has been heard: the explorer says so, not before the least number of rotations.

    While the array turns there are none: the explorer itself sees to it that it has turned far enough. Of an explorer
    that believed in more sources right before it is not believed.
    """
    enough = context.tools.turning is not None or context.rotations >= context.settings.min_rotations
    fewer = any(before.k > context.beliefs[-1].k for before in context.beliefs[-2:])
    return enough and not fewer and context.beliefs[-1].certain


def steady(beliefs: Sequence[Estimate]) -> bool:
    """Whether the latest beliefs agree on K and every azimuth, and the last one is sharp about every source."""
    latest = beliefs[-STEADY:]
    if len(latest) < STEADY or latest[-1].k < FEWEST:
        return False
    sharp = all(s.resolved and s.nominal <= SHARP and s.confidence >= TRUSTED for s in latest[-1].sources)
    return sharp and all(agree(latest[-1], other) for other in latest)


def agree(one: Estimate, other: Estimate) -> bool:
    """Whether two beliefs hold the same sources at nearly the same azimuths, in any order."""
    return one.k == other.k == len(set(matched(one.azimuths, other, NEARLY).values()))


def matched(azimuths: ArrayLike, estimate: Estimate, near: float = SELF) -> dict[int, int]:
    """Find the source nearest to every azimuth [rad], {index of the azimuth: source}; none where nobody is near."""
    if not estimate.sources:
        return {}
    apart = np.abs(difference(np.asarray(azimuths)[:, None], estimate.azimuths))
    return {i: int(row.argmin()) for i, row in enumerate(apart) if row.min() <= near}
