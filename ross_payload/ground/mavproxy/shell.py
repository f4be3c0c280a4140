"""What the word ``ross`` does on a command line: orders, and what is known, in lines of text. It knows no MAVProxy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ross_payload.ground.clients.orders import Doing, Orders, order_of
from ross_payload.ground.monitor import blocks
from ross_payload.ground.monitor.clean import clean
from ross_payload.ground.picture.fleet import Fleet
from ross_payload.ground.picture.known import Payload, Who
from ross_payload.ground.picture.view import view
from ross_protocols.codec import Packet

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
ross payload [ID]                     list payloads, or choose one, such as 2-191
ross help                             show this text
DEG: compass degrees, clockwise, from north or from the nose, as in ross status"""
COMPLETIONS = [
    "<status|sources|explore|stop|cancel|park|home|rearm|noise|turn|payload|help>",
    "listen <voice|azimuth>",
    "record <on|off>",
]
EXPLAINED = 0.4  # [s] in which the reason of a refusal comes behind it


class Shell:
    """Hears packets, obeys lines, and says with ``say`` what became of orders."""

    def __init__(self, orders: Orders, say: Callable[[str], None]) -> None:
        self.fleet = Fleet()
        self._orders, self._say = orders, say
        self._who: Who | None = None
        self._told: dict[int, tuple[str, str]] = {}  # state and reason, by the number of an order
        self._now = 0.0

    def heard(self, packet: Packet, now: float) -> None:
        """Take a packet."""
        self.fleet.hear(packet, now)
        self._orders.heard(packet, now)
        known = self.fleet.payloads.get(Who(packet.system_id, packet.component_id))
        if known is not None:
            self._orders.met(known)
        self.tick(now)

    def tick(self, now: float) -> None:
        """Let time go on; say what became of orders."""
        self._now = now
        self._orders.tick(now)
        for doing in self._orders.doing:
            why_may_come = doing.state in ("refused", "failed") and now - doing.at < EXPLAINED
            if not why_may_come and self._told.get(doing.number) != (doing.state, doing.reason):
                self._told[doing.number] = doing.state, doing.reason
                self._say(_fate(doing))

    @property
    def payload(self) -> Payload | None:
        """The one that is meant: the one chosen, else the first that was heard."""
        known = self.fleet.payloads
        if self._who is None and known:
            self._who = next(iter(known))
        return None if self._who is None else known.get(self._who)

    def summary(self) -> tuple[str, str]:
        """Return one short line for a status bar, and how that is: ``good``, ``act`` or ``unknown``."""
        known = self.payload
        if known is None:
            return "RoSS -", "unknown"
        if self._now - known.last > blocks.SILENT:
            return f"RoSS {known.who} no data", "act"
        picture = self._picture(known)
        k = picture["mission"]["k"]
        state = (picture["standing"]["state"] or "?").replace("_", " ")
        level = "act" if state == "fault" else "good"
        return f"RoSS {known.who} {state}{'' if k is None else f' K {k}'}", level

    def obey(self, words: Sequence[str]) -> None:
        """Obey the words behind ``ross``."""
        what, *rest = [word.lower() for word in words] or ["status"]
        try:
            if what == "help":
                self._say(HELP)
            elif what == "payload":
                self._choose(rest)
            elif what in ("status", "sources"):
                self._show(what)
            else:
                order = order_of(asked(what, rest))
                self._orders.order(self._known().who, order)
                self.tick(self._now)
        except ValueError as error:
            self._say(f"ross: {error}")

    def _known(self) -> Payload:
        known = self.payload
        if known is None:
            who = "no payload" if self._who is None else f"{self._who} not"
            raise ValueError(f"{who} received yet: is it on, and do its [[links]] lead here?")
        return known

    def _show(self, what: str) -> None:
        picture = self._picture(self._known())
        if what == "status":
            lines = blocks.head(picture, self._now) + blocks.strip(picture) + blocks.health(picture)
        else:
            lines = blocks.sources(picture, chosen=None) + blocks.plan(picture)
        for line in lines:
            self._say(line.plain)

    def _choose(self, rest: list[str]) -> None:
        if rest:
            who = Who.parse(rest[0])
            if who not in self.fleet.payloads:
                raise ValueError(f"{who} was not received")
            self._who = who
        self._say("payloads: " + (", ".join(map(str, sorted(self.fleet.payloads))) or "none received yet"))
        self._say(f"commands go to {self._known().who}")

    @staticmethod
    def _picture(known: Payload) -> dict[str, Any]:
        picture: dict[str, Any] = clean(view(known))
        return picture


def _fate(doing: Doing) -> str:
    reason = f": {clean(doing.reason)}" if doing.reason else ""
    return f"RoSS {doing.who} {doing.words}: {doing.state.replace('_', ' ')}{reason}"


def asked(what: str, rest: list[str]) -> dict[str, Any]:
    """Return the order that some words ask for, as `order_of` reads it.

    >>> asked("listen", ["azimuth", "90"]), asked("record", ["off"])
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
    if order is None:
        raise ValueError(f"expected {_usage(what)}, got '{' '.join([what, *rest])}'")
    return {"kind": what, **order}


def _usage(what: str) -> str:
    """Return the line of the help about a word."""
    lines = (line.split("  ")[0] for line in HELP.splitlines())
    return next((line for line in lines if what in line.split()[1].split("|")), "a word that ross help lists")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"expected a number, got '{text}'") from None
