"""What is answered when something cannot be done: RFC 9457, one line for people and one word for programs."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from http import HTTPStatus
from typing import Literal

from aiohttp import ClientPayloadError, web
from aiohttp.http_exceptions import HttpProcessingError
from pydantic import Field

from ross_payload.ground.errors import GroundError, LinkLost, RefusedByPayload, UnknownParameter
from ross_payload.ground.web.faults import report
from ross_payload.ground.web.flight_library import UploadRefused
from ross_payload.ground.web.operator import NoCommands, NoControl, NotOrdered, NotReceived
from ross_payload.ground.web.rest.view_answers import Answer
from ross_payload.ground.web.security import shown

MEDIA = "application/problem+json"
PATH = "/api/"  # below it all that is no answer is a problem
RENAMED = {413: "Content Too Large", 416: "Range Not Satisfiable", 422: "Unprocessable Content"}  # by RFC 9110
CODES = {
    400: "malformed",
    401: "no-token",
    403: "other-origin",
    404: "not-found",
    405: "wrong-method",
    408: "too-slow",
    409: "conflict",
    412: "changed",
    413: "too-large",
    415: "wrong-content-type",
    416: "wrong-range",
    421: "other-host",
    422: "invalid",
    429: "locked-out",
    500: "fault",
    503: "too-many",
    504: "no-answer",
    507: "no-room",
}  # by status, where no error says it better
WORDS = {
    404: "there is no such path: /api/v1/openapi.json lists all of them",
    405: "this method is none of those that the path has (Allow)",
    412: "the file is not the one that If-Match or If-Unmodified-Since names",
    416: "Range: expected bytes that the file has (Content-Range)",
}  # where aiohttp has none
KEPT = ("Allow", "Content-Range", "Retry-After", "WWW-Authenticate")  # headers of such an answer
OF_ERRORS: tuple[tuple[type[Exception], int, str], ...] = (
    (NotReceived, 404, "unknown-payload"),
    (NotOrdered, 404, "unknown-order"),
    (UnknownParameter, 404, "unknown-parameter"),
    (NoControl, 409, "no-control"),
    (NoCommands, 409, "not-live"),
    (RefusedByPayload, 409, "refused"),
    (LinkLost, 504, "no-answer"),
)  # anything else is a fault of ours
UNREADABLE = (web.RequestPayloadError, HttpProcessingError, ClientPayloadError, UnicodeError)

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]
Place = Literal["path", "query", "header", "body"]


def phrase(status: int) -> str:
    """Return the name of a status in RFC 9110, with any version of Python.

    >>> phrase(404), phrase(422)
    ('Not Found', 'Unprocessable Content')
    """
    return RENAMED.get(status) or HTTPStatus(status).phrase


class WrongValue(Answer):
    """One value that cannot be meant."""

    place: Place
    name: str = Field(description="of a field of the body as a.0.b; empty: the body as a whole")
    detail: str


class Problem(Answer):
    """Why something was not done (RFC 9457): nothing has happened, but with 500 and 504, where it may have."""

    type: str = Field("about:blank", description="as RFC 9457 has it; `code` says more")
    title: str
    status: int
    detail: str = Field(description="one line")
    code: str = Field(description="the problem in one word, for programs")
    errors: list[WrongValue] = Field(description="every value that cannot be meant, of `invalid`")


class Refusal(Exception):
    """Ends a request with a problem."""

    def __init__(
        self,
        status: int,
        detail: str,
        code: str = "",
        *,
        errors: Sequence[WrongValue] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(detail)
        self.status, self.detail, self.code = status, detail, code or CODES.get(status, "malformed")
        self.errors, self.headers = errors, headers or {}

    def response(self) -> web.Response:
        """Return the answer."""
        problem = Problem(
            title=phrase(self.status),
            status=self.status,
            detail=" ".join(self.detail.split()),
            code=self.code,
            errors=list(self.errors),
        )
        return web.Response(
            body=problem.model_dump_json(), status=self.status, content_type=MEDIA, headers=self.headers
        )


def refusal_of(error: Exception) -> Refusal | None:
    """Return the problem that an error is; None: it is a fault of ours."""
    if isinstance(error, Refusal):
        return error
    if isinstance(error, web.HTTPException):
        return refusal_of_http(error)
    if isinstance(error, UploadRefused):
        return Refusal(error.status, error.message)
    if isinstance(error, UNREADABLE):
        return Refusal(400, f"request: {shown(str(error))}")
    text = error.message if isinstance(error, GroundError) else str(error)
    return next((Refusal(status, text, code) for kind, status, code in OF_ERRORS if isinstance(error, kind)), None)


def refusal_of_http(error: web.HTTPException) -> Refusal:
    """Return the problem that an answer of the web server is."""
    kept = {name: error.headers[name] for name in KEPT if name in error.headers}
    own = error.text != f"{error.status}: {error.reason}"  # not the one that aiohttp makes up
    text = error.text if own else WORDS.get(error.status)
    return Refusal(error.status, (text or error.reason).strip(), headers=kept)


def is_problem(path: str, error: web.HTTPException) -> bool:
    """Whether an answer of the web server is to be told to a program, as a problem."""
    return path.startswith(PATH) and error.status >= HTTPStatus.BAD_REQUEST


@web.middleware
async def as_problems(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Answer programs with problems, whoever finds that something cannot be done."""
    if not request.path.startswith(PATH):
        return await handler(request)
    try:
        return await handler(request)
    except ConnectionError:
        raise
    except Exception as error:
        if isinstance(error, web.HTTPException) and not is_problem(request.path, error):
            raise
        refusal = refusal_of(error)
        if refusal is None:
            report(error)
            refusal = Refusal(500, "an internal error of the page: see the terminal")
        return refusal.response()
