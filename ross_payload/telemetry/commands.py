"""The command server: commands from the links to orders, and what becomes of these back as acknowledgements.

``heard`` takes what arrives, ``said`` what the mission says, ``tick`` the time: all on the thread of the pump. A
command is answered at once, or within `PATIENCE` when the mission is asked first; what is in progress says so once a
second. A stop is obeyed at once and acknowledged when it is on the disk, so that what is acknowledged outlives a crash.

What is sent again is answered again and not obeyed again: a confirmation above 0, a COMMAND_INT while its like goes on,
a frame that the network doubled or delayed. Only a stop is obeyed whenever it arrives; what its sender had asked before
it is refused when it arrives after it. Nothing here arms a vehicle or ends a flight.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from typing import Protocol

from ross_payload.errors import ConfigError
from ross_payload.events import Answer, Answered, Event
from ross_payload.links import Heard
from ross_payload.orders import Cancel, Order, Stop, Task
from ross_payload.telemetry.allowance import Allowance
from ross_payload.telemetry.asked import INFORM, READERS, STOP, Record, asked, name_of
from ross_payload.telemetry.identity import Endpoint
from ross_payload.telemetry.ledger import Entry, Ledger, Origin, Places, Sender
from ross_payload.telemetry.posture import Posture
from ross_payload.telemetry.requests import ACCEPTED, Requests, Verdict
from ross_protocols.commands import CancelRequest, Command, Result, acknowledgement, command_of
from ross_protocols.dialect import common
from ross_protocols.values import Severity

PATIENCE = 0.1  # [s] for the mission to answer before the sender hears that it waits
PROGRESS_PERIOD = 1.0  # [s]
BURST, RATE = 40, 20.0  # commands of one sender at once, and [1/s]; what is more is not even answered
STOP_SAVING = 2.0  # [s] that the disk may take until a stop is acknowledged without it
STOP_PERIOD = 0.1  # [s] between two stops that reach the mission: a flood of them is one
SENDERS = 64  # that have an allowance of their own
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


class CommandServer:
    """Answers the commands that are meant for our component.

    Parameters
    ----------
    endpoint
        Who we are.
    give
        Hands an order to the runner; a stop takes effect before it returns.
    record
        Starts or stops the recording; returns why not, or nothing.
    say
        Tells an operator something.
    requests
        Obeys the commands that ask for messages.
    latch
        Tells when a stop is on the disk: it is acknowledged then. None: at once.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        give: Callable[[Order], None],
        record: Callable[[bool], str],
        say: Callable[[Severity, str], None],
        requests: Requests,
        *,
        latch: StopMemory | None = None,
    ) -> None:
        self._endpoint = endpoint
        self._give = give
        self._record = record
        self._say = say
        self._requests = requests
        self._posture = Posture()
        self._places = Places()
        self._ledger = Ledger()
        self._open: dict[int, Entry] = {}  # what the mission has, by the number of the order
        self._numbers = count(1)
        self._now = 0.0
        self._next_stop = -math.inf  # [s]
        self._latch = latch
        self._unsaved: dict[Sender, Entry] = {}  # stops that are obeyed and not yet on the disk
        self._overdue = math.inf  # when their senders hear so [s]
        self._allowances: OrderedDict[Sender, Allowance] = OrderedDict()
        self._texts = Allowance(burst=4, rate=0.5)

    def heard(self, heard: Heard) -> None:
        """Take a packet; what is no command, or not for us, passes by."""
        packet = heard.packet
        origin = self._places.note((packet.system_id, packet.component_id), heard.link, packet.sequence, self._now)
        request = command_of(packet.message)
        if request is None or not self._endpoint.meant(request.system_id, request.component_id):
            return
        if isinstance(request, CancelRequest):
            if heard.may_order:
                self._cancel(request, origin.sender)
            elif heard.refusal and self._texts.take(self._now):
                self._say(Severity.WARNING, f"cancel refused: {heard.refusal}")
        elif heard.may_order and request.number == STOP:
            self._stop(request, origin)
        elif not self._allowed(origin.sender):
            return
        elif heard.may_order and request.number in READERS:
            self._command(request, origin)
        else:
            verdict = self._other(request, heard)
            if verdict is ACCEPTED or not request.to_all:  # nobody asked us in particular
                self._answer(request, origin, verdict)

    def said(self, event: Event) -> None:
        """Take what the mission says; answers to orders go on to whoever commanded them."""
        self._posture.said(event)
        entry = self._open.get(event.order) if isinstance(event, Answered) else None
        if not isinstance(event, Answered) or entry is None:
            return
        if event.answer is Answer.PROGRESS:
            entry.progress = event.progress
            self._tell(entry)
        elif event.answer is Answer.ACCEPTED and isinstance(entry.order, Task):
            self._tell(entry)
        else:
            self._close(entry, event)

    def tick(self, now: float) -> None:
        """Tell those who wait that their command is in progress."""
        self._now = now
        for entry in self._open.values():
            if now >= entry.due:
                self._tell(entry)
        if self._latch is not None and self._unsaved:
            self._tell_of_stops(self._latch, now)

    def _other(self, command: Command, heard: Heard) -> Verdict:
        """Obey a command that is not of our dialect, or refuse one."""
        if not heard.may_order:
            return Verdict(Result.DENIED, heard.refusal)
        if command.number == REBOOT:
            return Verdict(Result.DENIED, "the payload does not restart by command")
        return self._requests.obey(command, heard.link, self._now) or Verdict(Result.UNSUPPORTED)

    def _stop(self, command: Command, origin: Origin) -> None:
        """Stop, whatever was said before, and however often."""
        entry = Entry(command, origin, self._now, Result.ACCEPTED)
        self._ledger.note(entry)
        if self._now >= self._next_stop:
            self._order(Stop())
            self._next_stop = self._now + STOP_PERIOD
        if not self._allowed(origin.sender):
            return
        if self._latch is None:
            self._send(entry)
            return
        if not self._unsaved:
            self._overdue = self._now + STOP_SAVING
        first = self._unsaved.get(origin.sender)
        entry.due = self._now + PATIENCE if first is None else first.due
        if first is not None or len(self._unsaved) < SENDERS:
            self._unsaved[origin.sender] = entry

    def _tell_of_stops(self, latch: StopMemory, now: float) -> None:
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
        trouble = latch.failure if latch.saved else "the disk does not respond"
        if trouble:
            self._say(Severity.CRITICAL, f"stopped, but a restart clears it: {trouble}")

    def _command(self, command: Command, origin: Origin) -> None:
        """Obey or refuse a command of our dialect, unless it is only said again."""
        known = self._ledger.repeated(command, origin, self._now)
        if known is not None:
            self._send(known)
            return
        if self._ledger.before(command, origin, self._now):
            return  # its sender has asked for something else since
        entry = Entry(command, origin, self._now)
        verdict = self._obey(entry)
        before = self._ledger.find(origin.sender, command.number)
        if verdict is None or before is None or before.order is None:
            self._ledger.note(entry)
        if verdict is not None:
            entry.result = verdict.result
            self._answer(command, origin, verdict)
        elif before is not None and before.order is not None:
            self._open.pop(before.order.number, None)  # its end would look like the end of the new one

    def _obey(self, entry: Entry) -> Verdict | None:
        """Return what becomes of a command; None: the mission has it."""
        command = entry.command
        if command.number == INFORM and not command.long:
            return Verdict(Result.COMMAND_LONG_ONLY)
        try:
            wanted = asked(command)
        except ConfigError as error:
            return Verdict(Result.DENIED, str(error))
        if isinstance(wanted, Record):
            reason = self._record(wanted.on)
            return Verdict(Result.FAILED, reason) if reason else ACCEPTED
        if self._ledger.not_after(STOP, entry.origin, self._now):
            return Verdict(Result.TEMPORARILY_REJECTED, "sent before the stop")
        return self._posture.refusal(wanted) or self._hand_over(entry, wanted)

    def _hand_over(self, entry: Entry, wanted: Order) -> Verdict | None:
        order = self._order(wanted)
        if isinstance(order, Cancel):
            return ACCEPTED
        entry.order, entry.due = order, self._now + PATIENCE
        self._open[order.number] = entry
        return None

    def _order(self, wanted: Order) -> Order:
        """Give an order a number and give it to the mission."""
        order = replace(wanted, number=next(self._numbers))
        self._next_stop = -math.inf
        self._posture.given(order)
        self._give(order)
        return order

    def _cancel(self, request: CancelRequest, sender: Sender) -> None:
        """End a task in progress, whoever commanded it; one that is over is answered again."""
        going_on = [e for e in self._open.values() if e.command.number == request.number and isinstance(e.order, Task)]
        for entry in going_on:
            if not entry.cancelled:
                entry.cancelled = True
                self._order(Cancel())
        known = self._ledger.find(sender, request.number)
        if not going_on and known is not None and self._allowed(sender):
            self._send(known)

    def _close(self, entry: Entry, event: Answered) -> None:
        """Tell the sender how its command ended."""
        del self._open[event.order]
        entry.order, entry.result, entry.time = None, FINAL[event.answer], self._now
        entry.lost = self._places.lost(entry.origin)
        self._send(entry)
        if event.answer is Answer.REFUSED:
            self._explain(entry.command, event.reason)

    def _tell(self, entry: Entry) -> None:
        entry.due = self._now + PROGRESS_PERIOD
        self._send(entry)

    def _answer(self, command: Command, origin: Origin, verdict: Verdict) -> None:
        self._send(Entry(command, origin, self._now, verdict.result))
        if verdict.reason:
            self._explain(command, verdict.reason)

    def _explain(self, command: Command, reason: str) -> None:
        if self._texts.take(self._now):
            self._say(Severity.WARNING, f"{name_of(command)} refused: {reason}")

    def _allowed(self, sender: Sender) -> bool:
        """Tell whether a sender may be answered once more; it may not ask too often."""
        allowance = self._allowances.setdefault(sender, Allowance(BURST, RATE))
        self._allowances.move_to_end(sender)
        if len(self._allowances) > SENDERS:
            self._allowances.popitem(last=False)
        return allowance.take(self._now)

    def _send(self, entry: Entry) -> None:
        self._endpoint.send(acknowledgement(entry.command.number, entry.result, *entry.origin.sender, entry.progress))
