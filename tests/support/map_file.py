"""An MBTiles file as tile makers write it: SQLite, rows counted from the south, PNG images."""

import math
import sqlite3
import struct
import zlib
from contextlib import closing
from functools import cache

PLACE = (47.0, 8.0)  # latitude, longitude [deg] in the middle
LEVELS = (14, 15, 16)
AROUND = 3  # tiles to each side of the middle one
SIDE = 256  # of a tile [pixels]


@cache
def png(red, green, blue):
    """Return a picture of one colour."""
    rows = (b"\x00" + bytes((red, green, blue)) * SIDE) * SIDE

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", SIDE, SIDE, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def tile_at(zoom):
    """Return column and row, counted from the north, of the tile that holds `PLACE`."""
    latitude, longitude = PLACE
    north = math.asinh(math.tan(math.radians(latitude)))
    share = (longitude + 180) / 360, (1 - north / math.pi) / 2
    return tuple(int(each * 2**zoom) for each in share)


def corner_of(zoom, column, row):
    """Return latitude and longitude of the north-western corner of a tile."""
    north = math.pi * (1 - 2 * row / 2**zoom)
    return math.degrees(math.atan(math.sinh(north))), column / 2**zoom * 360 - 180


def map_file(path, metadata=None, levels=LEVELS, body=None):
    """Write tiles around `PLACE`; ``body`` instead of a picture of their own. Return the path."""
    told = {"name": "field", "format": "png", "attribution": "&copy; <a href='x'>Survey</a>"}
    with closing(sqlite3.connect(path)) as file, file:
        file.execute("CREATE TABLE metadata (name text, value text)")
        file.execute("CREATE TABLE tiles (zoom_level integer, tile_column integer, tile_row integer, tile_data blob)")
        file.executemany("INSERT INTO metadata VALUES (?, ?)", {**told, **(metadata or {})}.items())
        for zoom in levels:
            middle = tile_at(zoom)
            for across in range(-AROUND, AROUND + 1):
                for down in range(-AROUND, AROUND + 1):
                    column, row = middle[0] + across, middle[1] + down
                    picture = body or png(150 + 20 * (across % 3), 180, 120 + 30 * (down % 3))
                    file.execute("INSERT INTO tiles VALUES (?, ?, ?, ?)", (zoom, column, 2**zoom - 1 - row, picture))
    return path
