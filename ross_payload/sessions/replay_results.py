"""What a replay leaves: events.jsonl, the separated voices, replay.json."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import MISSING, fields
from itertools import starmap
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ross_payload import events
from ross_payload.atomic_files import json_text, make_private, replacing
from ross_payload.audio.audio_files import gain_in_files, write_wav
from ross_payload.errors import ConfigError, OutputError, refused_as
from ross_payload.events import Event, GroupScore, Separated, SourceEstimate, SourcesEstimated
from ross_payload.interfaces import Samples
from ross_payload.sessions.divergence import Replayed
from ross_payload.sessions.manifest import versions
from ross_payload.sessions.session_reader import RecordedSession

E = TypeVar("E", bound=Event)
OWN = 0o600  # who may read what people have said
VOICE = re.compile(r"target\.wav|group-\d+\.wav")


@contextmanager
def prepared(folder: Path) -> Iterator[None]:
    """Make the folder for the results; when what is done meanwhile fails, an empty one that was made is removed.

    Raises
    ------
    ConfigError
        When it cannot be made or written, or is a session.
    """
    with refused_as(ConfigError, f"--out {folder}: cannot be written"):
        made = not os.path.lexists(folder)
        make_private(folder)  # voices of people
    if (folder / "session.json").exists():
        raise ConfigError(f"--out: expected a folder for the results, got the session {folder}")
    if not os.access(folder, os.W_OK):
        raise ConfigError(f"--out {folder}: cannot be written: permission denied")
    try:
        yield
    except BaseException:
        if made:
            with suppress(OSError):
                folder.rmdir()
        raise


def report(session: RecordedSession, replay_state: Replayed, rate: int) -> dict[str, Any]:
    """Everything worth keeping of a replay, as plain values: no paths, the same on every rerun."""
    known, recorded = session.manifest, session.events()
    estimated, separated = latest(replay_state, SourcesEstimated), latest(replay_state, Separated)
    return {
        "identical": identical(replay_state.lines, recorded, cut_off=known.end is None),
        "first_difference": difference(replay_state.lines, recorded),
        "ended_early": replay_state.early,
        "outcome": None if replay_state.result is None else replay_state.result.outcome.name.lower(),
        "reason": "" if replay_state.result is None else replay_state.result.reason,
        "replayed_s": round(replay_state.samples / rate, 3),
        "inputs": replay_state.inputs,
        "events": len(replay_state.lines),
        "frame": "earth" if replay_state.earth else "mount",
        "sources": [] if estimated is None else [_source(source) for source in estimated.estimate.sources],
        "groups": []
        if separated is None
        else [_group(g, group, separated) for g, group in enumerate(separated.groups)],
        "recorded": {"kind": known.kind, "started": known.started, "end": known.end, "versions": known.versions},
        "versions": versions(),
    }


def identical(ours: Sequence[str], recorded: Sequence[str], *, cut_off: bool) -> bool:
    """Whether two event logs are the same; of a session that was cut off, as far as both go."""
    whole = cut_off or len(ours) == len(recorded)
    return whole and all(starmap(_same, zip(ours, recorded, strict=False)))


def difference(ours: Sequence[str], recorded: Sequence[str]) -> dict[str, Any] | None:
    """Return the first event that differs, None when none does before one of the logs ends."""
    for number, (one, other) in enumerate(zip(ours, recorded, strict=False), 1):
        if not _same(one, other):
            now, was = json.loads(one), json.loads(other)
            return {"line": number, "recorded": [was["event"], was["time"]], "replayed": [now["event"], now["time"]]}
    return None


def _same(ours: str, recorded: str) -> bool:
    """Whether two lines are the same event; what a field that is younger than the recording tells is its default."""
    if ours == recorded:
        return True
    now, was = json.loads(ours), json.loads(recorded)
    kind = vars(events).get(now["event"])
    known = fields(kind) if isinstance(kind, type) and issubclass(kind, Event) else ()
    younger = {each.name: each.default for each in known if each.name not in was and each.default is not MISSING}
    return bool(now == younger | was)


def write(folder: Path, values: dict[str, Any], replay_state: Replayed, rate: int) -> None:
    """Write events.jsonl, the voices of the last period and replay.json; voices of an earlier replay are removed.

    Raises
    ------
    OutputError
        When the disk is full or gone.
    """
    voices = voices_of(latest(replay_state, Separated))
    for name, voice in voices.items():
        write_wav(folder / name, voice, rate)
    with refused_as(OutputError, f"{folder}: cannot be written"):
        for path in folder.iterdir():
            if VOICE.fullmatch(path.name) and path.name not in voices:
                path.unlink()
        for name, text in (("events.jsonl", "".join(replay_state.lines)), ("replay.json", json_text(values))):
            with replacing(folder / name, OWN) as part:
                part.write_text(text, encoding="utf-8")


def latest(replay_state: Replayed, kind: type[E]) -> E | None:
    """Return the last event of a kind, or None."""
    event = replay_state.latest.get(kind)
    return event if isinstance(event, kind) else None


def voices_of(separated: Separated | None) -> dict[str, Samples]:
    """Return the separated voices by the names of their files, all as much softer as `softer_by` says."""
    if separated is None:
        return {}
    gain, target = np.float32(gain_in_files(separated.voices)), separated.target
    names = ("target.wav" if index == target else f"group-{index}.wav" for index in range(len(separated.voices)))
    return {name: gain * voice for name, voice in zip(names, separated.voices, strict=True)}


def softer_by(separated: Separated | None) -> float:
    """Return how much softer all voices of a period are in their files, so that none exceeds full scale [dB]."""
    return 0.0 if separated is None else -20 * math.log10(gain_in_files(separated.voices))


def _source(source: SourceEstimate) -> dict[str, Any]:
    return {
        "azimuth_deg": round(math.degrees(source.azimuth), 3),
        "sigma_deg": round(math.degrees(source.sigma), 3),
        "elevation_deg": None if source.elevation is None else round(math.degrees(source.elevation), 3),
        "confidence": round(source.confidence, 4),
        "front_back_resolved": source.resolved,
    }


def _group(index: int, group: GroupScore, separated: Separated) -> dict[str, Any]:
    return {
        "sources": list(group.members),
        "target": index == separated.target,
        "score": round(group.value, 3) if math.isfinite(group.value) else None,
        "accepted": bool(group.accepted),
        "separator": separated.method,
        "why": separated.why,
    }
