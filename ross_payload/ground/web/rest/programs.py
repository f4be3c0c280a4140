"""The programs that ask: who each one is, and until when it keeps control; none of them is connected in between."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from aiohttp import web

from ross_payload.ground.web.operator import Operator
from ross_payload.ground.web.page_state import PageState
from ross_payload.ground.web.rest.problems import Refusal, WrongValue
from ross_payload.ground.web.security import shown

HEADER = "Ross-Client"
NAME_PATTERN = r"^[A-Za-z0-9._-]{1,32}$"
ANYBODY = "rest"  # who gives no name
MOST_STREAMS = 32  # of events


class Programs:
    """All of them, by what they call themselves and where they are.

    Control is held as by browsers: as long as a request of its holder is answered, and `CONTROL_GRACE_S` after that.
    """

    def __init__(self, state: PageState) -> None:
        self._state = state
        self._asking: Counter[str] = Counter()
        self._streams = 0

    def operator_of(self, request: web.Request, *, strict: bool = True) -> Operator:
        """Return who asks; ``strict``: a name that is none is refused, else it is nobody's.

        Raises
        ------
        Refusal
            When the name is none.
        """
        name = request.headers.get(HEADER, ANYBODY)
        if re.fullmatch(NAME_PATTERN, name) is None:
            if strict:
                what = f"expected a name as {NAME_PATTERN}, got {shown(name)}"
                error = WrongValue(place="header", name=HEADER, detail=what)
                raise Refusal(422, f"{HEADER}: {what}", errors=[error])
            name = ANYBODY
        return Operator(self._state, f"{name}@{request.remote}", f"{name} at {request.remote}")

    @contextmanager
    def asking(self, operator: Operator) -> Iterator[None]:
        """Count a request of an operator as long as it is answered."""
        self._asking[operator.id] += 1
        self._state.control.on_connect(operator.id)
        try:
            yield
        finally:
            self._asking[operator.id] -= 1
            if not self._asking[operator.id]:
                del self._asking[operator.id]
                self._state.control.on_disconnect(operator.id, self._state.station.now())

    @contextmanager
    def streaming(self) -> Iterator[None]:
        """Count a stream of events.

        Raises
        ------
        Refusal
            When there are too many.
        """
        if self._streams >= MOST_STREAMS:
            raise Refusal(503, f"{MOST_STREAMS} programs get events already: no more are served")
        self._streams += 1
        try:
            yield
        finally:
            self._streams -= 1
