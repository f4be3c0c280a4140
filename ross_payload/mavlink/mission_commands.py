"""Commands from the links to orders for the mission, and what becomes of these back as acknowledgements.

`on_event` takes what the mission says, `tick` the time: both, like the commands, on the thread of the pump. A command
is answered at once, or within `ANSWER_TIMEOUT_S` when the mission is asked first; what is in progress says so once a
second. A stop is obeyed at once and acknowledged when it is on the disk: what is acknowledged outlives a crash.

What is sent again is answered again and not obeyed again: a confirmation above 0, a COMMAND_INT while its like goes on,
a frame that the network doubled or delayed. Only a stop is obeyed whenever it arrives; what its sender had asked before
it is refused when it arrives after it. Nothing here arms a vehicle or ends a flight.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from typing import Protocol

from ross_payload.errors import ConfigError
from ross_payload.events import Answer, Answered, Event
from ross_payload.mavlink.command_dedup import (
    RESENT,
    Entry,
    FrameCounter,
    Origin,
    RecentCancels,
    RecentCommands,
    is_before,
)
from ross_payload.mavlink.command_gate import CommandGate
from ross_payload.mavlink.command_parser import INFORM, READERS, STOP, Record, asked, name_of
from ross_payload.mavlink.command_server import ACCEPTED, SENDERS, CommandServer, Handler, Verdict
from ross_payload.mavlink.component import Component, Received
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.orders import Cancel, Order, Stop, Task
from ross_payload.streams import StreamOrder
from ross_payload.token_bucket import TokenBucket
from ross_protocols.mavlink.commands import HEARD, CancelRequest, Command, Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Severity

ANSWER_TIMEOUT_S = 0.1  # [s] for the mission to answer before the sender hears that it waits
PROGRESS_PERIOD = 1.0  # [s]
STOP_SAVING = 2.0  # [s] that the disk may take until a stop is acknowledged without it
STOP_PERIOD = 0.1  # [s] between two stops that reach the mission: a flood of them is one
FORGOTTEN = Verdict(Result.FAILED, "not known any longer: has the payload restarted?")
REBOOT = common.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN

FINAL = {
    Answer.ACCEPTED: Result.ACCEPTED,  # of what is no task
    Answer.REFUSED: Result.DENIED,
    Answer.DONE: Result.ACCEPTED,
    Answer.FAILED: Result.FAILED,
    Answer.CANCELLED: Result.CANCELLED,
}


class StopMemory(Protocol):
    """Has a stop outlive this process."""

    @property
    def saved(self) -> bool:
        """Whether the disk has taken, or refused, everything so far."""

    @property
    def failure(self) -> str:
        """Why the disk refused the latest; empty when it did not."""


def no_streams(order: StreamOrder) -> str:
    """Refuse to let anybody listen."""
    return "this payload has no live listening"


class MissionCommands:
    """Answers the commands that are meant for the payload.

    Parameters
    ----------
    component
        Ours.
    give
        Hands an order to the runner; a stop takes effect before it returns.
    record
        Starts or stops the recording; returns why not, or nothing.
    send_text
        Tells an operator something.
    requests
        Obeys the commands that ask for messages.
    stream
        Starts, changes or ends a stream of live listening; returns why not, or nothing.
    latch
        Tells when a stop is on the disk: it is acknowledged then. None: at once.
    """

    def __init__(
        self,
        component: Component,
        give: Callable[[Order], None],
        record: Callable[[bool], str],
        send_text: Callable[[Severity, str], None],
        requests: MessageRequests,
        *,
        stream: Callable[[StreamOrder], str] = no_streams,
        latch: StopMemory | None = None,
    ) -> None:
        self._give = give
        self._record = record
        self._stream = stream
        self._send_text = send_text
        self._gate = CommandGate()
        self._frames = FrameCounter()
        self._origin: Origin | None = None  # of the packet that is being taken
        self._cancels = RecentCancels()
        self._recent = RecentCommands()
        self._open: dict[int, Entry] = {}  # what the mission has, by the number of the order
        self._numbers = count(1)
        self._now = 0.0
        self._next_stop = -math.inf  # [s]
        self._latch = latch
        self._unsaved: dict[ComponentId, Entry] = {}  # stops that are obeyed and not yet on the disk
        self._overdue = math.inf  # when their senders hear so [s]
        self._texts = TokenBucket(burst=4, rate=0.5)
        component.subscribe(self._count)
        handlers: dict[int, Handler] = {REBOOT: _reboot, **requests.handlers}
        handlers |= dict.fromkeys(READERS, self._command) | {STOP: self._stop}
        self._server = CommandServer(
            component,
            handlers,
            urgent=frozenset({STOP}),
            on_cancel=self._cancel,
            repeated=self._repeated,
            explain=self._explain,
        )

    def on_event(self, event: Event) -> None:
        """Take what the mission says; answers to orders go on to whoever commanded them."""
        self._gate.on_event(event)
        entry = self._open.get(event.order) if isinstance(event, Answered) else None
        if not isinstance(event, Answered) or entry is None:
            return
        if event.answer is Answer.PROGRESS:
            entry.progress = event.progress
            self._report(entry)
        elif event.answer is Answer.ACCEPTED and isinstance(entry.order, Task):
            entry.kept = None
            self._report(entry)
        else:
            self._close(entry, event)

    def tick(self, now: float) -> None:
        """Tell those who wait that their command is in progress."""
        self._now = now
        self._server.tick(now)
        for entry in self._open.values():
            if now >= entry.due:
                self._report(entry)
        if self._latch is not None and self._unsaved:
            self._acknowledge_stops(self._latch, now)

    def _count(self, received: Received) -> None:
        """Count the frames of every sender, whatever they carry."""
        packet = received.packet
        self._origin = self._frames.note(packet.sender, received.way, packet.sequence, self._now)

    def _stop(self, command: Command, received: Received, now: float) -> None:
        """Stop, whatever was ordered before, and however often."""
        if self._origin is None:
            return
        entry = Entry(command, self._origin, now, Result.ACCEPTED)
        self._recent.note_stop(entry)
        if now >= self._next_stop:
            self._order(Stop())
            self._next_stop = now + STOP_PERIOD
        sender = entry.origin.sender
        if not self._server.allows(sender):
            return
        if self._latch is None:
            self._send(entry)
            return
        if not self._unsaved:
            self._overdue = now + STOP_SAVING
        first = self._unsaved.get(sender)
        entry.due = now + ANSWER_TIMEOUT_S if first is None else first.due
        if first is not None or len(self._unsaved) < SENDERS:
            self._unsaved[sender] = entry

    def _acknowledge_stops(self, latch: StopMemory, now: float) -> None:
        """Acknowledge the stops that are on the disk; those that cannot be are obeyed all the same, and it is said."""
        if not latch.saved and now < self._overdue:
            for entry in self._unsaved.values():
                if now >= entry.due:
                    entry.due = now + PROGRESS_PERIOD
                    self._send(replace(entry, result=Result.IN_PROGRESS))
            return
        for entry in self._unsaved.values():
            self._send(entry)
        self._unsaved.clear()
        trouble = latch.failure or ("" if latch.saved else "the disk does not respond")
        if trouble:
            self._send_text(Severity.CRITICAL, f"stopped, but a restart clears it: {trouble}")

    def _command(self, command: Command, received: Received, now: float) -> None:
        """Obey or refuse a command of our dialect, unless it is only sent again."""
        if self._repeated(command, received, now):
            return
        origin = self._origin
        if origin is None or self._recent.before(command, origin, now):
            return  # its sender has asked for something else since
        if command.confirmation >= HEARD:
            self._server.answer(command, origin.sender, FORGOTTEN)
            return
        before = self._recent.find(origin.sender, command.number)
        entry = Entry(command, origin, now, kept=before and before.current)
        verdict = self._obey(entry)
        self._recent.note(entry)
        if verdict is not None:
            entry.result = verdict.result
            entry.kept = None if verdict is ACCEPTED else entry.kept
            self._server.answer(command, origin.sender, verdict)
        elif entry.kept is not None and entry.kept.order is not None:
            entry.kept.silent = True  # its end would look like the end of the new one
            entry.kept.kept = None  # however many wait: what is no task may be said again and again

    def _repeated(self, command: Command, received: Received, now: float) -> bool:
        """Answer a command that is only sent again; tell whether it is."""
        known = None if self._origin is None else self._recent.repeated(command, self._origin, now)
        goes_on = known is not None and known.order is not None and not isinstance(known.order, Task)
        if known is not None and (goes_on or not (known.waits or known.silent)):
            self._send(known)
        return known is not None

    def _obey(self, entry: Entry) -> Verdict | None:
        """Return what becomes of a command; None: the mission has it."""
        command = entry.command
        if command.number == INFORM and not command.long:
            return Verdict(Result.COMMAND_LONG_ONLY)
        try:
            wanted = asked(command)
        except ConfigError as error:
            return Verdict(Result.DENIED, str(error))
        if isinstance(wanted, Record | StreamOrder):
            reason = self._record(wanted.on) if isinstance(wanted, Record) else self._stream(wanted)
            return Verdict(Result.FAILED, reason) if reason else ACCEPTED
        if self._recent.not_after(STOP, entry.origin, self._now):
            return Verdict(Result.TEMPORARILY_REJECTED, "sent before the stop")
        return self._gate.refusal(wanted) or self._hand_over(entry, wanted)

    def _hand_over(self, entry: Entry, wanted: Order) -> Verdict | None:
        order = self._order(wanted)
        entry.order, entry.due = order, self._now + ANSWER_TIMEOUT_S
        self._open[order.number] = entry
        return None

    def _order(self, wanted: Order) -> Order:
        """Give an order a number and give it to the mission."""
        order = replace(wanted, number=next(self._numbers))
        self._next_stop = -math.inf
        self._gate.on_order(order)
        self._give(order)
        return order

    def _cancel(self, request: CancelRequest, received: Received) -> None:
        """End a task in progress, whoever commanded it; one that has just ended is answered again.

        What was ordered since is none that it means, where the network has doubled or delayed it, or a router has sent
        it on another link, too.
        """
        if not received.may_order:
            if received.refusal and self._texts.spend(self._now):
                self._send_text(Severity.WARNING, f"cancel refused: {received.refusal}")
            return
        origin = self._origin
        if origin is None:
            return
        first = self._cancels.note(request.number, origin)
        going_on = [e for e in self._open.values() if e.command.number == request.number and isinstance(e.order, Task)]
        for entry in going_on:
            if not (entry.cancelled or entry.silent or is_before(origin, first, entry)):
                entry.cancelled = True
                self._order(Cancel())
        sender = received.packet.sender
        known = self._recent.find(sender, request.number)
        recent = known is not None and self._now - known.current.time < RESENT
        if known is not None and recent and not going_on and self._server.allows(sender):
            self._send(known.current)

    def _close(self, entry: Entry, event: Answered) -> None:
        """Tell the sender how its command ended."""
        del self._open[event.order]
        waited = entry.waits
        entry.order, entry.result, entry.time = None, FINAL[event.answer], self._now
        entry.lost = self._frames.lost(entry.origin)
        if entry.silent:
            return
        self._send(entry)
        if event.answer is not Answer.REFUSED:
            entry.kept = None
            return
        self._explain(entry.command, event.reason)
        if entry.kept is not None and entry.kept.silent:
            if waited:  # the other one goes on, or has ended meanwhile
                entry.kept.silent = False
                self._report(entry.kept)
            else:
                entry.kept = None  # over before this one, and never told: what is sent again means this one

    def _report(self, entry: Entry) -> None:
        """Tell the sender that its command goes on; once only while another one of its kind may go on instead.

        Who hears it twice takes the other one for ended.
        """
        if not entry.silent:
            entry.due = self._now + PROGRESS_PERIOD if not entry.waits else math.inf
            self._send(entry)

    def _explain(self, command: Command, reason: str) -> None:
        if self._texts.spend(self._now):
            self._send_text(Severity.WARNING, f"{name_of(command)} refused: {reason}")

    def _send(self, entry: Entry) -> None:
        self._server.acknowledge(entry.command, entry.origin.sender, entry.result, entry.progress)


def _reboot(command: Command, received: Received, now: float) -> Verdict:
    return Verdict(Result.DENIED, "the payload does not restart by command")
