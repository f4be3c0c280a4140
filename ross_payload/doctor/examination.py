"""Every check in the order in which a person would look; those of microphones and actuator are here.

The microphones are listened to; the actuator is made, never opened: nothing moves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NoReturn

import numpy as np

from ross_payload.actuators.registry import checked_options, describe, open_actuator
from ross_payload.actuators.tb6600.pulse_segments import RECORDING
from ross_payload.audio.audio_health import HealthMonitor
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.open_source import open_source
from ross_payload.calibration.channel_check import channel_troubles
from ross_payload.config import Config
from ross_payload.config.array_presets import PRESETS
from ross_payload.doctor import computer_checks, speed, wire_checks
from ross_payload.doctor.findings import Finding, Verdict, fail, ok, warn
from ross_payload.doctor.machine import Machine
from ross_payload.errors import ActuatorError, AudioEnded, RossError
from ross_payload.health import AudioHealth, AudioTrouble
from ross_payload.interfaces import Capabilities, Clock, Samples, Services
from ross_payload.service.check import check as refuse_what_cannot_run

Check = Callable[[Config, Machine], Iterator[Finding]]
SPACING_TOLERANCE = 0.05  # share by which a spacing may differ from that of a known array: 3 deg off at 20 deg
LISTENING_S = 4.0
LEAST_S = 3.0  # of that: the slowest judgement of the microphones takes so long
SOFTEST_DB = -100.0  # re full scale: the noise of any microphone is louder
OTHER_RATE = 0.1  # share of what should have come that is lost for another reason than a busy computer
CHECK_WIRING = (
    "check the cable and audio.channels: `ross devices --tap`; some firmwares of arrays give zeros:"
    " docs/how-to/microphones"
)
RAW = "name raw channels in audio.channels; some arrays need another firmware for them: docs/how-to/microphones"
TROUBLES: dict[AudioTrouble, tuple[Verdict, str, str]] = {
    AudioTrouble.ABSENT: (Verdict.FAIL, "no audio arrives", "plug them in; `ross devices` lists what there is"),
    AudioTrouble.DEAD_1: (Verdict.FAIL, "microphone 1 is dead", CHECK_WIRING),
    AudioTrouble.DEAD_2: (Verdict.FAIL, "microphone 2 is dead", CHECK_WIRING),
    AudioTrouble.IDENTICAL: (Verdict.FAIL, "both channels are one microphone", CHECK_WIRING),
    AudioTrouble.INVERTED: (Verdict.FAIL, "one microphone has the wrong polarity", "set audio.invert for one of them"),
    AudioTrouble.OFFSET: (
        Verdict.WARN,
        "a DC offset far above the noise",
        "check the supply and the preamp",
    ),
    AudioTrouble.CLIPPING: (Verdict.WARN, "samples at full scale", "turn the gain of the card down: alsamixer"),
    AudioTrouble.LOST: (Verdict.WARN, "samples lost", "raise audio.latency_ms; use another USB port"),
}


def microphones(config: Config, clock: Clock) -> Iterator[Finding]:
    """Whether audio arrives from both microphones, and how it is."""
    try:
        health, samples = measured(config, clock)
    except RossError as error:
        yield fail("microphones", str(error), "`ross devices` lists what there is; is ross.service using them?")
        return
    heard_s = samples.shape[1] / config.audio.rate_hz
    if heard_s < LEAST_S:
        expected = f"expected {LISTENING_S:g} s of audio, got {heard_s:.1f} s"
        yield fail("microphones", expected, "name a source that lasts longer: `ross devices` lists what there is")
        return
    found = [TROUBLES[each] for each in TROUBLES if each in health.trouble]
    if AudioTrouble.LOST in health.trouble and health.lost > OTHER_RATE * samples.shape[1]:
        found[found.index(TROUBLES[AudioTrouble.LOST])] = _other_rate(config, health.lost, heard_s)
    for verdict, text, todo in found:
        yield Finding("microphones", verdict, text, todo)
    named = set() if any(verdict is Verdict.FAIL for verdict, _, _ in found) else set(processed(config, samples))
    for text in sorted(named):
        yield fail("channels", text, RAW)
    if found or named:
        return
    levels = " and ".join(f"{level:.0f}" for level in health.level_db)
    heard = f"{config.audio.source}, levels {levels} dB re full scale"
    if max(health.level_db) < SOFTEST_DB:
        yield warn(
            "microphones", f"hardly any sound: {heard}", "are they muted? turn the gain of the card up: alsamixer"
        )
    else:
        yield ok("microphones", heard)


def _other_rate(config: Config, lost: int, heard_s: float) -> tuple[Verdict, str, str]:
    """What is told when more samples are lost, or come too fast, than a computer that is too busy misses."""
    rate = config.audio.rate_hz
    todo = f"does the source send at another rate than audio.rate_hz = {rate}? if not, raise audio.latency_ms"
    return Verdict.WARN, f"{lost / rate:.1f} s of samples lost, or too many, in {heard_s:.0f} s", todo


def processed(config: Config, samples: Samples) -> Iterator[str]:
    """Say which channels are no raw microphones, by their numbers in the configuration."""
    array, channels = config.array, ChannelMap.of(config.audio).channels
    for each in channel_troubles(samples, config.audio.rate_hz, array.spacing_m, array.speed_of_sound_m_s):
        which = (
            f"channels {channels[0]} and {channels[1]}" if each.channel is None else f"channel {channels[each.channel]}"
        )
        yield f"{which} {each.found}"


def measured(config: Config, clock: Clock) -> tuple[AudioHealth, Samples]:
    """Listen, at most to the end of a file; return how the microphones are, and what was heard (2, n).

    Raises
    ------
    RossError
        When they cannot be opened.
    """
    with open_source(config, clock) as source:
        monitor = HealthMonitor(config, source)
        heard = [np.zeros((2, 0), np.float32)]
        try:
            for _ in range(round(LISTENING_S * config.audio.rate_hz / config.hop)):
                block = source.read(config.hop)
                monitor.listen(block)
                heard.append(block.samples)
        except AudioEnded:
            pass
        return monitor.health(), np.concatenate(heard, axis=1)


def array(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether channels and spacing are those of two microphones of the array that the configuration names."""
    preset, channels = config.audio.preset, config.audio.microphone_channels
    told, known = config.array.spacing_m, config.audio.known_spacing
    places = PRESETS[preset].places if preset in PRESETS else {}
    for channel in channels if places else ():
        if channel not in places:
            raw = ", ".join(map(str, places))
            yield fail("array", f"channel {channel} of '{preset}' is no raw microphone; these are: {raw}", RAW)
            return
    if known is not None and abs(told / known - 1) > SPACING_TOLERANCE:
        apart = f"microphones {channels[0]} and {channels[1]} of '{preset}' are {1e3 * known:.1f} mm apart"
        found = f"spacing_m is {1e3 * told:.1f} mm, but {apart}"
        yield warn("array", found, "leave array.spacing_m out, or measure it: `ross calibrate`")
    elif known is None and "spacing_m" not in config.array.model_fields_set:
        found = f"the spacing is not configured: {1e3 * told:.0f} mm is assumed"
        yield warn("array", found, "array.spacing_m: use a ruler, then `ross calibrate`")
    else:
        of = f" of '{preset}'" if preset else ""
        yield ok("array", f"channels {channels[0]} and {channels[1]}{of}, {1e3 * told:.1f} mm apart")


def actuator(config: Config, machine: Machine, clock: Clock) -> Iterator[Finding]:
    """Whether the back end is there, its options are right, and its limits let the array reach every axis."""
    kind = config.actuator.kind
    try:
        capabilities = open_actuator(config, Services(clock, _closed)).capabilities
    except RossError as error:
        yield fail("actuator", str(error), "see `ross actuators` and docs/reference/configuration")
        return
    origin = next((row.origin for row in describe() if row.name == kind), "")
    if getattr(checked_options(config), "port", "") == RECORDING:
        yield warn("actuator", f"{kind} keeps its pulses in memory: nothing will turn", "name a wire: options.port")
    elif origin.startswith("ross_sim."):
        yield warn("actuator", f"{kind} is simulated: nothing will turn", "choose another actuator.kind")
    else:
        yield ok("actuator", f"{kind}, feedback {capabilities.feedback}")
    yield from _travel(config, capabilities)


def autostart(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether something turns without being asked."""
    if config.service.autostart == "nothing":
        yield ok("autostart", "nothing turns until it is commanded")
    else:
        found = f"'{config.service.autostart}' at every start, also after a crash, unless it was stopped by a command"
        yield warn("autostart", found, "service.autostart = 'nothing', where people may stand near the array")


def _closed(url: str) -> NoReturn:
    raise ActuatorError(f"the doctor does not open wires, got '{url}'")


def _travel(config: Config, capabilities: Capabilities) -> Iterator[Finding]:
    """An array of two microphones has an axis and no front: half a turn reaches every alignment."""
    travel = capabilities.upper - capabilities.lower
    found = f"{math.degrees(travel):.0f} deg of travel"
    if travel < math.pi - 1e-6:
        todo = "widen guard.lower_deg and upper_deg to 180 deg in all, or some alignments are out of reach"
        yield warn("limits", found, todo)
    else:
        yield ok("limits", f"{found}: every axis can be reached")
    longest = _duration(travel, capabilities)
    if longest > config.guard.max_move_s:
        todo = "raise guard.max_move_s, or the longest move ends as a fault"
        yield fail("limits", f"the longest move takes {longest:.1f} s, max_move_s = {config.guard.max_move_s:g}", todo)


def _duration(angle: float, capabilities: Capabilities) -> float:
    """Rest to rest along a trapezoid [s]: angle / v + v / a, or 2 sqrt(angle / a) when v is never reached."""
    speed, acceleration = capabilities.max_speed, capabilities.max_acceleration
    if angle < speed**2 / acceleration:
        return 2 * math.sqrt(angle / acceleration)
    return angle / speed + speed / acceleration


CHECKS: tuple[Check, ...] = (
    computer_checks.python, computer_checks.clock, computer_checks.heat,
    computer_checks.priority, computer_checks.power,
    wire_checks.extras, wire_checks.serial, wire_checks.can, wire_checks.links, wire_checks.identity,
    computer_checks.state, computer_checks.recordings, computer_checks.voice, autostart, array,
)  # fmt: skip


def examine(config: Config, machine: Machine, clock: Clock, first: Sequence[Check] = CHECKS) -> Iterator[Finding]:
    """Yield what every check finds, as soon as it is found; a check that breaks hurts no other.

    When nothing has failed, what `ross run` would refuse has.
    """
    checks: list[tuple[str, Callable[[], Iterator[Finding]]]] = [
        (check.__name__, partial(check, config, machine)) for check in first
    ]
    checks.append(("microphones", partial(microphones, config, clock)))
    checks.append(("actuator", partial(actuator, config, machine, clock)))
    checks.append(("speed", partial(speed.headroom, config, clock)))
    failed = False
    for name, check in checks:
        try:
            for finding in check():
                failed = failed or finding.verdict is Verdict.FAIL
                yield finding
        except Exception as error:  # a computer that surprises one check is what the others are for
            failed = True
            yield fail(name, f"the check itself failed: {error!r}", "please report this line")
    if not failed:
        yield from _refusal(config)


def _refusal(config: Config) -> Iterator[Finding]:
    try:
        refuse_what_cannot_run(config)
    except RossError as error:
        yield fail("configuration", str(error), "`ross run` refuses this: see docs/reference/configuration")
