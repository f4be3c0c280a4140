"""The sound of a flight: what of it lies beside its log, and when in the flight it begins.

A session folder has ``audio.wav`` and, where voices were recorded, FLAC files that go with it sample by sample. The
results of a simulation have ``mixture.wav``, from its start on, and ``target.wav``, from the moment that the report
tells. Samples have the payload's time; the log has that of whoever wrote it, and ROSS_STATUS tells both. What was
unpacked from an MCAP file has WAV files, and tells when they begin on the clock of the file.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import soundfile

from ross_payload.bounded_files import read_bounded
from ross_payload.ground.flights.reading import LOGS, UNPACKED, Flight, unpacked_sound
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.tunnel import unwrapped
from ross_protocols.mavlink.values import Status

SESSION, SIMULATION = LOGS
MIXTURE, TARGET = "mixture", "target"
LOOKED_AT = 400  # messages, to know how far the clocks are apart
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
    return {name: path for name, path in found.items() if path.is_file() and not path.is_symlink()}


def tracks_of(flight: Flight) -> tuple[Track, ...]:
    """Return the recordings of a flight; what cannot be read is left out."""
    files = sound_files(flight.path)
    unpacked = unpacked_sound(flight.path)
    if unpacked is not None:
        origin = flight.start or 0.0 if unpacked.origin is None else unpacked.origin
        return tuple(_tracks(files, {name: begin - origin for name, begin in unpacked.begins.items()}))
    ahead = _clock_difference(flight) if files else None
    if ahead is None:
        return ()
    begins = _begins(flight.path)
    if flight.path.name == SESSION and MIXTURE in begins:
        begins = dict.fromkeys(files, begins[MIXTURE])
    return tuple(_tracks(files, {name: begin + ahead for name, begin in begins.items()}))


def _tracks(files: Mapping[str, Path], begins: Mapping[str, float]) -> Iterator[Track]:
    """Yield those that can be read and whose begin is known."""
    for name, path in files.items():
        try:
            about = soundfile.info(path)
        except (OSError, RuntimeError):  # soundfile's own errors are RuntimeErrors
            continue
        if name in begins:
            yield Track(name, path, begins[name], about.duration, about.samplerate, about.channels)


def _clock_difference(flight: Flight) -> float | None:
    """Return the time in the flight less that on the payload's clock [s]; None: the log does not tell.

    What was underway for the shortest time tells it best.
    """
    which = np.flatnonzero(np.isin(flight.index.message, _CARRIERS))[:LOOKED_AT]
    differences = []
    for at, packet in flight.packets(which):
        content = unwrapped(packet) if packet.sender in flight.payloads else None
        if content is not None and content.name == STATUS and isinstance(content.value, Status):
            differences.append(at - content.value.time_usec / 1e6)
    return min(differences, default=None)


def _begins(log: Path) -> dict[str, float]:
    """Return when the tracks begin on the payload's clock [s], as far as the files beside a log tell."""
    try:
        if log.name == SESSION:
            with (log.parent / "inputs.jsonl").open("rb") as lines:
                return {MIXTURE: float(json.loads(lines.readline(LONGEST_LINE))["time"])}
        begins = {MIXTURE: 0.0}
        report = json.loads(read_bounded(log.parent / "report.json", LARGEST_REPORT))
        return begins | {TARGET: float(report["heard_from_s"])}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {MIXTURE: 0.0} if log.name == SIMULATION else {}
