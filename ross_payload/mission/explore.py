"""Explore: rotate in steps, listen at each, find K and every azimuth (Algorithm 1 with all orientations at once)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ross_payload.events import Estimate, NoiseMeasured, OrientationHeard, SourcesEstimated, State
from ross_payload.interfaces import Observation
from ross_payload.mission.context import Context, Listening, Step, listen, turn


def lead_in(context: Context) -> Step[None]:
    """Listen before anything turns: the quiet, when there is one, tells the noise."""
    context.enter(State.LEAD_IN)
    context.lead_in = yield from listen(context, context.settings.lead_in)


def explore(context: Context) -> Step[Estimate]:
    """Visit orientations until the explorer is certain or the schedule ends; return its last belief."""
    settings = context.settings
    observations: list[Observation] = []
    context.explored = []
    estimate = Estimate(())
    joints = list(schedule(context))
    for r, joint in enumerate(joints):
        if r:
            context.enter(State.EXPLORE_TURN, f"rotation {r} of {settings.max_rotations}")
            yield from turn(context, joint, f"rotation {r}")
        observations.append((yield from _orientation(context, r)))
        estimate = context.tools.explorer.estimate(observations)
        final = r == len(joints) - 1 or (r >= settings.min_rotations and estimate.certain)
        context.say(SourcesEstimated(context.time, estimate, r, final))
        if final:
            break
    return estimate


def _orientation(context: Context, r: int) -> Step[Observation]:
    context.enter(State.EXPLORE_LISTEN, f"orientation {r}")
    samples = yield from listen(context, context.settings.unit)
    stft = context.tools.explorer_stft
    spectrogram = stft.analyse(samples)
    first = stft.frame not in context.noise_psd
    noise_psd = context.psd(stft, spectrogram)
    if first:
        _say_noise(context, noise_psd)
    here = context.here
    context.explored.append(Listening(here.heading_end, samples))
    seen = context.tools.explorer.observe(spectrogram, stft.frequencies, here.heading_end, noise_psd)
    context.say(OrientationHeard(context.time, r, seen.heading, here.joint, seen.grid, seen.density, seen.peaks))
    return seen


def _say_noise(context: Context, noise_psd: np.ndarray | None) -> None:
    seconds = context.settings.lead_in
    level = None
    if noise_psd is not None and context.lead_in is not None:
        level = float(10 * np.log10(np.mean(context.lead_in[0].astype(np.float64) ** 2) + 1e-20))
    context.say(NoiseMeasured(context.time, level, seconds))


def schedule(context: Context) -> Iterator[float]:
    """Joint angles [rad] of the exploration: equal steps from here, first towards the side with more room.

    What does not fit on that side is taken on the other, stepping away from the start.
    """
    settings, start = context.settings, context.here.joint
    room_up, room_down = settings.upper - start, start - settings.lower
    sign = 1.0 if room_up >= min(room_down, settings.max_rotations * settings.rotation) else -1.0
    ahead = int(((room_up if sign > 0 else room_down) + 1e-9) // settings.rotation)
    behind = int(((room_down if sign > 0 else room_up) + 1e-9) // settings.rotation)
    first = range(1, min(ahead, settings.max_rotations) + 1)
    second = range(1, min(behind, settings.max_rotations - len(first)) + 1)
    yield start
    yield from (start + sign * k * settings.rotation for k in first)
    yield from (start - sign * k * settings.rotation for k in second)
