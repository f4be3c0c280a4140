"""The firmware of the simulated CANopen drive that talks: network management, SDO, process data, heartbeats."""

from __future__ import annotations

from collections.abc import Callable

from ross_protocols.can import CanFrame
from ross_protocols.canopen import cia402, frames
from ross_protocols.canopen.sdo import UNKNOWN_COMMAND, Abort, Read, Write, reply, request_of
from ross_sim.devices.bus_nodes import EARLY
from ross_sim.devices.drive_axis import Axis
from ross_sim.devices.drive_objects import Objects
from ross_sim.devices.drive_servo import STEP

PDOS = (0, 1)  # numbers of process data, either way
STATES = {
    frames.NmtCommand.START: frames.NmtState.OPERATIONAL,
    frames.NmtCommand.STOP: frames.NmtState.STOPPED,
    frames.NmtCommand.PRE_OPERATIONAL: frames.NmtState.PRE_OPERATIONAL,
}


class DriveNode:
    """One drive on a bus.

    Parameters
    ----------
    node : int
        Its number.
    objects : Objects
        Its dictionary.
    power_up : Callable[[Objects], Axis]
        Makes the firmware of the axis when the drive is switched on.
    """

    def __init__(self, node: int, objects: Objects, power_up: Callable[[Objects], Axis], now: float = 0.0) -> None:
        self.node, self.objects = node, objects
        self._power_up = power_up
        self._now = now
        self.objects.written = self._written
        self.boot()

    def boot(self) -> None:
        """Start the firmware: no torque, everything as in the data sheet, and a word to the others."""
        self.objects.reset()
        self.axis = self._power_up(self.objects)
        self.axis.step(self._now)
        self.nmt = frames.NmtState.PRE_OPERATIONAL
        self._outgoing = [frames.heartbeat(self.node, frames.NmtState.BOOT_UP)]
        self._next_beat = self._now
        self._next_report = [self._now for _ in PDOS]
        self._syncs = [0 for _ in PDOS]
        self._sent_status = -1  # the statusword that the others know
        self._master_until: float | None = None  # when the master's heartbeat is missed [s]

    def on_frame(self, frame: CanFrame) -> None:
        """Obey a frame."""
        if frame.extended:
            return
        if frame.id == frames.NMT and len(frame.data) == 2 and frame.data[1] in (0, self.node):
            self._manage(frame.data[0])
        elif frame.id == frames.SDO_REQUEST + self.node and self.nmt is not frames.NmtState.STOPPED:
            self._serve(frame.data)
        elif frame.id == frames.SYNC and self.nmt is frames.NmtState.OPERATIONAL:
            self._synchronise()
        elif frame.id > frames.HEARTBEAT:
            self._on_heartbeat(frame.id - frames.HEARTBEAT, frame.data)
        elif self.nmt is frames.NmtState.OPERATIONAL:
            for number in PDOS:
                if frame.id == self.objects.at(0x1400 + number, 1) & (frames.NOT_VALID | 0x7FF):
                    self._take_process_data(number, frame.data)

    def live(self, until: float) -> list[CanFrame]:
        """Live until ``until`` [s]; return what is said then."""
        for _ in range(round((until - self._now) / STEP)):
            self._now += STEP
            self.axis.step(self._now)
        self._now = until
        if not self.objects[cia402.CONSUMER_HEARTBEAT] & 0xFFFF:
            self._master_until = None
        if self._master_until is not None and until > self._master_until:
            self._master_until = None
            self.axis.lose_master()
        while self.axis.emergencies:
            self._say_emergency(self.axis.emergencies.pop(0))
        self.objects[cia402.STATUSWORD] = self.axis.status
        self._report(until)
        self._beat(until)
        said, self._outgoing = self._outgoing, []
        return said

    # ------------------------------------------------------------------------------------------ network

    def _manage(self, command: int) -> None:
        if command in (frames.NmtCommand.RESET_NODE, frames.NmtCommand.RESET_COMMUNICATION):
            self.boot()
        elif command in STATES:
            self.nmt = STATES[frames.NmtCommand(command)]
            self._sent_status = -1

    def _on_heartbeat(self, node: int, data: bytes) -> None:
        """Expect the master's next heartbeat; from the first one on it is missed."""
        whom = self.objects[cia402.CONSUMER_HEARTBEAT]
        if whom >> 16 == node and whom & 0xFFFF and frames.state_of(data) is not None:
            self._master_until = self._now + (whom & 0xFFFF) * 1e-3

    def _beat(self, now: float) -> None:
        period = self.objects[cia402.PRODUCER_HEARTBEAT] * 1e-3
        if period and now >= self._next_beat - EARLY:
            self._next_beat = now + period
            self._outgoing.append(frames.heartbeat(self.node, self.nmt))

    def _say_emergency(self, emergency: frames.Emergency) -> None:
        self.objects.write(0x603F, 0, emergency.code)
        self.objects.write(0x1001, 0, emergency.register)
        if self.nmt is not frames.NmtState.STOPPED:
            self._outgoing.append(emergency.frame(self.node))

    # ------------------------------------------------------------------------------------------ dictionary

    def _serve(self, data: bytes) -> None:
        asked = request_of(data)
        if isinstance(asked, Read | Write):
            self.objects[cia402.STATUSWORD] = self.axis.status
            self._outgoing.append(reply(self.node, self.objects.answer(asked)))
        elif asked is None and len(data) == 8:
            index, sub = int.from_bytes(data[1:3], "little"), data[3]
            self._outgoing.append(reply(self.node, Abort(index, sub, UNKNOWN_COMMAND)))

    def _written(self, index: int, sub: int) -> None:
        if index == cia402.CONTROLWORD.index:
            self.axis.obey(self.objects[cia402.CONTROLWORD])
        elif index == cia402.MODE.index:
            self.axis.choose(self.objects[cia402.MODE])

    # ------------------------------------------------------------------------------------------ process data

    def _mapping(self, parameter: int) -> list[tuple[int, int, int]]:
        return [frames.mapped(self.objects.at(parameter, sub)) for sub in range(1, self.objects.at(parameter, 0) + 1)]

    def _take_process_data(self, number: int, data: bytes) -> None:
        """Write what is mapped; the controlword comes last, so that it finds its target."""
        mapping = self._mapping(0x1600 + number)
        if len(data) < sum(size for *_, size in mapping):
            self._say_emergency(frames.Emergency(0x8210, 0x11))
            return
        values = []
        for index, sub, size in mapping:
            values.append((index, sub, self.objects.item(index, sub).unpack(data[:size])))
            data = data[size:]
        for index, sub, value in sorted(values, key=lambda each: each[0] == cia402.CONTROLWORD.index):
            self.objects.write(index, sub, value)

    def _report(self, now: float) -> None:
        """Send the process data whose time has come, or whose statusword is news."""
        if self.nmt is not frames.NmtState.OPERATIONAL:
            return
        status = self.objects[cia402.STATUSWORD]
        for number in PDOS:
            parameter = 0x1800 + number
            on_event, timer = self.objects.at(parameter, 2) >= 254, self.objects.at(parameter, 5) * 1e-3
            news = status != self._sent_status and (cia402.STATUSWORD.index, 0, 2) in self._mapping(0x1A00 + number)
            if on_event and (news or (timer and now >= self._next_report[number] - EARLY)):
                self._next_report[number] = now + timer
                self._send(number)
        self._sent_status = status

    def _synchronise(self) -> None:
        self.objects[cia402.STATUSWORD] = self.axis.status
        for number in PDOS:
            kind = self.objects.at(0x1800 + number, 2)
            self._syncs[number] += 1
            if 1 <= kind <= 240 and self._syncs[number] >= kind:
                self._syncs[number] = 0
                self._send(number)

    def _send(self, number: int) -> None:
        cob = self.objects.at(0x1800 + number, 1)
        if not cob & frames.NOT_VALID:
            data = b"".join(self.objects.data(index, sub) for index, sub, _ in self._mapping(0x1A00 + number))
            self._outgoing.append(CanFrame(cob & 0x7FF, data, extended=False))
