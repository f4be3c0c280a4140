"""One orientation: listen at one heading, tell the explorer, and hear what it believes now."""

from __future__ import annotations

from ross_payload.events import Estimate, OrientationHeard, SourcesEstimated
from ross_payload.interfaces import Observation
from ross_payload.mission.context import Context, Listening, Step
from ross_payload.mission.follow import attend


def orientation(context: Context, seconds: float) -> Step[Estimate]:
    """Listen for ``seconds`` at one heading; return what the explorer believes after this orientation."""
    heard = yield from attend(context, seconds)
    context.explored.append(heard)
    seen = observe(context, heard)
    r = len(context.observations)
    context.observations.append(seen)
    context.beliefs.append(context.tools.explorer.estimate(context.observations))
    context.say(
        OrientationHeard(context.time, r, seen.heading, context.here.joint, seen.grid, seen.density, seen.peaks)
    )
    return context.beliefs[-1]


def observe(context: Context, heard: Listening) -> Observation:
    """Let the explorer condense what was heard at one heading."""
    stft = context.tools.explorer_stft
    spectrogram = stft.analyse(heard.samples)
    noise_psd = context.psd(stft, spectrogram)
    return context.tools.explorer.observe(
        spectrogram, stft.frequencies, heard.heading, noise_psd, frame_period=stft.period
    )


def say_belief(context: Context, *, final: bool) -> None:
    """Say what the explorer believes after the orientations heard so far."""
    context.say(SourcesEstimated(context.time, context.beliefs[-1], len(context.explored) - 1, final))


def certain(context: Context) -> bool:
    """Whether enough has been heard: the explorer says so, not before the least number of rotations."""
    return len(context.explored) > context.settings.min_rotations and context.beliefs[-1].certain
