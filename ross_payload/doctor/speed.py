"""How much time exploring and separating take on this computer: the mission's own code on made-up voices, timed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ross_payload.computing import computing
from ross_payload.config import Config
from ross_payload.doctor.findings import Finding, fail, ok, warn
from ross_payload.dsp.steering import tdoa
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Clock, Observation, Samples
from ross_payload.localization.turning import Turned
from ross_payload.mission.context import Context, Listening
from ross_payload.mission.identify_target import separate
from ross_payload.mission.orientation_scan import observe, observe_turned
from ross_payload.mission.settings import Settings
from ross_payload.service.assemble import settings_of, tools_of

AZIMUTHS = (-1.2, 0.3, 1.9)  # of the made-up voices [rad]
SYLLABLE_S = 0.2  # [s]
HOPS_PER_S = 100  # [1/s]


@dataclass(frozen=True, slots=True)
class Cost:
    """Seconds of this computer per second of audio."""

    exploring: float
    separating: float


def headroom(config: Config, clock: Clock) -> Iterator[Finding]:
    """Compare what the mission costs with real time."""
    try:
        cost = rehearsed(config, clock)
    except ConfigError as error:
        yield fail("speed", str(error), "fix the configuration")
        return
    run, waits = config.exploit.run_s, config.exploit.run_s * cost.separating
    yield _judged("exploring", cost.exploring, config.explore.unit_s)
    if waits > config.audio.buffer_s:
        found = f"separating {run:g} s takes {waits:.1f} s, but audio.buffer_s = {config.audio.buffer_s:g}"
        yield fail("separating", found, "choose a cheaper exploit.separator, a shorter run_s or a lower rate_hz")
    else:
        yield _judged("separating", cost.separating, run)


def rehearsed(config: Config, clock: Clock) -> Cost:
    """Time one exploration of the least length and one separation of T_run."""
    settings = settings_of(config, -math.pi, math.pi)
    context = Context(settings, tools_of(config, None))
    estimate = Estimate(tuple(SourceEstimate(azimuth, 0.02, 1.0, resolved=True) for azimuth in AZIMUTHS))
    orientations = [_listening(config, settings, r) for r in range(settings.min_rotations + 1)]
    long = Listening(0.0, voices(config, 0.0, settings.run))
    with computing():
        separate(context, estimate, Listening(0.0, long.samples[:, : config.audio.rate_hz // 2]))  # loads its tables
        began = clock.now()
        for each in orientations:
            context.observations.append(_observed(context, each))
            context.tools.explorer.estimate(context.observations)
        explored = clock.now()
        separate(context, estimate, long)
        separated = clock.now()
    return Cost((explored - began) / (len(orientations) * settings.unit), (separated - explored) / settings.run)


def _listening(config: Config, settings: Settings, number: int) -> Listening:
    """What is heard at one orientation, or in a period in which the array turns: there every hop has its heading."""
    if not settings.periods:
        heading = number * settings.rotation
        return Listening(heading, voices(config, heading, settings.unit))
    turned, hops = settings.turn_rate * settings.unit, round(HOPS_PER_S * settings.unit)
    heading = (number + 0.5) * turned
    headings = heading + turned * ((np.arange(hops) + 0.5) / hops - 0.5)
    return Listening(heading, voices(config, heading, settings.unit), turned / 2, headings)


def _observed(context: Context, listening: Listening) -> Observation:
    explorer = context.tools.turning
    if explorer is None or listening.headings is None:
        return observe(context, listening)
    return observe_turned(context, explorer, Turned(listening.samples, listening.headings))


def voices(config: Config, heading: float, seconds: float) -> Samples:
    """Make three voices of noise in syllables, as both microphones hear them at a heading, (2, n)."""
    rate, rng = config.audio.rate_hz, np.random.default_rng(0)
    n = round(rate * seconds)
    frequencies = np.fft.rfftfreq(n, 1 / rate)
    tau = tdoa(np.array(AZIMUTHS), heading, config.array.spacing_m, config.array.speed_of_sound_m_s)
    heard = np.zeros((2, n))
    for delay in tau:
        loud = np.repeat(rng.random(math.ceil(seconds / SYLLABLE_S)) ** 3, round(SYLLABLE_S * rate))[:n]
        voice = np.fft.rfft(rng.standard_normal(n) * np.resize(loud, n)) / (1 + frequencies / 500)
        heard += np.fft.irfft(voice * np.exp(2j * np.pi * frequencies * np.array([[0.0], [delay]])), n)
    return (0.1 * heard + 1e-3 * rng.standard_normal((2, n))).astype(np.float32)


def _judged(what: str, cost: float, seconds: float) -> Finding:
    found = f"{cost:.2g} s per second of audio, {cost * seconds:.2g} s for {seconds:g} s"
    if cost <= 1.0:
        return ok(what, found)
    todo = "it blocks everything else: use a faster computer, a cheaper method or a lower audio.rate_hz"
    return warn(what, found, todo)
