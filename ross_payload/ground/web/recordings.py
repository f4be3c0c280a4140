"""Recorded sessions over the page: which there are, one file or all of one as an archive, and their deletion.

What people said is in them, so browsers keep no copy of their own, and every answer is behind the token.
"""

from __future__ import annotations

import asyncio
import io
from collections.abc import AsyncIterator, Mapping
from pathlib import Path
from typing import Any
from zipfile import ZipFile, ZipInfo

from aiohttp import web

from ross_payload.ground.errors import GroundError
from ross_payload.ground.recordings import RecordingStore, described
from ross_payload.ground.web.file_answer import FileAnswer
from ross_payload.ground.web.security import PRIVATE

CHUNK = 1 << 20  # [bytes] that are read at once
ZIP = "application/zip"


async def listed(store: RecordingStore | None, request: web.Request) -> web.Response:
    """Answer which recordings there are."""
    told = {"folder": None, "known": []} if store is None else await asyncio.to_thread(described, store)
    return web.json_response(told, headers=PRIVATE)


async def one_file(store: RecordingStore | None, request: web.Request) -> web.StreamResponse:
    """Answer with one file of a recording."""
    name, file = request.match_info["name"], request.match_info["file"]
    path = (await files_of(store, name)).get(file)
    if path is None:
        raise web.HTTPNotFound(text=f"recording {name}: no such file\n")
    return FileAnswer(path, _attached(f"{name}-{file}"))


async def archive(store: RecordingStore | None, request: web.Request, kind: str = ZIP) -> web.StreamResponse:
    """Answer with a whole recording as a ZIP archive, made while it is sent.

    Where it cannot be read to its end, as when it is deleted meanwhile, the connection is cut: nobody is to take what
    has come for the whole.
    """
    name = request.match_info["name"]
    files = await files_of(store, name)
    headers = {**PRIVATE, **_attached(f"{name}.zip"), "Content-Type": kind}
    response = web.StreamResponse(headers=headers)
    await response.prepare(request)
    if request.method != "HEAD":
        try:
            async for chunk in zipped(name, files):
                await response.write(chunk)
        except ConnectionError:
            raise
        except OSError:
            if request.transport is not None:
                request.transport.abort()
            return response
    await response.write_eof()
    return response


async def deleted(store: RecordingStore | None, request: web.Request) -> web.Response:
    """Delete a recording, and say that it is gone or why not."""
    name = request.match_info["name"]
    try:
        if store is None:
            raise LookupError(name)
        await asyncio.to_thread(store.delete, name)
    except LookupError as error:
        raise web.HTTPNotFound(text=f"recording {name[:80]}: not found\n") from error
    except GroundError as error:
        return web.json_response({"error": error.message}, status=409)
    return web.json_response({"deleted": name})


async def zipped(name: str, files: Mapping[str, Path]) -> AsyncIterator[bytes]:
    """Yield a ZIP archive of files in a folder ``name``, piece by piece.

    A file that grows meanwhile, as of a running recording, is taken as long as it was when its turn came.
    """
    sink = _Sink()
    with ZipFile(sink, "w") as made:
        for file, path in files.items():
            about = ZipInfo.from_file(path, f"{name}/{file}", strict_timestamps=False)
            about.external_attr = 0o600 << 16
            with path.open("rb") as source, made.open(about, "w", force_zip64=True) as target:
                left = about.file_size
                while left and (chunk := await asyncio.to_thread(source.read, min(CHUNK, left))):
                    left -= len(chunk)
                    target.write(chunk)
                    yield sink.taken()
    yield sink.taken()


class _Sink(io.RawIOBase):
    """Keeps what is written until it is taken; cannot seek."""

    def __init__(self) -> None:
        self._written = bytearray()

    def writable(self) -> bool:
        """Return that it is."""
        return True

    def write(self, data: Any) -> int:
        """Append."""
        self._written += data
        return len(data)

    def taken(self) -> bytes:
        """Return what was written since the last call."""
        data, self._written = bytes(self._written), bytearray()
        return data


async def files_of(store: RecordingStore | None, name: str) -> Mapping[str, Path]:
    """Return the files of a recording by their names.

    Raises
    ------
    web.HTTPNotFound
        When there is no such recording.
    """
    try:
        if store is None:
            raise LookupError(name)
        return await asyncio.to_thread(store.files, name)
    except LookupError as error:
        raise web.HTTPNotFound(text=f"recording {name[:80]}: not found\n") from error


def _attached(name: str) -> dict[str, str]:
    return {"Content-Disposition": f'attachment; filename="{name}"'}
