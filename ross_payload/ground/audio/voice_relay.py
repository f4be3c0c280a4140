"""The sound of one payload: ordered while anybody listens, received once, and given to all who do.

What a payload is to send is an order like any other. That it does so is told by ROSS_STREAM alone: by the address and
the port, which are ours, a stream is known whose number the payload has chosen; and what goes there although nobody
listens any more is stopped, as often as that takes.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from ross_payload.ground.audio.rtp_port import RtpPort
from ross_payload.ground.audio.sound_queue import Listener, frame_of
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_status import FAILED, NO_ANSWER, REFUSED, CommandStatus
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.client.stream_orders import StopStream
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.stream_rows import instead, whom
from ross_payload.ground.model.stream_rows import words as words_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_values import StreamReport

BLOCK_S = 0.01  # of sound that is given on at once
LATE_S = 0.5  # behind the clock, from which on what was missed is not made up for
WORDS_PERIOD_S = 0.25  # between two messages of how it goes
LINGER_S = 1.0  # that a port stays open for the end of its stream
STOP_PERIOD_S = 2.0  # between two orders to end a stream
RATES = (48000, 24000, 16000, 12000, 8000)  # that Opus knows [Hz]; the first for all others
MEASURED = 0.01  # share by which a rate that was measured may be wrong
MOST_SENSIBLE_S = 60.0  # of an age, beyond which clocks disagree
CHOICES = ("what", "source", "azimuth")  # that a listener makes


class Towards(Protocol):
    """What a relay wants of a ground station."""

    fleet: Fleet

    def now(self) -> float:
        """Return the time [s]."""

    def address_towards(self, who: ComponentId) -> str:
        """Return the address of this computer as a payload reaches it; GroundError: there is none."""


class VoiceRelay:
    """Of one payload, for as long as the ground station runs.

    Parameters
    ----------
    who
        The payload.
    station
        Hears it.
    orders
        Orders it.
    log
        Takes a line for every beginning and end.
    address
        Of this computer, as the payload reaches it; empty: that of the way on which it is heard.
    """

    def __init__(
        self,
        who: ComponentId,
        station: Towards,
        orders: CommandProtocol,
        log: Callable[[str], None],
        address: str = "",
    ) -> None:
        self.who, self._station, self._orders, self._log, self._address = who, station, orders, log, address
        self._listeners: dict[Listener, float] = {}  # since when [s]
        self._choice: dict[str, Any] = {"what": "target"}
        self._port: RtpPort | None = None
        self._opening = asyncio.Lock()
        self._playing: asyncio.Task[None] | None = None
        self._order: int | None = None  # number of the latest order to stream
        self._boots = 0  # of the payload, when it was ordered
        self._ordered_at = -STOP_PERIOD_S  # [s]
        self._ending: dict[RtpPort, float] = {}  # that wait for the end of their stream, since when [s]
        self._places: dict[tuple[str, int], float] = {}  # that were ordered ever, and when their end was [s]

    @property
    def listeners(self) -> tuple[Listener, ...]:
        """Who listens at present."""
        return tuple(self._listeners)

    async def join(self, listener: Listener, choice: Mapping[str, Any]) -> None:
        """Let somebody listen, and choose for all who do.

        Raises
        ------
        GroundError
            When nothing can be received.
        ValueError
            When that is no choice.
        """
        async with self._opening:
            if self._port is None:
                host = self._address or self._station.address_towards(self.who)
                self._port = await RtpPort(self._rate(), self._station.now, time.time).open(host)
                self._playing = asyncio.create_task(self._play(self._port))
        try:
            self.choose(choice)
        except ValueError:
            self._end_unless_heard()
            raise
        self._listeners[listener] = self._station.now()
        self._log(f"{listener.name} listens to {self.who}: {self._words}")
        self._tell()

    def leave(self, listener: Listener) -> None:
        """Let somebody listen no more; the last one ends the stream. Idempotent."""
        since = self._listeners.pop(listener, None)
        if since is None:
            return
        lasted = self._station.now() - since
        self._log(f"{listener.name} listens to {self.who} no more, after {lasted:.0f} s{_lost(self._port)}")
        self._end_unless_heard()
        self._tell()

    def choose(self, choice: Mapping[str, Any]) -> None:
        """Order what all listeners hear: ``what`` is mixture, target, source (its ``source``) or azimuth ([deg]).

        Raises
        ------
        ValueError
            When that is no choice.
        """
        if self._port is None:
            raise ValueError("no listener")
        choice = {name: choice[name] for name in CHOICES if choice.get(name) is not None}
        address, port = self._port.place
        order = order_of({"kind": "stream", "address": address, "port": port, "codec": self._port.codec, **choice})
        if "what" not in choice:
            raise ValueError("what: expected mixture, target, source or azimuth, got nothing")
        known = self._known
        self._choice, self._boots = choice, 0 if known is None else known.boots
        self._places[address, port] = -STOP_PERIOD_S
        self._order, self._ordered_at = self._orders.order(self.who, order), self._station.now()
        self._tell()

    def tick(self) -> None:
        """Do what is due; call it ten times a second."""
        known, now = self._known, self._station.now()
        for port in [port for port, since in self._ending.items() if now - since > LINGER_S]:
            self._close(port)
        if known is None:
            return
        here = None if self._port is None else self._port.place
        given_up = _given_up(self._stream) and now - self._ordered_at >= STOP_PERIOD_S
        if here is not None and (known.boots != self._boots or given_up):
            self.choose(self._choice)
        for stream in known.streams:
            place = stream.address, stream.port
            ended = self._places.get(place)
            if stream.on and place != here and ended is not None and now - ended >= STOP_PERIOD_S:
                self._places[place] = now
                self._orders.order(self.who, StopStream(None, *place))  # its number may be another's when this comes

    def end(self) -> None:
        """End the stream, whoever listens."""
        for listener in self.listeners:
            self.leave(listener)

    def close(self) -> None:
        """Receive nothing more."""
        self.end()
        for port in tuple(self._ending):
            self._close(port)

    # ------------------------------------------------------------------------------------------- inside

    @property
    def _known(self) -> PayloadState | None:
        return self._station.fleet.payloads.get(self.who)

    @property
    def _stream(self) -> StreamReport | None:
        """What the payload tells of the stream that comes here."""
        known = self._known
        here = None if self._port is None else self._port.place
        streams = () if known is None else known.streams
        return next((each for each in streams if (each.address, each.port) == here), None)

    @property
    def _words(self) -> str:
        which = {"source": " {source}", "azimuth": " {azimuth:g} deg"}.get(self._choice["what"], "")
        return f"{self._choice['what']}{which.format(**self._choice)}"

    def _rate(self) -> int:
        known = self._known
        told = None if known is None or known.audio is None else known.audio.rate
        near = (rate for rate in RATES if told and abs(told / rate - 1) < MEASURED)
        return next(near, RATES[0])

    def _end_unless_heard(self) -> None:
        if self._listeners or self._port is None:
            return
        if self._playing is not None:
            self._playing.cancel()
        self._ending[self._port] = self._station.now()  # closed at once, it would be called a fault of the stream
        self._port = self._playing = self._order = None
        self.tick()

    def _close(self, port: RtpPort) -> None:
        del self._ending[port]
        port.close()

    async def _play(self, port: RtpPort) -> None:
        """Give on what is received, as the clock asks for it, until cancelled."""
        block, index, told = round(BLOCK_S * port.rate), 0, 0.0
        due = self._station.now()
        while True:
            now = self._station.now()
            due = now if now > due + LATE_S else due + BLOCK_S
            await asyncio.sleep(max(due - now, 0.0))
            samples, age = port.read(block)
            if port.receiver.reception(self._station.now()).playing:
                sensible = age if age is not None and 0 <= age < MOST_SENSIBLE_S else None
                frame = frame_of(samples, index, sensible)
                for listener in self.listeners:
                    listener.hear(frame)
            index += block
            if due - told >= WORDS_PERIOD_S:
                told = due
                self._tell()

    def _tell(self) -> None:
        """Tell all who listen how it goes."""
        if self._port is None:
            return
        reception = self._port.receiver.reception(self._station.now())
        doing = next((each for each in self._orders.doing if each.number == self._order), None)
        stream = self._stream
        state, why = _state(doing, stream, playing=reception.playing, ended=reception.ended)
        told = {
            "type": "listening",
            "state": state,
            "why": why,
            "rate": self._port.rate,
            "choice": self._choice,
            "whom": self._words if stream is None else whom(stream),
            "separated": stream is not None and stream.separated,
            "instead": "" if stream is None else instead(stream),
            "listeners": len(self._listeners),
            "received": reception.received,
            "lost": reception.lost,
            "late": reception.late,
            "made_up_ms": round(1000 * reception.concealed_s),
            "waiting_ms": round(1000 * reception.delay_s),
            "jitter_ms": round(1000 * reception.jitter_s, 1),
        }
        for listener in self.listeners:
            listener.send({**told, "dropped": listener.dropped})


def _state(doing: CommandStatus | None, stream: StreamReport | None, *, playing: bool, ended: bool) -> tuple[str, str]:
    """Return how it goes, as a word and, where there is something to say, in words."""
    if doing is not None and doing.state in (REFUSED, FAILED, NO_ANSWER) and not playing:
        return "refused", doing.reason
    if stream is not None and stream.fault:
        return "fault", words_of(stream)
    if _given_up(stream) and stream is not None:
        return "waiting", stream.detail
    if ended or (stream is not None and not stream.on and doing is not None and not playing):
        return "ended", "the payload has ended the stream"
    return ("playing" if playing else "waiting"), stream.detail if stream is not None else ""


def _given_up(stream: StreamReport | None) -> bool:
    """Tell whether the payload has ended a stream since it did not hear from us: not because anybody wanted it."""
    return stream is not None and not stream.on and stream.listeners == 0


def _lost(port: RtpPort | None) -> str:
    if port is None:
        return ""
    reception = port.receiver.reception(0.0)
    return f"; {reception.lost} of {reception.received + reception.lost} packets were lost"
