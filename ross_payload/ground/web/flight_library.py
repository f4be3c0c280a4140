"""Flights of the past: those in a folder, and those that browsers uploaded, which are gone when the page ends."""

from __future__ import annotations

import asyncio
import re
import shutil
import struct
import tempfile
import threading
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import Any

from ross_payload.errors import refused_as
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.log_file import CALENDAR_FROM_US, is_simulated
from ross_payload.ground.flights.mcap_import import glimpse, unpacked
from ross_payload.ground.flights.reading import LOGS, UNPACKED, open_flight
from ross_payload.ground.flights.sound import sound_files
from ross_payload.json_values import encodable

TLOG, MCAP, PART = ".tlog", ".mcap", ".part"  # of flights; of one that has not wholly come
MAX_BYTES = 256 << 20  # of a flight that is uploaded
MAX_UPLOADED = 20
MAX_SHOWN = 200
SMALL_BYTES = 8 << 20  # of a flight that is looked into before somebody opens it
GROWING_S = 5.0  # since its last change: it is still written
_UNWANTED = re.compile(r"[^A-Za-z0-9._ -]")


class UploadRefused(GroundError):
    """A flight that is not taken, with the HTTP status that says so."""

    def __init__(self, status: int, why: str) -> None:
        super().__init__(why)
        self.status = status


@dataclass(frozen=True, slots=True)
class _Look:
    """What was seen of a file, as long as it does not change."""

    size: int
    changed: int  # [ns]
    row: dict[str, Any]


class FlightLibrary(AbstractContextManager["FlightLibrary"]):
    """Context manager; ``folder`` None: only what browsers upload."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._uploaded: tempfile.TemporaryDirectory[str] | None = None
        self._looks: dict[Path, _Look] = {}
        self._unpacked: dict[tuple[Path, int, int], Path] = {}  # folders of MCAP files, by path, size and last change
        self._unpacked_in: tempfile.TemporaryDirectory[str] | None = None
        self._unpacking = threading.Lock()

    def __exit__(self, *error: object) -> None:
        """Delete what browsers uploaded, and what was unpacked."""
        for folder in (self._uploaded, self._unpacked_in):
            if folder is not None:
                folder.cleanup()

    def path(self, name: str) -> Path:
        """Return where a flight lies.

        Raises
        ------
        GroundError
            When there is none of that name.
        """
        found = dict(self._named()).get(name)
        if found is None:
            raise GroundError(f"flight {name[:80]}: not found")
        return found

    def readable(self, name: str) -> Path:
        """Return what can be opened of a flight: an MCAP file is unpacked, which may take seconds; on any thread.

        Raises
        ------
        GroundError
            When there is none of that name, or it cannot be unpacked.
        """
        path = self.path(name)
        if path.suffix != MCAP or path.is_dir():
            return path
        with self._unpacking:
            return self._unpacked_of(path) or self._unpack(path)

    def sound(self, name: str, track: str) -> Path:
        """Return the file of one of a flight's tracks.

        Raises
        ------
        GroundError
            When there is none of that name.
        """
        found = sound_files(self.readable(name)).get(track)
        if found is None:
            raise GroundError(f"flight {name[:80]}: no sound '{track[:40]}'")
        return found

    def known(self) -> list[dict[str, Any]]:
        """Return the flights, the newest first; it may take seconds, on any thread."""
        rows = [
            {**self._row(name, path), "sound": list(sound_files(self._unpacked_of(path) or path))}
            for name, path in self._named()
        ]
        return sorted(rows, key=lambda row: -(row["start"] or 0.0))[:MAX_SHOWN]

    async def save_upload(self, name: str, chunks: AsyncIterator[bytes]) -> str:
        """Keep a flight that a browser uploads; return its name here.

        Raises
        ------
        UploadRefused
            When it is too large, no flight, or one too many.
        """
        suffix = next((each for each in (TLOG, MCAP) if name.lower().endswith(each)), None)
        if suffix is None:
            wanted = f"expected that of a telemetry log ({TLOG}) or of an MCAP file ({MCAP})"
            raise UploadRefused(415, f"name: {wanted}, got {name[:80] or 'none'}")
        path = self._place(name, suffix)
        part = path.with_name(f"{path.name}{PART}")
        try:
            await _write(part, chunks)
            if suffix == MCAP:
                await asyncio.to_thread(_unpacked_into, part, path)
            else:
                await asyncio.to_thread(open_flight, part)
                part.rename(path)
        except GroundError as error:
            status = error.status if isinstance(error, UploadRefused) else 422
            raise UploadRefused(status, error.message.replace(str(part), path.name)) from error
        finally:
            part.unlink(missing_ok=True)
        return path.name

    def _unpacked_of(self, path: Path) -> Path | None:
        """Return the folder of an MCAP file that was unpacked, and has not changed since; None: it was not."""
        try:
            about = path.stat()
        except OSError:
            return None
        return self._unpacked.get((path, about.st_size, about.st_mtime_ns))

    def _unpack(self, path: Path) -> Path:
        with refused_as(GroundError, f"{path}: cannot be unpacked"):
            about = path.stat()
            if self._unpacked_in is None:
                self._unpacked_in = tempfile.TemporaryDirectory(prefix="ross-mcap-")
            folder = Path(tempfile.mkdtemp(dir=self._unpacked_in.name))
        _unpacked_into(path, folder / path.name)
        self._unpacked[path, about.st_size, about.st_mtime_ns] = folder / path.name
        return folder / path.name

    def _place(self, name: str, suffix: str) -> Path:
        """Return where a flight can lie that is called like this."""
        if self._uploaded is None:
            self._uploaded = tempfile.TemporaryDirectory(prefix="ross-flights-")
        folder = Path(self._uploaded.name)
        here = {path.name.removesuffix(f"{PART}-d").removesuffix(PART) for path in folder.iterdir()}
        if len(here) >= MAX_UPLOADED:
            raise UploadRefused(507, f"{MAX_UPLOADED} flights were brought already: no more are accepted")
        stem = _UNWANTED.sub("_", name.replace("\\", "/").rsplit("/", 1)[-1])[: -len(suffix)].strip(". ")[-80:]
        taken = here | {name for name, _ in self._named()}
        marks = chain([""], (f" {number}" for number in count(2)))
        names = (f"{stem or 'flight'}{mark}{suffix}" for mark in marks)
        return folder / next(name for name in names if name not in taken)

    def _named(self) -> Iterator[tuple[str, Path]]:
        """Yield every flight's name, as UTF-8 can hold it, and path; a session goes by the name of its folder."""
        if self._folder is not None and self._folder.is_dir():
            for path in sorted(self._folder.iterdir()):
                if _has_flight(path):
                    yield encodable(path.name), path
        if self._uploaded is not None:
            brought = sorted(Path(self._uploaded.name).iterdir())
            yield from ((path.name, path) for path in brought if path.suffix in (TLOG, MCAP))

    def _row(self, name: str, path: Path) -> dict[str, Any]:
        try:
            log = next((path / log for log in (*LOGS, UNPACKED) if (path / log).is_file()), path)
            about = log.stat()
        except OSError:
            return _unread(name, "the file has been deleted")
        look = self._looks.get(path)
        if look is None or (look.size, look.changed) != (about.st_size, about.st_mtime_ns):
            if log.suffix == MCAP:
                return _summary(name, log)
            small = about.st_size <= SMALL_BYTES and time.time() - about.st_mtime > GROWING_S
            look = _Look(about.st_size, about.st_mtime_ns, _opened(name, path) if small else _glimpse(name, log))
            if small or about.st_size > SMALL_BYTES:
                self._looks[path] = look
        return look.row


def _opened(name: str, path: Path) -> dict[str, Any]:
    try:
        flight = open_flight(path)
    except GroundError as error:
        return _unread(name, error.message)
    about = {"start": flight.start, "simulated": flight.simulated, "notes": list(flight.notes)}
    return {"name": name, "duration": flight.duration, **about}


def _unpacked_into(path: Path, folder: Path) -> None:
    """Unpack an MCAP file, and see that it is a flight; nothing is left of one that is none."""
    aside = folder.with_name(f"{folder.name}{PART}-d")
    try:
        aside.mkdir()
        open_flight(unpacked(path, aside))
        aside.rename(folder)
    except OSError as error:
        raise GroundError(f"{path}: cannot be unpacked: {error.strerror}") from error
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _summary(name: str, path: Path) -> dict[str, Any]:
    """Tell what an MCAP file says of itself, and no more."""
    begin, end = glimpse(path)
    start = begin if begin is not None and begin * 1e6 > CALENDAR_FROM_US else None
    duration = None if begin is None or end is None else end - begin
    return {"name": name, "duration": duration, "start": start, "simulated": False, "notes": []}


def _unread(name: str, why: str) -> dict[str, Any]:
    return {"name": name, "duration": None, "start": None, "simulated": False, "notes": [encodable(why)]}


def _glimpse(name: str, log: Path) -> dict[str, Any]:
    """Read when a flight began, and no more."""
    try:
        with log.open("rb") as file:
            stamp = int(struct.unpack(">Q", file.read(8))[0])
    except (OSError, struct.error):
        return {**_unread(name, ""), "notes": []}
    start = stamp / 1e6 if CALENDAR_FROM_US < stamp < 2**62 else None
    return {"name": name, "duration": None, "start": start, "simulated": is_simulated(stamp), "notes": []}


async def _write(path: Path, chunks: AsyncIterator[bytes]) -> None:
    size = 0
    try:
        with path.open("xb") as file:
            async for chunk in chunks:
                size += len(chunk)
                if size > MAX_BYTES:
                    raise UploadRefused(413, f"expected at most {MAX_BYTES >> 20} MB, got more")
                file.write(chunk)
    except OSError as error:
        raise UploadRefused(507, f"it cannot be kept: {error.strerror}") from error


def _has_flight(path: Path) -> bool:
    """Whether it is a file or a folder with a flight, as far as we may look at it; a pipe would hold us up."""
    try:
        return any((path / log).is_file() for log in LOGS) or (path.suffix in (TLOG, MCAP) and path.is_file())
    except OSError:
        return False
