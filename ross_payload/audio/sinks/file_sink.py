"""The sink ``file``: one voice into a FLAC or WAV file, for its owner alone, readable up to a crash."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Self

from pydantic import field_validator

from ross_payload.audio.sinks import SinkInfo, SinkServices
from ross_payload.audio.track_files import AlignedTrack, checked_suffix
from ross_payload.config.table import Table
from ross_payload.errors import AudioError, ConfigError
from ross_payload.interfaces import VoiceBlock


class FileOptions(Table):
    """[listening.streams.options] of ``file``."""

    path: (
        str  # ends in .flac or .wav; a number is added to a name that is taken; without a folder: in that of recordings
    )

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
        Rate, and the folder of files that are named without one.
    """

    def __init__(self, options: FileOptions, services: SinkServices) -> None:
        named = Path(options.path).expanduser()
        self._wanted = named if named.parent != Path() or options.path.startswith(".") else services.folder / named
        self._rate = services.rate
        self._path = self._wanted
        self._track: AlignedTrack | None = None
        self._first: int | None = None
        self.fault = ""
        self.lost = 0

    @property
    def info(self) -> SinkInfo:
        """Where it writes, and what."""
        codec = {".flac": "flac", ".wav": "pcm"}[self._path.suffix.lower()]
        return SinkInfo(str(self._path), codec=codec, listeners=int(self._track is not None))

    def write(self, block: VoiceBlock) -> None:
        """Write samples at their place."""
        if self._track is None:
            self.lost += len(block.samples)
            return
        if self._first is None:
            self._first = block.index
        try:
            self._track.write(block.index - self._first, block.samples)
        except OSError as error:
            self.lost += len(block.samples)
            self._end(f"{self._path}: cannot be written: {error.strerror}")

    def __enter__(self) -> Self:
        """Make the file, and its folder.

        Raises
        ------
        AudioError
            When it cannot be made.
        """
        try:
            self._wanted.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._path, self._track = _created(self._wanted, self._rate)
        except OSError as error:
            raise AudioError(f"{self._wanted}: cannot be made: {error.strerror}") from error
        self._first, self.fault = None, ""
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
            self.fault = self.fault or f"{self._path}: cannot be written: {error.strerror}"


def _created(wanted: Path, rate: int) -> tuple[Path, AlignedTrack]:
    """Make a file of a name that nobody has."""
    for number in count(1):
        path = wanted if number == 1 else wanted.with_stem(f"{wanted.stem}-{number}")
        try:
            return path, AlignedTrack(path, rate)
        except FileExistsError:
            continue
    raise AssertionError


class FilePlugin:
    """Files."""

    Config = FileOptions

    def open(self, config: FileOptions, services: SinkServices) -> FileSink:
        """Make the sink."""
        return FileSink(config, services)


sink = FilePlugin()
