"""The sound of a flight: what of it lies beside its log, and when in the flight it begins.

A session folder has ``audio.wav`` and, where voices were recorded, FLAC files that go with it sample by sample. The
results of a simulation have ``mixture.wav``, from its start on, and ``target.wav``, from the moment that the report
tells. Samples have the time of the payload's computer; the log has that of whoever wrote it, and ROSS_STATUS tells
both, or how much audio has come where it tells UNIX time instead. What was unpacked from an MCAP file has WAV files,
and tells when they begin on the clock of the file.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import soundfile

from ross_payload.bounded_files import read_bounded
from ross_payload.ground.flights.reading import LOGS, UNPACKED, Flight, unpacked_sound
from ross_payload.ground.model.payload_state import mission_time_between
from ross_payload.json_values import are_finite, encodable
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.tunnel import unwrapped
from ross_protocols.mavlink.values import Status

SESSION, SIMULATION = LOGS
MIXTURE, TARGET = "mixture", "target"
LOOKED_AT = 400  # messages, to know how far the clocks are apart
LATEST_S = 1e9  # of a clock that counts from a start: 31 years
LARGEST_REPORT = 1 << 20  # [bytes]
LONGEST_LINE = 1 << 16  # [bytes]
STATUS = "ROSS_STATUS"
_CARRIERS = [number for number, message in MESSAGES.items() if message.msgname == STATUS] + [
    common.MAVLINK_MSG_ID_TUNNEL
]


@dataclass(frozen=True, slots=True)
class Track:
    """One recording that goes with a flight."""

    name: str  # mixture, target, source-0 ...
    path: Path
    begin: float  # of its first sample, after the flight's first frame [s]
    duration: float  # [s]
    rate: int  # [Hz]
    channels: int


@dataclass(frozen=True, slots=True)
class _Instant:
    """When a sample was heard."""

    clock: float  # of the payload's computer, since its start [s]
    audio: float  # that had come before, as the mission time of ROSS_STATUS [s]


@dataclass(frozen=True, slots=True)
class _Begins:
    """When tracks begin."""

    first: _Instant
    after: dict[str, float]  # how long after that [s], by track


START = _Instant(0.0, 0.0)


def sound_files(log: Path) -> dict[str, Path]:
    """Return the files with sound that go with a log, or with a folder that has one, by the names of their tracks."""
    log = next((log / name for name in (*LOGS, UNPACKED) if (log / name).is_file()), log) if log.is_dir() else log
    folder = log.parent
    if log.name == SESSION:
        voices = {path.stem: path for path in sorted(folder.glob("*.flac"))}
        found = {MIXTURE: folder / "audio.wav", **voices}
    elif log.name == SIMULATION:
        found = {MIXTURE: folder / "mixture.wav", TARGET: folder / "target.wav"}
    elif log.name == UNPACKED:
        found = {path.stem: path for path in sorted(folder.glob("*.wav"))}
    else:
        return {}
    readable = {name: path for name, path in found.items() if path.is_file() and not path.is_symlink()}
    return {name: path for name, path in readable.items() if encodable(name) == name}  # the page tells them in UTF-8


def tracks_of(flight: Flight) -> tuple[Track, ...]:
    """Return the recordings of a flight; what cannot be read is left out."""
    files = sound_files(flight.path)
    unpacked = unpacked_sound(flight.path)
    if unpacked is not None:
        origin = flight.start or 0.0 if unpacked.origin is None else unpacked.origin
        return tuple(_tracks(files, {name: begin - origin for name, begin in unpacked.begins.items()}))
    begins = _begins(flight.path, files) if files else None
    first = None if begins is None else _in_flight(flight, begins.first)
    if begins is None or first is None:
        return ()
    return tuple(_tracks(files, {name: first + after for name, after in begins.after.items()}))


def _tracks(files: Mapping[str, Path], begins: Mapping[str, float]) -> Iterator[Track]:
    """Yield those that can be read and whose begin is known."""
    for name, path in files.items():
        try:
            about = soundfile.info(os.fsencode(path))  # which encodes no path that is not UTF-8
        except (OSError, RuntimeError):  # soundfile's own errors are RuntimeErrors
            continue
        if name in begins:
            yield Track(name, path, begins[name], about.duration, about.samplerate, about.channels)


def _in_flight(flight: Flight, instant: _Instant) -> float | None:
    """Return when in the flight something was heard [s]; None: the log does not tell.

    What was underway for the shortest time tells it best; by the audio that has come, its way through the payload's
    computer is in it.
    """
    which = np.flatnonzero(np.isin(flight.index.message, _CARRIERS))[:LOOKED_AT]
    by_clock, by_audio = [], []
    for at, packet in flight.packets(which):
        content = unwrapped(packet) if packet.sender in flight.payloads else None
        status = None if content is None else content.value
        if not isinstance(status, Status):
            continue
        if not status.time_unix:
            by_clock.append(at - (status.time_usec / 1e6 - instant.clock))
        elif (audio := mission_time_between(instant.audio, status.mission_time)) > 0:
            by_audio.append(at - audio)
    return min(by_clock or by_audio, default=None)


def _begins(log: Path, files: Mapping[str, Path]) -> _Begins | None:
    """Return when the tracks begin, as far as the files beside a log tell; None: they do not."""
    try:
        if log.name == SESSION:
            return _Begins(_first_input(log.parent, _rate(files)), dict.fromkeys(files, 0.0))
        report = json.loads(read_bounded(log.parent / "report.json", LARGEST_REPORT))
        return _Begins(START, {MIXTURE: 0.0, TARGET: _moment(report["heard_from_s"])})
    except (OSError, ValueError, KeyError, TypeError, RecursionError, OverflowError):
        return _Begins(START, {MIXTURE: 0.0}) if log.name == SIMULATION else None


def _first_input(folder: Path, rate: int) -> _Instant:
    """Return when the recording of a session begins, which is sampled at a rate [Hz]."""
    with (folder / "inputs.jsonl").open("rb") as lines:
        values = json.loads(lines.readline(LONGEST_LINE))
    return _Instant(_moment(values["time"]), values["index"] / rate)


def _moment(value: Any) -> float:
    """Return a time [s] that a flight can have; ValueError: it is none."""
    if not are_finite(value) or abs(value) > LATEST_S:
        raise ValueError(f"expected a time, got {value!r}")
    return float(value)


def _rate(files: Mapping[str, Path]) -> int:
    """Return the sampling rate that all tracks of a session have [Hz].

    Raises
    ------
    ValueError
        When none can be read.
    """
    for path in files.values():
        with suppress(OSError, RuntimeError):  # soundfile's own errors are RuntimeErrors
            return int(soundfile.info(os.fsencode(path)).samplerate)
    raise ValueError("no track can be read")
