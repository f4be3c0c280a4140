"""The sink ``file``: one voice into a FLAC or WAV file, for its owner alone, readable up to a crash.

When the disk has less than `[recording] min_free_gb` left the file ends: parameters and the mark of a stop need room,
too. Opened again, the sink goes on in another one as soon as there is some.
"""

from __future__ import annotations

import errno
import os
from itertools import count
from pathlib import Path
from typing import Self

from pydantic import field_validator

from ross_payload.atomic_files import make_private
from ross_payload.audio.sinks import BuiltInSink, SinkInfo, SinkServices
from ross_payload.audio.track_files import AlignedTrack, checked_suffix
from ross_payload.config.table import Table
from ross_payload.errors import AudioError, ConfigError, reason, refused_as
from ross_payload.interfaces import VoiceBlock
from ross_payload.named_paths import expanded

GB = 1e9  # [bytes]
LOOK_PERIOD_S = 1.0  # [s] of audio between two looks at what is left of the disk
ROOM_S = 60.0  # of audio for which there must be room: a disk that is full again at once would be full of short files
WIDTH = 3  # [bytes] of a sample in a file that does not shrink it


class FileOptions(Table):
    """[listening.streams.options] of ``file``."""

    path: str  # ends in .flac or .wav; a number is added to a taken name; without a folder: in that of recordings

    @field_validator("path")
    @classmethod
    def _named(cls, text: str) -> str:
        try:
            checked_suffix(Path(text))
        except ConfigError as error:
            raise ValueError(str(error)) from error
        return text


class FileSink:
    """An AudioSink that writes a file; its first sample is the first that was taken, and gaps are silence in it.

    Parameters
    ----------
    options
        Where to.
    services
        Rate, the folder of files that are named without one, and what must stay free on the disk.
    """

    def __init__(self, options: FileOptions, services: SinkServices) -> None:
        self._configured = Path(options.path)  # as others shall read it: not where on this computer
        named = expanded(options.path)
        self._wanted = named if named.parent != Path() or options.path.startswith(".") else services.folder / named
        self._rate = services.rate
        self._least = services.min_free_gb
        self._looked = 0  # samples written, when the disk was looked at last
        self._path = self._wanted
        self._track: AlignedTrack | None = None
        self._first: int | None = None
        self.fault = ""
        self.lost = 0

    @property
    def info(self) -> SinkInfo:
        """Where it writes, and what."""
        codec = {".flac": "flac", ".wav": "pcm"}[self._path.suffix.lower()]
        return SinkInfo(self._name, codec=codec, listeners=int(self._track is not None))

    @property
    def _name(self) -> str:
        """The file as the configuration names it, with the number that it got."""
        return str(self._configured.with_name(self._path.name))

    def write(self, block: VoiceBlock) -> None:
        """Write samples at their place.

        Raises
        ------
        AudioError
            When the disk is gone, full, or has less left than must stay free: the file has ended.
        """
        if self._track is None:
            self.lost += len(block.samples)
            return
        if self._first is None:
            self._first = block.index
        try:
            if self._track.length - self._looked >= LOOK_PERIOD_S * self._rate:
                self._looked = self._track.length
                _check_room(self._wanted.parent, self._least)
            self._track.write(block.index - self._first, block.samples)
        except OSError as error:
            empty = not self._track.length
            self._end(f"{self._name}: cannot be written: {reason(error)}")
            if empty:
                self._path.unlink(missing_ok=True)
            raise AudioError(self.fault) from error

    def __enter__(self) -> Self:
        """Make the file, and its folder.

        Raises
        ------
        AudioError
            When it cannot be made, or there is no room for it.
        """
        with refused_as(AudioError, f"{self._configured}: cannot be made"):
            make_private(self._wanted.parent)
            _check_room(self._wanted.parent, self._least, round(ROOM_S * self._rate) * WIDTH)
            self._path, self._track = _created(self._wanted, self._rate)
        self._first, self._looked, self.fault = None, 0, ""
        return self

    def __exit__(self, *exception: object) -> None:
        """Finish the file."""
        self._end(self.fault)

    def _end(self, fault: str) -> None:
        track, self._track, self.fault = self._track, None, fault
        try:
            if track is not None:
                track.close()
        except OSError as error:
            self.fault = self.fault or f"{self._name}: cannot be written: {error.strerror}"


def _check_room(folder: Path, least: float, size: int = 0) -> None:
    """Raise OSError when so many bytes do not fit into a folder, or less than ``least`` [GB] would be left."""
    disk = os.statvfs(folder)
    free = disk.f_bavail * disk.f_frsize
    if free < size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    if free - size < least * GB:
        raise OSError(f"below min_free_gb; [recording] keeps {least:g} GB of the disk free")


def _created(wanted: Path, rate: int) -> tuple[Path, AlignedTrack]:
    """Make a file of a name that nobody has."""
    for number in count(1):
        path = wanted if number == 1 else wanted.with_stem(f"{wanted.stem}-{number}")
        try:
            return path, AlignedTrack(path, rate)
        except FileExistsError:
            continue
    raise AssertionError


sink = BuiltInSink(FileOptions, FileSink)
