"""What the word ``ross`` does on a command line: orders, and what is known, in lines of text. It knows no MAVProxy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from rich.text import Text

from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_status import CommandStatus
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.terminal import blocks
from ross_payload.ground.terminal.blocks import clean
from ross_payload.ground.terminal.controller import Selection
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_command import place_of

HELP = """\
ross status                           what the payload does, and its health
ross sources                          the sources, and where to turn
ross explore                          find the number of sources and their azimuths
ross listen voice|SOURCE|azimuth DEG  listen to the enrolled voice, a source, or an azimuth
ross turn DEG                         point the axis to a heading
ross stop                             stop now; nothing moves before ross rearm
ross cancel                           end the current task
ross park|home|rearm                  go to the parking position; find the zero; accept moves again after a stop
ross record on|off                    record a session on the payload's disk
ross noise [SECONDS]                  measure the noise while no one talks
ross streams                          live listening: what goes where
ross stream WHOM ADDRESS:PORT         listen, live: opus, or /L16 behind the port, by RTP
ross stream NUMBER WHOM|GAIN|mute     change a stream: whom, or its gain in dB
ross stream off [NUMBER|ADDRESS:PORT] end a stream, or all of them
ross enrol WHOM consent [N] [SECONDS] enrol a talker who has agreed, as talker-N
ross payload [ID]                     list payloads, or choose one, such as 2-191
ross help                             show this text
WHOM: target, mixture, source N, azimuth DEG
DEG: compass degrees, clockwise, from north or from the nose, as in ross status"""
COMPLETIONS = [
    "<status|sources|explore|stop|cancel|park|home|rearm|noise|turn|payload|help>",
    "listen <voice|azimuth>",
    "record <on|off>",
    "streams",
    "stream <target|mixture|source|azimuth|off>",
    "enrol <source|azimuth>",
]
REASON_WITHIN_S = 0.4  # in which the reason of a refusal comes behind it


class Shell:
    """Takes packets and lines, and writes with ``write`` what became of commands."""

    def __init__(self, orders: CommandProtocol, write: Callable[[str], None]) -> None:
        self.fleet = Fleet()
        self._selection, self._write = Selection(self.fleet, orders), write
        self._reported: dict[int, tuple[str, str]] = {}  # state and reason, by the number of a command

    def on_packet(self, packet: Packet, now: float) -> None:
        """Take a packet."""
        self.fleet.on_packet(packet, now)
        self._selection.on_packet(packet, now)
        self.tick(now)

    def tick(self, now: float) -> None:
        """Let time go on; write what became of commands."""
        self._selection.tick(now)
        for doing in self._selection.orders.doing:
            why_may_come = doing.state in ("refused", "failed") and now - doing.at < REASON_WITHIN_S
            if not why_may_come and self._reported.get(doing.number) != (doing.state, doing.reason):
                self._reported[doing.number] = doing.state, doing.reason
                self._write(_outcome_text(doing))

    @property
    def payload(self) -> PayloadState | None:
        """The one that is meant: the one chosen, else the first that was heard."""
        return self._selection.payload

    def summary(self) -> tuple[str, str]:
        """Return one short line for a status bar, and how that is: ``good``, ``act`` or ``unknown``."""
        known = self.payload
        if known is None:
            return "RoSS -", "unknown"
        if self._selection.now - known.last > blocks.SILENT_S:
            return f"RoSS {known.who} no data", "act"
        view = blocks.safe_view(known)
        k = view["mission"]["k"]
        state = (view["standing"]["state"] or "?").replace("_", " ")
        level = "act" if state == "fault" else "good"
        return f"RoSS {known.who} {state}{'' if k is None else f' K {k}'}", level

    def execute(self, words: Sequence[str]) -> None:
        """Do what the words say behind ``ross``."""
        what, *rest = [word.lower() for word in words] or ["status"]
        try:
            if what == "help":
                self._write(HELP)
            elif what == "payload":
                self._choose(rest)
            elif what in ("status", "sources", "streams"):
                self._show(what)
            else:
                order = order_of(order_of_words(what, rest))
                self._selection.orders.order(self._known().who, order)
                self.tick(self._selection.now)
        except ValueError as error:
            self._write(f"ross: {error}")

    def _known(self) -> PayloadState:
        known = self.payload
        if known is None:
            who = "no payload" if self._selection.wanted is None else f"{self._selection.wanted} not"
            raise ValueError(f"{who} received yet: is it on, and do its [[links]] lead here?")
        return known

    def _show(self, what: str) -> None:
        view = blocks.safe_view(self._known())
        if what == "status":
            lines = blocks.head(view, self._selection.now) + blocks.strip(view)
            lines += blocks.health(view) + blocks.streams(view)
        elif what == "streams":
            lines = blocks.streams(view) or [Text("no streams")]
        else:
            lines = blocks.sources(view, chosen=None) + blocks.plan(view)
        for line in lines:
            self._write(line.plain)

    def _choose(self, rest: list[str]) -> None:
        if rest:
            who = ComponentId.parse(rest[0])
            if who not in self.fleet.payloads:
                raise ValueError(f"{who} was not received")
            self._selection.wanted = who
        self._write("payloads: " + (", ".join(map(str, sorted(self.fleet.payloads))) or "none received yet"))
        self._write(f"commands go to {self._known().who}")


def _outcome_text(doing: CommandStatus) -> str:
    reason = f": {clean(doing.reason)}" if doing.reason else ""
    return f"RoSS {doing.who} {doing.words}: {doing.state.replace('_', ' ')}{reason}"


def order_of_words(what: str, rest: list[str]) -> dict[str, Any]:
    """Return the order that some words ask for, as `order_of` reads it.

    >>> order_of_words("listen", ["azimuth", "90"]), order_of_words("record", ["off"])
    ({'kind': 'listen', 'azimuth': 90.0}, {'kind': 'record', 'on': False})

    Raises
    ------
    ValueError
        When they ask for none.
    """
    order: dict[str, Any] | None = None
    match what, rest:
        case ("explore" | "stop" | "cancel" | "park" | "home" | "rearm", []):
            order = {}
        case ("noise", []):
            order = {"seconds": 0.0}
        case ("noise", [seconds]):
            order = {"seconds": _number(seconds)}
        case ("turn", [heading]):
            order = {"heading": _number(heading)}
        case ("record", ["on" | "off" as way]):
            order = {"on": way == "on"}
        case ("listen", ["voice"]):
            order = {}
        case ("listen", ["azimuth", azimuth]):
            order = {"azimuth": _number(azimuth)}
        case ("listen", [source]):
            order = {"source": _number(source)}
        case ("stream", _):
            return stream_of_words(rest) or _refuse(what, rest)
        case ("enrol", _):
            order = _enrolment(rest)
    if order is None:
        _refuse(what, rest)
    return {"kind": what, **(order or {})}


def _refuse(what: str, rest: list[str]) -> NoReturn:
    raise ValueError(f"expected {_usage(what)}, got '{' '.join([what, *rest])}'")


def stream_of_words(rest: list[str]) -> dict[str, Any] | None:
    """Return the order behind the word ``stream``; None: it is none.

    >>> stream_of_words(["source", "2", "127.0.0.1:5004/L16"])
    {'kind': 'stream', 'what': 'source', 'source': 2.0, 'address': '127.0.0.1', 'port': 5004, 'codec': 'L16'}
    """
    match rest:
        case ["off", place] if ":" in place:
            address, port, _ = place_of(place)
            return {"kind": "stop_stream", "address": address, "port": port}
        case ["off", *number] if len(number) < 2:
            return {"kind": "stop_stream", **({"stream": _number(number[0])} if number else {})}
        case [*whom, place] if ":" in place and (selection := _selection(whom)):
            address, port, codec = place_of(place)
            return {"kind": "stream", **selection, "address": address, "port": port, "codec": codec}
        case [number, *change] if number.isdecimal() and (changed := _change(change)):
            return {"kind": "stream", "stream": _number(number), **changed}
    return None


def _change(words: list[str]) -> dict[str, Any] | None:
    match words:
        case ["mute"]:
            return {"muted": True}
        case [gain] if gain.lstrip("+-").replace(".", "", 1).isdecimal():
            return {"gain": _number(gain), "muted": False}
    return _selection(words)


def _selection(whom: list[str]) -> dict[str, Any] | None:
    match whom:
        case ["target" | "mixture" as what]:
            return {"what": what}
        case ["source" | "azimuth" as what, which]:
            return {"what": what, what: _number(which)}
    return None


def _enrolment(rest: list[str]) -> dict[str, Any] | None:
    match rest:
        case ["source" | "azimuth" as what, which, "consent", *more] if len(more) < 3:
            numbers = zip(("voice", "seconds"), map(_number, more), strict=False)
            return {what: _number(which), "consent": True, **dict(numbers)}
    return None


def _usage(what: str) -> str:
    """Return the line of the help about a word."""
    lines = (line.split("  ")[0] for line in HELP.splitlines())
    return next((line for line in lines if what in line.split()[1].split("|")), "a word that ross help lists")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"expected a number, got '{text}'") from None
