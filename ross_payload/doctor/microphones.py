"""Checks of the microphones: open them as the payload does and listen for a few seconds."""

from __future__ import annotations

from collections.abc import Iterator

from ross_payload.audio.health import HealthMonitor
from ross_payload.audio.playback import FileSource
from ross_payload.audio.sources import open_source
from ross_payload.config import Config
from ross_payload.doctor.finding import Finding, Verdict, fail, ok
from ross_payload.errors import AudioEnded, RossError
from ross_payload.health import AudioHealth, AudioTrouble
from ross_payload.interfaces import Clock

SECONDS = 4.0  # the slowest judgement of the microphones takes three
WIRING = "check the cable and audio.channels: `ross devices --tap`"
SAYS: dict[AudioTrouble, tuple[Verdict, str, str]] = {
    AudioTrouble.ABSENT: (Verdict.FAIL, "no audio arrives", "plug them in; `ross devices` lists what there is"),
    AudioTrouble.DEAD_1: (Verdict.FAIL, "microphone 1 is dead", WIRING),
    AudioTrouble.DEAD_2: (Verdict.FAIL, "microphone 2 is dead", WIRING),
    AudioTrouble.IDENTICAL: (Verdict.FAIL, "both channels are one microphone", WIRING),
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
        health = heard(config, clock)
    except RossError as error:
        yield fail("microphones", str(error), "`ross devices` lists what there is; is ross.service using them?")
        return
    found = [SAYS[each] for each in SAYS if each in health.trouble]
    for verdict, text, todo in found:
        yield Finding("microphones", verdict, text, todo)
    if not found:
        levels = " and ".join(f"{level:.0f}" for level in health.level_db)
        yield ok("microphones", f"{config.audio.source}, levels {levels} dB re full scale")


def heard(config: Config, clock: Clock) -> AudioHealth:
    """Listen, at most to the end of a file; return how the microphones are.

    Raises
    ------
    RossError
        When they cannot be opened.
    """
    with open_source(config, clock) as source:
        ears = HealthMonitor(config, None if isinstance(source, FileSource) else source)
        try:
            for _ in range(round(SECONDS * config.audio.rate_hz / config.hop)):
                ears.listen(source.read(config.hop))
        except AudioEnded:
            pass
        return ears.health()
