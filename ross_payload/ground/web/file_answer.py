"""A file as an answer, also in parts (Range); why it cannot be sent is told in words, to programs as a problem."""

from __future__ import annotations

from pathlib import Path

from aiohttp import hdrs, web
from aiohttp.abc import AbstractStreamWriter

from ross_payload.ground.web.rest.problems import is_problem, refusal_of_http
from ross_payload.ground.web.security import PRIVATE

ERRORS: dict[int, type[web.HTTPException]] = {
    error.status_code: error
    for error in (web.HTTPForbidden, web.HTTPNotFound, web.HTTPPreconditionFailed, web.HTTPRequestRangeNotSatisfiable)
}


class FileAnswer(web.FileResponse):
    """The file at ``path``; aiohttp decides when it is sent whether it can be, and would answer without a body."""

    def __init__(self, path: Path, headers: dict[str, str]) -> None:
        super().__init__(path, headers={**PRIVATE, **headers})
        self._refusal: web.Response | None = None

    def set_status(self, status: int, reason: str | None = None) -> None:
        """Set the status, before anything is sent.

        Raises
        ------
        web.HTTPException
            When nothing is to be sent.
        """
        if status in ERRORS:
            told = self.headers.get(hdrs.CONTENT_RANGE)  # how long the file is
            raise ERRORS[status](headers=None if told is None else {hdrs.CONTENT_RANGE: told})
        super().set_status(status, reason)

    async def prepare(self, request: web.BaseRequest) -> AbstractStreamWriter | None:
        """Send the file, or say why not."""
        try:
            return await super().prepare(request)
        except web.HTTPException as error:
            self._refusal = refusal_of_http(error).response() if is_problem(request.path, error) else error
            self._refusal.force_close()  # as the server does, who asks this answer whether to go on
            return await self._refusal.prepare(request)

    async def write_eof(self, data: bytes = b"") -> None:
        """End what is sent."""
        await (super().write_eof(data) if self._refusal is None else self._refusal.write_eof(data))
