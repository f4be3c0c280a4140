"""The client of the parameter protocol: what a payload's parameters are, mean, and become. No port, no clock.

``heard`` takes what arrives, ``tick`` the time, ``met`` what is known of the payload. What a list left out is asked for
again by index; a value is set until it is read back, or refused. Without metadata, names and values still show.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from ross_payload.ground.clients.metadata import MOST_PARAMETERS, Described, Metadata
from ross_payload.ground.picture.known import Payload, Said, Who
from ross_payload.ground.picture.texts import Texts
from ross_protocols.codec import Packet
from ross_protocols.pairs import FLOAT32_MAX
from ross_protocols.params import (
    ParamError,
    Refused,
    Told,
    answer_of,
    list_message,
    read_message,
    same_on_the_wire,
    set_message,
)
from ross_protocols.values import Text

AGAIN = 1.0  # [s] without an answer until something is asked for again
LIST_AGAIN = 5.0  # [s] between two requests for a list that nobody answers
PORTION = 8  # parameters that are asked for at once
TIMES = 5  # that a value is sent
EXPLAINED = 1.5  # [s] around a refusal, in which the payload says why
PREFIX = "RoSS: "  # of the payload's texts
KNOWN, SENDING, SET, REFUSED, NO_ANSWER = "known", "sending", "set", "refused", "no_answer"
UNHEARD = "no answer: is it in range, and may this station set it ([[links]] accept)?"
UNSTEADY = "its parameters keep changing: do two payloads use the same id?"
ERRORS = {
    ParamError.DOES_NOT_EXIST: "there is no such parameter",
    ParamError.VALUE_OUT_OF_RANGE: "out of range",
    ParamError.PERMISSION_DENIED: "not permitted for this station",
    ParamError.COMPONENT_NOT_FOUND: "there is no such component",
    ParamError.READ_ONLY: "it cannot be changed",
}


@dataclass(frozen=True, slots=True)
class _Setting:
    """One parameter."""

    value: float
    state: str = KNOWN
    reason: str = ""
    wanted: float = math.nan
    at: float = 0.0  # latest change of the state [s]
    sent: int = 0  # frames
    kept: bool = False  # another value than the wanted one was heard since


class Settings:
    """The parameters of one payload, as far as they are known; ``system_id`` and ``component_id`` are ours."""

    def __init__(self, send: Callable[[Any, Who], None], who: Who, system_id: int, component_id: int) -> None:
        self.who = who
        self.note = ""
        self._give = send
        self._us = system_id, component_id
        self._boots: int | None = None
        self._now = 0.0
        self.refresh()

    @property
    def values(self) -> dict[str, float]:
        """Every value that is known, by name."""
        return {name: setting.value for name, setting in self._settings.items()}

    @property
    def complete(self) -> bool:
        """Whether all parameters are known."""
        return self._count is not None and len(self._names) == self._count

    def refresh(self) -> None:
        """Forget everything, and ask for it again with the next `tick`."""
        self._settings: dict[str, _Setting] = {}
        self._names: dict[int, str] = {}  # by index
        self._count: int | None = None
        self._due, self._began = -math.inf, self._now
        self._texts = Texts()
        self._lately: list[Said] = []
        self._metadata = Metadata(lambda message: self._give(message, self.who), self.who, *self._us)

    def rows(self) -> list[dict[str, Any]]:
        """Return every parameter as plain JSON, in the payload's order."""
        place = {name: index for index, name in self._names.items()}
        names = sorted(self._settings, key=lambda name: (place.get(name, MOST_PARAMETERS), name))
        return [_row(name, self._settings[name], self._metadata.described.get(name)) for name in names]

    def notes(self) -> list[str]:
        """Return what is odd about the parameters, in words."""
        return [note for note in (self.note, self._metadata.note) if note]

    def set(self, name: str, value: float) -> None:
        """Change a parameter, and follow what becomes of it.

        Raises
        ------
        ValueError
            When there is none of that name, or no number that the wire can carry.
        """
        if name not in self._settings:
            raise ValueError(f"expected the name of a parameter of {self.who}, got '{name[:40]}'")
        if not abs(value) <= FLOAT32_MAX:
            raise ValueError(f"{name}: expected a number that a 32-bit float can hold, got {str(value)[:40]}")
        before = self._settings[name].value
        self._settings[name] = _Setting(before, SENDING, wanted=value)
        self._send_value(name)

    def met(self, payload: Payload) -> None:
        """Learn of the payload, whenever it is heard: one that started anew may have other parameters."""
        if self._boots is not None and payload.boots > self._boots:
            self.refresh()
        self._boots = payload.boots

    def heard(self, packet: Packet, now: float) -> None:
        """Take a packet; what is not about these parameters passes by."""
        self._now = now
        if (packet.system_id, packet.component_id) != (self.who.system, self.who.component):
            return
        self._metadata.heard(packet, now)
        told = answer_of(packet.message)
        if isinstance(told, Told):
            self._told(told)
        elif isinstance(told, Refused):
            ours = told.system_id in (0, self._us[0]) and told.component_id in (0, self._us[1])
            if ours and (setting := self._settings.get(told.name)) is not None and setting.state == SENDING:
                self._refuse(told.name, ERRORS.get(ParamError(told.error), "") if told.error in ERRORS else "refused")
        elif packet.name == "STATUSTEXT" and isinstance(packet.value, Text):
            self._said(self._texts.heard(packet.value, now))

    def tick(self, now: float) -> None:
        """Ask again for what has not come."""
        self._now = now
        if not self.complete and now >= self._due:
            self._ask()
        for name, setting in list(self._settings.items()):
            if setting.state == SENDING and now - setting.at >= AGAIN:
                self._insist(name, setting)
        if self._settings:  # the list first: it is what people wait for
            self._metadata.tick(now)

    def _ask(self) -> None:
        who = self.who.system, self.who.component
        if self._count is None:
            self._give(list_message(*who), self.who)
            self._due = self._now + LIST_AGAIN
            return
        missing = [index for index in range(self._count) if index not in self._names]
        for index in missing[:PORTION]:
            self._give(read_message(index, *who), self.who)
        self._due = self._now + AGAIN

    def _told(self, told: Told) -> None:
        named = told.name.isascii() and told.name.isprintable() and told.name != ""
        if not math.isfinite(told.value) or not named:
            self.note = "a parameter was left out: invalid value or name"
            return
        count = min(told.count, MOST_PARAMETERS)
        other_name = told.index is not None and self._names.get(told.index, told.name) != told.name
        if self._count not in (None, count) or other_name:
            if self._now - self._began < LIST_AGAIN:
                self.note = UNSTEADY
                return
            self.refresh()  # another set of parameters
        if told.index is not None and told.index < count:
            self._count = count
            self._names[told.index] = told.name
            self._due = self._now + AGAIN  # the list goes on
        if told.count > MOST_PARAMETERS:
            self.note = f"{told.count} parameters announced: {MOST_PARAMETERS} are shown"
        if told.name in self._settings or len(self._settings) < MOST_PARAMETERS:
            self._settings[told.name] = self._changed(self._settings.get(told.name), told.value)

    def _changed(self, before: _Setting | None, value: float) -> _Setting:
        if before is None:
            return _Setting(value)
        if before.state != SENDING:
            return replace(before, value=value) if before.value == value else _Setting(value)
        if same_on_the_wire(value, before.wanted):
            return _Setting(value, SET, at=self._now)
        return replace(before, value=value, kept=True)

    def _insist(self, name: str, setting: _Setting) -> None:
        if setting.sent < TIMES:
            self._send_value(name)
        elif setting.kept:
            self._refuse(name, f"it stays at {setting.value:g}")
        else:
            self._settings[name] = replace(setting, state=NO_ANSWER, reason=UNHEARD, at=self._now)

    def _send_value(self, name: str) -> None:
        setting = self._settings[name]
        self._settings[name] = replace(setting, at=self._now, sent=setting.sent + 1)
        self._give(set_message(name, setting.wanted, self.who.system, self.who.component), self.who)

    def _refuse(self, name: str, reason: str) -> None:
        self._settings[name] = replace(self._settings[name], state=REFUSED, reason=reason, at=self._now)
        self._said([])

    def _said(self, fresh: list[Said]) -> None:
        """Let texts say why a value was refused: they begin with the name."""
        self._lately = [said for said in (*self._lately, *fresh) if self._now - said.at < EXPLAINED]
        for said in self._lately:
            name, colon, reason = said.text.removeprefix(PREFIX).partition(": ")
            setting = self._settings.get(name)
            if colon and setting is not None and setting.state == REFUSED and self._now - setting.at < EXPLAINED:
                self._settings[name] = replace(setting, reason=reason)


def _row(name: str, setting: _Setting, described: Described | None) -> dict[str, Any]:
    means = described or Described()
    return {
        "name": name,
        "value": setting.value,
        "default": means.default,
        "min": means.least,
        "max": means.most,
        "unit": means.unit,
        "description": means.description,
        "group": means.group,
        "whole": means.whole,
        "state": setting.state,
        "reason": setting.reason,
    }
