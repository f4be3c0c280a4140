"""The files of the page, as they lie in the package."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from importlib import resources
from pathlib import PurePosixPath

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".json": "application/json",
    ".txt": "text/plain; charset=utf-8",
    ".png": "image/png",
}
_NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")


@dataclass(frozen=True, slots=True)
class Asset:
    """A file to serve."""

    body: bytes
    content_type: str
    etag: str


def asset(path: str) -> Asset | None:
    """Read a file below ``assets``; None: there is none, or the path leads elsewhere.

    >>> asset("../server.py") is None, asset("vendor") is None, asset(".hidden.js") is None
    (True, True, True)
    """
    parts = path.split("/")
    content_type = TYPES.get(PurePosixPath(path).suffix)
    if content_type is None or not all(map(_NAME.fullmatch, parts)):
        return None
    place = resources.files(__package__).joinpath("assets", *parts)
    if not place.is_file():
        return None
    body = place.read_bytes()
    return Asset(body, content_type, hashlib.sha256(body).hexdigest()[:32])
