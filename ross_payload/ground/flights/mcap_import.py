"""An MCAP file as a flight: the telemetry log that is attached to it, and its foxglove.RawAudio as WAV files.

What `ross tlog --mcap` writes has both; a file of others that has sound alone is heard without telemetry. All is
written into a folder, from which it is opened and served as every flight is.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import soundfile
from numpy.typing import NDArray

from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.raw_audio import SCHEMA, audio_part
from ross_payload.ground.flights.reading import SOUND, UNPACKED, UnpackedSound
from ross_payload.plugins import install_line

APART_S = 0.01  # by which a sample may be off its time: stamps of a computer that is busy tremble
LONGEST_S = 86_400.0  # of a recording
MOST_BYTES = 2 << 30  # of all tracks of a file together, as 16-bit samples, silence in gaps included
PIECE = 1 << 16  # frames that are written together
MOST_TRACKS = 20
LARGEST_RECORD = 256 << 20  # [bytes], also of a chunk that is decompressed
NEAR_NS = 10 * 10**9  # by which the stamp of a message may be off the time of its log, to be of the same clock


@dataclass(slots=True)
class Room:
    """The bytes that the tracks of a file may still take: compressed, a small file may hold more than a disk does."""

    left: int


@dataclass(slots=True)
class _Found:
    """What was found in a file so far."""

    log: bytes | None = None  # a telemetry log
    damage: str = ""
    room: Room = field(default_factory=lambda: Room(MOST_BYTES))


def unpacked(path: Path, folder: Path) -> Path:
    """Write the flight in an MCAP file to a folder that is empty; return the folder.

    Raises
    ------
    GroundError
        When it cannot be read, or there is neither sound nor a telemetry log in it.
    """
    found, tracks = _Found(), dict[str, AudioAssembly]()
    notes: dict[str, str] = {}
    try:
        for record in _records(path, found):
            _take(record, folder, found, tracks, notes)
        about = {name: track.write(folder / f"{name}.wav") for name, track in tracks.items()}
    except OSError as error:
        raise GroundError(f"{path}: cannot be unpacked: {error.strerror or error}") from error
    finally:
        for track in tracks.values():
            track.close()
    spans = {name: span for name, span in about.items() if span is not None}
    if found.log is None and not spans:
        why = next(iter(notes.values()), found.damage or "neither")
        raise GroundError(f"{path}: expected an MCAP file with a telemetry log or {SCHEMA}, got {why}")
    said = [f"the file is damaged: {found.damage}"] if found.damage else []
    said += [] if found.log is not None else ["no telemetry in it: sound alone"]
    (folder / UNPACKED).write_bytes(found.log or b"")
    begins = {name: begin for name, (begin, _) in spans.items()}
    origin = None if found.log is not None else min(begins.values())
    duration = max((end for _, end in spans.values()), default=0.0) - (origin or 0.0)
    sound = UnpackedSound(begins, origin, duration, [*said, *sorted(notes.values())])
    (folder / SOUND).write_text(json.dumps(asdict(sound)))
    return folder


def glimpse(path: Path) -> tuple[float | None, float | None]:
    """Return begin and end [s] that the summary of a file tells; None: it has none, or cannot be read."""
    try:
        from mcap.reader import make_reader  # noqa: PLC0415 - an extra

        with path.open("rb") as file:
            summary = make_reader(file).get_summary()
        told = None if summary is None else summary.statistics
        return (None, None) if told is None else (told.message_start_time / 1e9, told.message_end_time / 1e9)
    except Exception:  # of others: what a damaged file makes the reader raise is not told
        return None, None


def _take(record: Any, folder: Path, found: _Found, tracks: dict[str, AudioAssembly], notes: dict[str, str]) -> None:
    """Take a telemetry log, or a message with sound."""
    if isinstance(record, tuple):
        topic, encoding, message = record
        try:
            part = audio_part(message.data, encoding)
        except ValueError as error:
            notes.setdefault(topic, f"{topic[:40]} is not played: {error}")
            return
        near = part.time and abs(part.time - message.log_time) < NEAR_NS
        name = track_name(topic)
        if name not in tracks:
            if len(tracks) >= MOST_TRACKS:
                notes[""] = f"more than {MOST_TRACKS} topics with sound: the others are not played"
                return
            tracks[name] = AudioAssembly(folder / f"{name}.raw", part.rate, part.samples.shape[1], found.room)
        if part.samples.nbytes > found.room.left:
            notes.setdefault(topic, f"{topic[:40]}: only the first {MOST_BYTES >> 30} GB of the file are played")
        elif tracks[name].add(part.time if near else message.log_time, part.rate, part.samples):
            found.room.left -= part.samples.nbytes
        else:
            notes.setdefault(topic, f"{topic[:40]}: parts of another rate are left out")
    elif found.log is None:
        found.log = record.data


def track_name(topic: str) -> str:
    """Return the name of the track of a topic: a word that can be a file's.

    >>> track_name("/sound/mixture"), track_name("/robot/ear left")
    ('mixture', 'robot-ear-left')
    """
    text = topic.removeprefix("/sound/") if topic.startswith("/sound/") else topic
    words = "".join(each if each.isascii() and each.isalnum() else "-" for each in text).strip("-")
    return "-".join(filter(None, words.split("-")))[:60] or "sound"


def _records(path: Path, found: _Found) -> Iterator[Any]:
    """Yield telemetry logs that are attached, and (topic, encoding, message) of sound, as far as the file goes."""
    try:
        from mcap.exceptions import McapError  # noqa: PLC0415 - an extra
        from mcap.stream_reader import StreamReader  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise GroundError(f"{path}: an MCAP file needs the package mcap: {install_line('mcap')}") from error
    try:
        with path.open("rb") as file:
            yield from _selected(StreamReader(file, emit_chunks=True, record_size_limit=LARGEST_RECORD).records)
    except (McapError, struct.error, ValueError, RuntimeError, EOFError, MemoryError, OverflowError) as error:
        found.damage = " ".join(str(error).split())[:80] or type(error).__name__  # it is read as far as it goes


def _selected(records: Iterable[Any]) -> Iterator[Any]:
    """Yield those of the records that `_records` yields, also those in chunks."""
    from mcap.records import Attachment, Channel, Message, Schema  # noqa: PLC0415 - an extra

    schemas: dict[int, str] = {}
    channels: dict[int, tuple[str, str] | None] = {}
    for record in _without_chunks(records):
        if isinstance(record, Schema):
            schemas[record.id] = record.name
        elif isinstance(record, Channel):
            is_sound = schemas.get(record.schema_id) == SCHEMA
            channels[record.id] = (record.topic, record.message_encoding) if is_sound else None
        elif isinstance(record, Message) and (channel := channels.get(record.channel_id)) is not None:
            yield *channel, record
        elif isinstance(record, Attachment) and record.name.endswith(".tlog"):
            yield record


def _without_chunks(records: Iterable[Any]) -> Iterator[Any]:
    """Yield every record, in place of a chunk those that it holds."""
    from mcap.records import Chunk  # noqa: PLC0415 - an extra
    from mcap.stream_reader import breakup_chunk  # noqa: PLC0415

    for record in records:
        if isinstance(record, Chunk):
            yield from breakup_chunk(_inflated(record))
        else:
            yield record


def _inflated(chunk: Any) -> Any:
    """Return a chunk that is not compressed; ValueError when it would be larger than it says, or than is read."""
    import lz4.frame  # noqa: PLC0415 - comes with mcap
    import zstandard  # noqa: PLC0415

    size = chunk.uncompressed_size
    if size > LARGEST_RECORD:
        raise ValueError(f"expected chunks up to {LARGEST_RECORD >> 20} MB, got {size >> 20} MB")
    if chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size)
    elif chunk.compression == "zstd":
        try:
            with zstandard.ZstdDecompressor().stream_reader(chunk.data) as reader:
                data = reader.read(size)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from error
    elif not chunk.compression:
        data = chunk.data
    else:
        raise ValueError(f"unknown compression {chunk.compression[:20]}")
    return replace(chunk, compression="", data=data, uncompressed_crc=0)


class AudioAssembly:
    """Puts parts of a recording, each with its time, into one file; keeps them in another until all are there.

    Parameters
    ----------
    path
        Of that file; it is deleted in the end.
    rate
        Of the samples [Hz].
    channels
        How many.
    room
        For the silence in gaps.
    """

    def __init__(self, path: Path, rate: int, channels: int, room: Room) -> None:
        self._path, self._rate, self._channels, self._room = path, rate, channels, room
        self._file = path.open("xb")
        self._parts: list[tuple[int, int, int]] = []  # time [ns], first frame in the file, frames
        self._kept = 0  # frames

    def add(self, time: int, rate: int, samples: NDArray[np.int16]) -> bool:
        """Keep frames (n, n_channels) whose first was heard at ``time`` [ns]; False: they are of another kind."""
        if (rate, samples.shape[1]) != (self._rate, self._channels):
            return False
        self._file.write(samples.tobytes())
        self._parts.append((time, self._kept, len(samples)))
        self._kept += len(samples)
        return True

    def write(self, path: Path) -> tuple[float, float] | None:
        """Write a WAV file; return when it begins and ends [s], None when there is no sample.

        Gaps become silence, what comes twice is left out, and a sample is nowhere more than `APART_S` off its time.
        What lies further behind than there is room for silence, or than `LONGEST_S`, is left out.
        """
        self._file.flush()
        if not self._kept:
            return None
        frames = np.memmap(self._path, "<i2", "r", shape=(self._kept, self._channels))
        begin, written = min(self._parts)[0], 0
        most = round(LONGEST_S * self._rate)
        with soundfile.SoundFile(path, "w", self._rate, self._channels, "PCM_16", format="WAV") as file:
            for time, first, count in sorted(self._parts):
                place = round((time - begin) * self._rate / 1e9)
                gap = place - written if abs(place - written) > APART_S * self._rate else 0
                silence = 2 * self._channels * max(gap, 0)
                if place + count > most or silence > self._room.left:
                    break
                self._room.left -= silence
                early = 0
                if gap:
                    _silence(file, gap, self._channels)
                    early = min(max(written - place, 0), count)
                    written = max(place, written)
                file.write(frames[first + early : first + count])
                written += count - early
        return begin / 1e9, begin / 1e9 + written / self._rate

    def close(self) -> None:
        """Delete what was kept."""
        self._file.close()
        self._path.unlink(missing_ok=True)


def _silence(file: soundfile.SoundFile, count: int, channels: int) -> None:
    """Write so many frames of silence; none when it is less than one."""
    while count > 0:
        zeros = np.zeros((min(count, PIECE), channels), np.int16)
        file.write(zeros)
        count -= len(zeros)
