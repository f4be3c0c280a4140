"""How a payload is, part by part, with words for whoever must act.

``level`` is ``good``, ``watch`` (look now and then), ``act`` (something must be done, ``words`` say what) or
``unknown``.
"""

from __future__ import annotations

import math
from typing import Any

from ross_payload.ground.model.payload_state import PayloadState, twins
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.field_converters import wrap
from ross_protocols.mavlink.values import LinkReport, RecordingState

GOOD, WATCH, ACT, UNKNOWN = "good", "watch", "act", "unknown"
LEVELS = {GOOD: "Good", WATCH: "Warning", ACT: "Critical", UNKNOWN: "No data"}  # in words
MOST_BACKLOG_S = 2.0  # [s] of audio that waits: the computer is too slow
MOST_LOSS = 0.1  # share of frames that may be lost before somebody looks
HOT_DEGC, BUSY, FULL = 80.0, 0.95, 0.95  # [degC], share of a core, share of the memory
REMEDIES = {
    "CLIPPING": "clipping: lower the gain",
    "DEAD_1": "microphone 1 is silent: check its wiring",
    "DEAD_2": "microphone 2 is silent: check its wiring",
    "OFFSET": "DC offset: check the coupling",
    "IDENTICAL": "both channels carry the same microphone: check the channel map",
    "INVERTED": "one microphone is inverted: swap its wires or set the polarity",
    "LOST": "samples were lost: the computer or the USB port is overloaded",
    "ABSENT": "no audio: check the device",
}  # by entry of ROSS_AUDIO_TROUBLE


LINK_FIELDS = (
    "url", "up", "autopilot", "sent", "dropped", "received", "lost", "bad", "refused", "reconnects",
)  # fmt: skip


def condition(known: PayloadState) -> dict[str, Any]:
    """Return the condition of every part."""
    return {
        "microphones": _microphones(known),
        "actuator": _actuator(known),
        "links": [_link(each) for each in known.links],
        "reception": _reception(known),
        "processor": _processor(known),
        "recording": _recording(known),
        "listening": _listening(known),
    }


def worst(parts: dict[str, Any]) -> str:
    """Return the worst level among all parts.

    >>> worst({"processor": {"level": "good"}, "links": [{"level": "act"}]})
    'act'
    """
    flat = [each for part in parts.values() for each in (part if isinstance(part, list) else [part])]
    return next((level for level in (ACT, WATCH, GOOD) if any(each["level"] == level for each in flat)), UNKNOWN)


def _microphones(known: PayloadState) -> dict[str, Any]:
    audio = known.audio
    if audio is None:
        return {"level": UNKNOWN, "words": "no data"}
    troubles = [
        words for name, words in REMEDIES.items() if audio.trouble & getattr(ross, f"ROSS_AUDIO_TROUBLE_{name}")
    ]
    slow = audio.waiting > MOST_BACKLOG_S
    level = ACT if troubles else WATCH if slow else GOOD
    words = "; ".join(troubles) or (
        f"audio backlog of {audio.waiting:.1f} s: the computer is too slow" if slow else "both receive sound"
    )
    return {
        "level": level,
        "words": words,
        "level_db": list(audio.level),
        "peak_db": list(audio.peak),
        "lost": audio.lost,
        "reopened": audio.reopened,
        "waiting": audio.waiting,
        "rate": audio.rate,
    }


def _actuator(known: PayloadState) -> dict[str, Any]:
    status = known.status
    if status is None or not status.actuator_present:
        at = None if status is None else known.status_at
        return {"level": UNKNOWN, "words": "no data", "at": at}
    if status.fault:
        level, words = ACT, "fault: see the events, then home or rearm"
    elif not status.homed:
        level, words = ACT, "not homed: command home"
    else:
        level, words = GOOD, "settled" if status.settled else "turning"
    return {
        "level": level,
        "words": words,
        "at": known.status_at,
        "error": _apart(status.heading, status.heading_goal),
        "open_loop": status.open_loop,
    }


def _apart(heading: float | None, goal: float | None) -> float | None:
    """How far the heading is from its goal [deg]; None: there is no goal."""
    return None if heading is None or goal is None else abs(math.degrees(wrap(goal - heading)))


def _link(link: LinkReport) -> dict[str, Any]:
    share = _share(link.lost, link.received)
    level = WATCH if not link.up or (share or 0.0) > MOST_LOSS else GOOD
    words = "loss unknown: messages reach the payload through a router"
    if share is not None:
        words = f"{share:.0%} of the messages to the payload lost"
    if not link.up:
        words = "not connected"
    return {"level": level, "words": words, **{name: getattr(link, name) for name in LINK_FIELDS}}


def _share(lost: int | None, received: int) -> float | None:
    """Which share of all frames was lost; None: nobody can tell."""
    return None if lost is None else lost / max(received + lost, 1)


def _reception(known: PayloadState) -> dict[str, Any]:
    """What reaches the listener; rates are differences of these counts between two looks."""
    counts = known.counts
    share = _share(counts.lost, counts.frames)
    if known.twin:
        level, words = ACT, twins(known.who)
    elif share is None:
        level, words = GOOD, "loss unknown: its frames come through a router"
    else:
        level, words = (WATCH if share > MOST_LOSS else GOOD), f"{share:.0%} of its messages lost"
    return {
        "level": level,
        "words": words,
        "frames": counts.frames,
        "bytes": counts.size,
        "lost": counts.lost,
        "malformed": counts.malformed,
    }


def _processor(known: PayloadState) -> dict[str, Any]:
    computer = known.computer
    if computer is None:
        return {"level": UNKNOWN, "words": "no data"}
    load = max(computer.loads, default=None)
    used, total = computer.memory_used, computer.memory_total
    memory = used / total if used is not None and total else None
    worries = [
        words
        for wrong, words in (
            (computer.temperature is not None and computer.temperature > HOT_DEGC, "hot: it will throttle"),
            (load is not None and load > BUSY, "one core is fully loaded"),
            (memory is not None and memory > FULL, "memory is almost full"),
        )
        if wrong
    ]
    return {
        "level": WATCH if worries else GOOD,
        "words": "; ".join(worries) or "load and temperature normal",
        "loads": list(computer.loads),
        "memory": memory,
        "temperature": computer.temperature,
        "uptime": computer.uptime,
    }


def _listening(known: PayloadState) -> dict[str, Any]:
    """Whether sound leaves the payload live, and whether that works."""
    if known.status is None and not known.streams:
        return {"level": UNKNOWN, "words": "no data", "on": False}
    faults = [f"stream {each.number}: {each.detail or 'see the events'}" for each in known.streams if each.fault]
    on = sum(each.on for each in known.streams)
    listened = known.status is not None and known.status.streaming
    words = f"{on} stream{'' if on == 1 else 's'} on{', listened to' if listened else ''}" if on or listened else "off"
    return {"level": ACT if faults else GOOD, "words": "; ".join(faults) or words, "on": listened}


def _recording(known: PayloadState) -> dict[str, Any]:
    recording = known.recording
    if recording is None:
        return {"level": UNKNOWN, "words": "no data", "on": False}
    stopped = recording.state in (RecordingState.FULL, RecordingState.BROKEN)
    on = recording.state == RecordingState.ON
    words = recording.reason or "stopped" if stopped else f"recording {recording.name}" if on else "off"
    return {
        "level": ACT if stopped else GOOD,
        "words": words,
        "on": on,
        "name": recording.name,
        "duration": recording.duration,
        "free": recording.free,
    }
