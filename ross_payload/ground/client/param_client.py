"""The client of the parameter protocol: what a payload's parameters are, mean, and become. No port, no clock.

``on_packet`` gets what arrives, ``tick`` the time, ``on_state`` what is known of the payload. What a list left out is
asked for again by index, and all of it after an outage of the link: what others changed meanwhile is told once. A value
is set until it is read back, or refused; an answer so soon that it may be one to the change before is asked for again,
since it does not say which it is for. Without metadata, names and values still show.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from ross_payload.ground.client.component_metadata import MOST_PARAMETERS, Metadata, ParameterDescription
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.status_text import EXPLANATION_S, PREFIX, RecentTexts
from ross_payload.token_bucket import TokenBucket
from ross_protocols.mavlink import params
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.field_converters import FLOAT32_MAX

ANSWER_TIMEOUT_S = 1.0  # [s] without an answer until something is asked for again
LATE_S = 1.5  # [s] after the end of a change, in which an answer may still be one to it
LIST_TIMEOUT_S = 5.0  # [s] between two requests for a list that nobody answers
OUTAGE_S = 3.0  # [s] without a message of the payload
REREADS, REREAD_PERIOD_S = 2, 30.0  # lists after outages at once, and [s] for each in the long run: radios may be slow
READS_AT_ONCE = 8  # parameters that are asked for at once
MOST_SENDS, DOUBTED_SENDS = 5, 2  # that a value is sent, and beyond them of one whose first answers are in doubt
MOST_RECENT = 64  # changes before that are remembered: more than a slider makes in `LATE_S`
KNOWN, SENDING, SET, REFUSED, NO_ANSWER = "known", "sending", "set", "refused", "no_answer"
NOT_ANSWERED = "no answer: is it in range, and may this station set it ([[links]] accept)?"
UNSTEADY = "its parameters keep changing: do two payloads use the same id?"
ERRORS: dict[int, str] = {
    params.ParamError.DOES_NOT_EXIST: "there is no such parameter",
    params.ParamError.VALUE_OUT_OF_RANGE: "out of range",
    params.ParamError.PERMISSION_DENIED: "not permitted for this station",
    params.ParamError.COMPONENT_NOT_FOUND: "there is no such component",
    params.ParamError.READ_ONLY: "it cannot be changed",
}


@dataclass(frozen=True, slots=True)
class _Parameter:
    """One parameter."""

    value: float
    state: str = KNOWN
    reason: str = ""
    wanted: float = math.nan
    since: float = -math.inf  # when a change was asked for [s]
    at: float = 0.0  # latest change of the state [s]
    sent: int = 0  # frames
    kept: bool = False  # another value than the wanted one was heard since
    late: float = -math.inf  # until when answers to the changes before may come [s]
    recent: tuple[float, ...] = ()  # what these changes wanted
    refused_before: bool = False  # one of them was refused, or not answered yet
    doubted: str = ""  # why it is refused, if that was said of this change

    def changed_to(self, wanted: float, now: float) -> _Parameter:
        """Return it while another value is asked for."""
        late, recent, refused = (self.late, self.recent, self.refused_before) if now < self.late else (now, (), False)
        if self.state == SENDING:
            late = max(late, now + LATE_S)
        if now < late:
            recent, refused = (*recent[-MOST_RECENT:], self.wanted), refused or self.state in (SENDING, REFUSED)
        return _Parameter(
            self.value, SENDING, wanted=wanted, since=now, late=late, recent=recent, refused_before=refused
        )

    def ended(self, state: str, reason: str, now: float) -> _Parameter:
        """Return it when a change has ended."""
        return replace(self, state=state, reason=reason, at=now, late=max(self.late, now + LATE_S))

    def may_be_to_another(self, value: float, now: float) -> bool:
        """Tell whether a value that is read back may be what a change before was answered with."""
        return now < self.late and any(params.same_on_the_wire(value, other) for other in self.recent)


class ParamClient:
    """The parameters of one payload, as far as they are known; ``system_id`` and ``component_id`` are ours."""

    def __init__(
        self, send: Callable[[Any, ComponentId], None], who: ComponentId, system_id: int, component_id: int
    ) -> None:
        self.who = who
        self.note = ""
        self._give = send
        self._us = ComponentId(system_id, component_id)
        self._boots: int | None = None
        self._received_at = math.inf  # the latest message [s]
        self._outdated = False  # the list may be: the link was away
        self._rereads = TokenBucket(REREADS, 1 / REREAD_PERIOD_S)
        self._now = 0.0
        self._begin()

    @property
    def values(self) -> dict[str, float]:
        """Every value that is known, by name."""
        return {name: setting.value for name, setting in self._settings.items()}

    @property
    def complete(self) -> bool:
        """Whether all parameters are known."""
        return len(self._read) == self._count

    @property
    def described(self) -> bool:
        """Whether all that will be said about their meaning is known."""
        return self._metadata.over

    def state_of(self, name: str) -> tuple[str, str]:
        """Return what became of the latest change of a parameter, and why; LookupError: there is none."""
        return self._settings[name].state, self._settings[name].reason

    def refresh(self) -> None:
        """Ask for everything again with the next `tick`; what is being set goes on."""
        under_way = {name: setting for name, setting in self._settings.items() if setting.state == SENDING}
        self._begin()
        self._settings |= under_way

    def _begin(self) -> None:
        """Forget everything, and ask for it with the next `tick`."""
        self._settings: dict[str, _Parameter] = {}
        self._names: dict[int, str] = {}  # by index
        self._read: set[int] = set()  # indices that have come since the list was asked for
        self._count: int | None = None
        self._outdated, self._due, self._began = False, -math.inf, self._now
        self._silent_until = -math.inf  # nothing came since values were asked for: until then asking is no use [s]
        self._texts = RecentTexts()
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
        wanted = _number(value)
        if not abs(wanted) <= FLOAT32_MAX:
            raise ValueError(f"{name}: expected a number that a 32-bit float can hold, got {str(value)[:40]}")
        self._settings[name] = self._settings[name].changed_to(wanted, self._now)
        self._send_value(name)

    def on_state(self, payload: PayloadState) -> None:
        """Learn of the payload, whenever it is heard: one that restarted may have other parameters."""
        if self._boots is not None and payload.boots > self._boots:
            self._begin()
        elif payload.last - self._received_at > OUTAGE_S:
            self._outdated = True
        if self._outdated and self._rereads.spend(payload.last):
            self._read.clear()
            self._outdated, self._due = False, -math.inf
        self._boots, self._received_at = payload.boots, payload.last

    def on_packet(self, packet: Packet, now: float) -> None:
        """Take a packet; what is not about these parameters passes by."""
        self._now = now
        if packet.sender != self.who:
            return
        self._silent_until = -math.inf
        self._metadata.on_packet(packet, now)
        answer = params.answer_of(packet.message)
        if isinstance(answer, params.ParamValue):
            self._on_value(answer)
        elif isinstance(answer, params.Refused):
            ours = answer.target.includes(self._us)
            if ours and (setting := self._settings.get(answer.name)) is not None and setting.state == SENDING:
                self._on_error(answer.name, setting, ERRORS.get(answer.error, "refused"))
        elif self._texts.on_packet(packet, now):
            self._explain()

    def tick(self, now: float) -> None:
        """Ask again for what has not come."""
        self._now = now
        if not self.complete and now >= max(self._due, self._silent_until):
            self._ask()
        for name, setting in list(self._settings.items()):
            if setting.state == SENDING and now - setting.at >= ANSWER_TIMEOUT_S:
                if setting.sent < MOST_SENDS + (DOUBTED_SENDS if setting.late > setting.since else 0):
                    self._send_value(name)
                elif setting.kept or setting.doubted:
                    self._refuse(name, setting.doubted or f"it stays at {setting.value:g}")
                else:
                    self._settings[name] = setting.ended(NO_ANSWER, NOT_ANSWERED, now)
        if self._settings:  # the list first: it is what people wait for
            self._metadata.tick(now)

    def _ask(self) -> None:
        if self._count is None or not self._read:
            self._give(params.list_message(self.who), self.who)
            self._due = self._now + LIST_TIMEOUT_S
            return
        missing = [index for index in range(self._count) if index not in self._read]
        for index in missing[:READS_AT_ONCE]:
            self._give(params.read_message(index, self.who), self.who)
        self._due, self._silent_until = self._now + ANSWER_TIMEOUT_S, self._now + LIST_TIMEOUT_S

    def _on_value(self, answer: params.ParamValue) -> None:
        named = answer.name.isascii() and answer.name.isprintable() and answer.name != ""
        if not math.isfinite(answer.value) or not named:
            self.note = "a parameter was left out: invalid value or name"
            return
        count = min(answer.count, MOST_PARAMETERS)
        other_name = answer.index is not None and self._names.get(answer.index, answer.name) != answer.name
        if self._count not in (None, count) or other_name:
            if self._now - self._began < LIST_TIMEOUT_S:
                self.note = UNSTEADY
                return
            self._begin()  # another set of parameters
        if answer.index is not None and answer.index < count:
            self._count = count
            self._names[answer.index] = answer.name
            self._read.add(answer.index)
            self._due = self._now + ANSWER_TIMEOUT_S  # the list goes on
        if answer.count > MOST_PARAMETERS:
            self.note = f"{answer.count} parameters announced: {MOST_PARAMETERS} are shown"
        if answer.name in self._settings or len(self._settings) < MOST_PARAMETERS:
            self._settings[answer.name] = self._changed(self._settings.get(answer.name), answer.value)

    def _changed(self, before: _Parameter | None, value: float) -> _Parameter:
        if before is None:
            return _Parameter(value)
        now = self._now
        wanted = params.same_on_the_wire(value, before.wanted)
        if before.state in (SENDING, NO_ANSWER) and wanted:
            if before.state == SENDING and before.may_be_to_another(value, now):
                return replace(before, value=value)
            return replace(before.ended(SET, "", now), value=value)  # however late
        to_another = before.may_be_to_another(value, now)
        if before.state == SENDING or (before.state == SET and to_another and not wanted):  # it came after a later one
            return replace(before, value=value, state=SENDING, kept=before.kept or not to_another)
        if before.state in (SET, REFUSED) and now - before.at < EXPLANATION_S:
            return replace(before, value=value)  # whoever waits has not seen the end yet
        same = before.value == value and before.state != NO_ANSWER  # what was not answered is known now
        return before if same else replace(before, value=value, state=KNOWN, reason="")

    def _on_error(self, name: str, setting: _Parameter, reason: str) -> None:
        if self._now < setting.late and setting.refused_before:
            self._settings[name] = replace(setting, doubted=reason)  # it is asked once more
        else:
            self._refuse(name, reason)

    def _send_value(self, name: str) -> None:
        setting = self._settings[name]
        self._settings[name] = replace(setting, at=self._now, sent=setting.sent + 1)
        self._give(params.set_message(name, setting.wanted, self.who), self.who)

    def _refuse(self, name: str, reason: str) -> None:
        self._settings[name] = self._settings[name].ended(REFUSED, reason, self._now)
        self._explain()

    def _explain(self) -> None:
        """Let texts say why a value was refused: they begin with the name."""
        for text in self._texts.latest(self._now):
            name, colon, reason = text.text.removeprefix(PREFIX).partition(": ")
            setting = self._settings.get(name)
            if not colon or setting is None or setting.state != REFUSED or text.at <= setting.since:
                continue  # what was said before is about another value
            _, got, told = reason.rpartition(", got ")
            if got and told != f"{setting.wanted:g}":
                continue  # and so is what came late
            if self._now - setting.at < EXPLANATION_S:
                self._settings[name] = replace(setting, reason=reason)


def _row(name: str, setting: _Parameter, description: ParameterDescription | None) -> dict[str, Any]:
    about = asdict(description or ParameterDescription())
    return {"name": name, "value": setting.value, **about, "state": setting.state, "reason": setting.reason}


def _number(value: float) -> float:
    """Return a number of any kind as a float; NaN: it is none, or beyond all bounds."""
    try:
        return math.nan if isinstance(value, str | bytes) else float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan
