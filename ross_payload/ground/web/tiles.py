"""Map tiles of a local MBTiles file: SQLite, opened read only; raster images, served as they are."""

from __future__ import annotations

import html
import math
import re
import sqlite3
import threading
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ross_payload.ground.errors import GroundError

KINDS = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}  # content type by how a tile begins
EXPECTED = "expected an MBTiles file with PNG or JPEG tiles"
LARGEST = 4 << 20  # [bytes] of a tile
DEEPEST = 30  # zoom level
LONGEST = 200  # characters of a name or an attribution
_TAG = re.compile(r"<[^>]*>")


@dataclass(frozen=True, slots=True)
class Tile:
    """An image, 256 by 256 pixels as a rule."""

    body: bytes
    content_type: str


class Tiles(AbstractContextManager["Tiles"]):
    """The tiles of a file, by zoom level, column and row; rows count from the north. A context manager.

    Raises
    ------
    GroundError
        When the file is no MBTiles file, or has no raster tiles.
    """

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise GroundError(f"--map {path}: {EXPECTED}, got {'a folder' if path.is_dir() else 'no such file'}")
        self._lock = threading.Lock()
        try:
            address = f"{path.resolve().as_uri()}?mode=ro"
            with ExitStack() as opened:
                self._file = opened.enter_context(closing(sqlite3.connect(address, uri=True, check_same_thread=False)))
                self.about = self._look(path)
                opened.pop_all()
        except (sqlite3.Error, OverflowError, UnicodeDecodeError) as error:
            raise GroundError(f"--map {path}: {EXPECTED}, got: {error}") from error

    def __exit__(self, *error: object) -> None:
        """Close the file."""
        self._file.close()

    def read(self, zoom: int, column: int, row: int) -> Tile | None:
        """Return a tile; None: the file has none there, or none that is an image. On any thread."""
        if not 0 <= zoom <= DEEPEST or not 0 <= column < 1 << zoom or not 0 <= row < 1 << zoom:
            return None
        where = zoom, column, (1 << zoom) - 1 - row  # the file counts rows from the south
        query = "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?"
        try:
            with self._lock:
                found = self._file.execute(query, where).fetchone()
        except sqlite3.Error:
            return None
        return None if found is None else tile_of(found[0])

    def _look(self, path: Path) -> dict[str, Any]:
        """Return what the page has to know: zoom levels, attribution, and where to begin."""
        first = self._file.execute("SELECT tile_data FROM tiles LIMIT 1").fetchone()
        if first is None:
            raise GroundError(f"--map {path}: {EXPECTED}, got one without tiles")
        fields = {str(name): str(value) for name, value in self._file.execute("SELECT name, value FROM metadata")}
        if tile_of(first[0]) is None:
            raise GroundError(
                f"--map {path}: {EXPECTED}, got {plain(fields.get('format', 'another format'))[:20]} tiles"
            )
        least, most = self._file.execute("SELECT MIN(zoom_level), MAX(zoom_level) FROM tiles").fetchone()
        if not (isinstance(least, int) and isinstance(most, int) and 0 <= least <= most <= DEEPEST):
            raise GroundError(f"--map {path}: expected zoom levels from 0 to {DEEPEST}, got {least} to {most}")
        center = _center(fields) or self._somewhere(most)
        about = {"name": plain(fields.get("name", path.name)), "attribution": plain(fields.get("attribution", ""))}
        return {**about, "minzoom": least, "maxzoom": most, "center": center}

    def _somewhere(self, zoom: int) -> dict[str, float]:
        """Return the middle of a tile of the deepest level."""
        query = "SELECT tile_column, tile_row FROM tiles WHERE zoom_level = ? LIMIT 1"
        column, row = self._file.execute(query, (zoom,)).fetchone()
        north = math.pi * (1 - 2 * ((1 << zoom) - row - 0.5) / (1 << zoom))
        return {"lat": math.degrees(math.atan(math.sinh(north))), "lon": (column + 0.5) / (1 << zoom) * 360 - 180}


def tile_of(body: Any) -> Tile | None:
    r"""Return a tile when these bytes are one.

    >>> tile_of(b"\xff\xd8\xff\xe0").content_type, tile_of(b"\x1f\x8b"), tile_of(None)
    ('image/jpeg', None, None)
    """
    if not isinstance(body, bytes) or len(body) > LARGEST:
        return None
    return next((Tile(body, kind) for start, kind in KINDS.items() if body.startswith(start)), None)


def plain(text: str) -> str:
    r"""Return one line without HTML, as attributions are often written in it.

    >>> plain('&copy; <a href="https://example.org">Example</a>\nAG')
    '© Example AG'
    """
    words = html.unescape(_TAG.sub("", text[: 10 * LONGEST])).split()
    return "".join(each for each in " ".join(words) if each.isprintable())[:LONGEST]


def _center(fields: dict[str, str]) -> dict[str, float] | None:
    """Return the middle that the metadata tell, by ``center`` or ``bounds``."""
    center = _numbers(fields.get("center", ""))
    bounds = _numbers(fields.get("bounds", ""))
    if len(center) >= 2:
        lon, lat = center[:2]
    elif len(bounds) == 4:
        lon, lat = (bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2
    else:
        return None
    return {"lat": lat, "lon": lon} if abs(lat) <= 85 and abs(lon) <= 180 else None


def _numbers(text: str) -> list[float]:
    try:
        return [float(each) for each in text.split(",")]
    except ValueError:
        return []
