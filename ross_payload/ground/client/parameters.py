"""The parameters of a payload as an async mapping."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import AsyncIterator, Coroutine
from dataclasses import dataclass, fields
from typing import Any

from ross_payload.ground.client.command_status import RESTARTED
from ross_payload.ground.client.param_client import ERRORS, KNOWN, NO_ANSWER, REFUSED, SENDING, ParamClient
from ross_payload.ground.client.streams import Wakeup
from ross_payload.ground.errors import LinkLost, RefusedByPayload, UnknownParameter

LIST_TIMEOUT_S = 60.0  # for the whole list, on a slow radio, with its descriptions
REASON_TIMEOUT_S = 1.0  # for the text that says why something was refused


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter; None and '' are what the payload does not say."""

    name: str
    value: float | int  # an int where the payload says that it is a whole number
    default: float | None
    min: float | None
    max: float | None
    unit: str
    description: str
    group: str


class Parameters:
    """Read and set parameters. The payload is asked for its list when the first of these methods is called.

    ::

        seconds = await payload.parameters["EXP_UNIT"]
        await payload.parameters.set("EXP_UNIT", 2.5)
        async for name in payload.parameters: ...

    Angles and units are the payload's own, see docs/reference/parameters.md.
    """

    def __init__(self, settings: ParamClient, changed: Wakeup) -> None:
        self.settings = settings
        self.wanted = False  # the list is not asked for before
        self._changed = changed
        self._one_value: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)  # of two nobody could tell whose

    def __getitem__(self, name: str) -> Coroutine[Any, Any, float]:
        """Return a coroutine: ``await parameters[name]`` is the value.

        Raises
        ------
        UnknownParameter
            When the payload has none of that name.
        LinkLost
            When the list did not arrive.
        """
        return self._value(name)

    async def __aiter__(self) -> AsyncIterator[str]:
        """Iterate over the names, in the payload's order."""
        await self._until_known()
        for row in self.settings.rows():
            yield row["name"]

    async def get(self, name: str) -> Parameter:
        """Return a parameter with what the payload says about it.

        Raises
        ------
        UnknownParameter, LinkLost
            As for ``parameters[name]``.
        """
        parameters = {each.name: each for each in await self.list()}
        if name not in parameters:
            raise unknown(self.settings, name)
        return parameters[name]

    async def list(self) -> tuple[Parameter, ...]:
        """Return all parameters in the payload's order.

        Raises
        ------
        LinkLost
            When they did not arrive.
        """
        await self._until_known(described=True)
        return tuple(map(_parameter, self.settings.rows()))

    async def set(self, name: str, value: float) -> float:
        """Change a parameter, wait until it was read back, and return it as the payload has it.

        Of several at once for the same parameter each is sent when the one before it has ended.

        Raises
        ------
        UnknownParameter
            When the payload has none of that name.
        RefusedByPayload
            When it keeps its value; ``reason`` says why.
        LinkLost
            When nothing answers.
        ValueError
            When no 32-bit float can hold the value.
        """
        self._changed.check_open(f"{name} = {value}")
        await self._until_named(name)
        async with self._one_value[name]:
            await self._until_named(name)  # again: the payload may have restarted
            self.settings.set(name, value)
            state, reason = await self._changed.until(lambda: self._ended(name))
            request = f"{name} = {value:g}"
            if state == NO_ANSWER:
                raise LinkLost(request, reason)
            if state == REFUSED:
                own_words = await self._changed.within(REASON_TIMEOUT_S, lambda: self._own_words(name))  # a bit later
                raise RefusedByPayload(request, own_words or reason)
            return self.settings.values[name]

    async def _until_named(self, name: str) -> None:
        self.wanted = True
        if name not in self.settings.values:
            await self._until_known()
        if name not in self.settings.values:
            raise unknown(self.settings, name)

    async def _value(self, name: str) -> float:
        await self._until_known()
        if name not in self.settings.values:
            raise unknown(self.settings, name)
        return self.settings.values[name]

    async def _until_known(self, *, described: bool = False) -> None:
        if not self.settings.complete:
            self._changed.check_open("the list of parameters")
        self.wanted = True
        settings = self.settings
        try:
            async with asyncio.timeout(LIST_TIMEOUT_S):
                await self._changed.until(lambda: (settings.complete and (settings.described or not described)) or None)
        except TimeoutError as error:
            found = len(settings.values)
            raise LinkLost("the list of parameters", f"{found} arrived within {LIST_TIMEOUT_S:g} s") from error

    def _ended(self, name: str) -> tuple[str, str] | None:
        if name not in self.settings.values:
            return NO_ANSWER, RESTARTED
        state, reason = self.settings.state_of(name)
        if state == KNOWN:  # listed anew, and nothing is known of the change
            return NO_ANSWER, RESTARTED
        return None if state == SENDING else (state, reason)

    def _own_words(self, name: str) -> str | None:
        _, reason = self._ended(name) or ("", "")
        return None if reason in ("", "refused", *ERRORS.values()) else reason


def unknown(settings: ParamClient, name: str) -> UnknownParameter:
    """Return the error that a payload has no parameter of a name, with names that are near."""
    near = [each for each in settings.values if each.startswith(str(name)[:3])]
    hint = f": expected one such as {', '.join(near[:5])}" if near else ""
    return UnknownParameter(f"{settings.who} has no parameter '{str(name)[:40]}'{hint}")


def _parameter(row: dict[str, Any]) -> Parameter:
    known = {each.name: row[each.name] for each in fields(Parameter)}
    return Parameter(**{**known, "value": round(row["value"]) if row["whole"] else row["value"]})
