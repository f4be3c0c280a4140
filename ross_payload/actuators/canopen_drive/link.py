"""The payload as the master of one CANopen drive, and what it hears on the bus of the drive and of others."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.actuators.canopen_drive.setup import BEAT, COMMAND, PLACE, RATE, SPEED
from ross_payload.interfaces import Port
from ross_protocols import cia402
from ross_protocols.can import CanFrame
from ross_protocols.canopen import (
    EMERGENCY,
    HEARTBEAT,
    NMT,
    RPDO,
    SDO_REPLY,
    SDO_REQUEST,
    TPDO,
    Emergency,
    NmtCommand,
    NmtState,
    emergency_of,
    heartbeat,
    nmt,
    packed,
    state_of,
    unpacked,
)
from ross_protocols.canopen_sdo import Abort, Read, Value, Write, Written, reply_of, request, request_of

SILENCE = 0.35  # without any word of the drive [s]
AFTER_BOOT = 0.06  # so long it takes to tell one drive that restarts from two drives [s]
CROWDED = 2000  # frames of others in a second
EARLY = 1e-6  # so much before its time something is due [s]
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Report:
    """Process data of the drive."""

    status: int = 0
    position: int = 0  # [counts]
    mode: int = 0
    time: float = -math.inf  # when it came [s]


class Link:
    """Sends orders and heartbeats; keeps what the drive says and what is wrong on the bus.

    Parameters
    ----------
    options : Options
        Whose drive it is, and who we are.
    port : Port
        The bus.
    now : float
        When it begins [s].
    """

    def __init__(self, options: Options, port: Port, now: float) -> None:
        self._node, self._own = options.node_id, options.own_node_id
        self._port = port
        self._next_beat = now
        self._crowd = 0  # frames of others since the drive was heard
        self._owed = 0  # answers that are due to us or to somebody else's reads
        self._booted: float | None = None
        self._started = math.inf  # [s]
        port.receive()  # what was said before we came is not for us
        self.heard = -math.inf  # any word of the drive [s]
        self.running = False  # the drive is set up and has been started
        self.report = Report()
        self.velocity = 0  # [counts/s]
        self.emergency: Emergency | None = None
        self.answers: list[Value | Written | Abort] = []
        self.event = ""  # what went wrong and does not mend itself; whoever reads it clears it
        self.restarted = False  # it must be set up anew

    @property
    def fresh(self) -> bool:
        """Whether the drive has reported since it was started."""
        return self.running and self.report.time >= self._started

    def take_in(self, now: float) -> None:
        """Read the bus."""
        for frame in self._port.receive():
            if not frame.extended:
                self._take(frame, now)
        if self._booted is not None and now >= self._booted + AFTER_BOOT - EARLY:
            self._booted, self.running, self._started = None, False, math.inf
            self._note(f"the drive at node {self._node} has restarted")
        if self.running and now > self.heard + SILENCE:
            self._note(f"node {self._node} has sent nothing for {now - self.heard:.2f} s{self._crowded(now)}")

    @property
    def awaits(self) -> bool:
        """Whether the drive still owes an answer."""
        return self._owed > 0

    def beat(self, now: float) -> None:
        """Tell the drive that we live; when that ends it stops by itself."""
        if now >= self._next_beat - EARLY:
            self._next_beat = now + BEAT * 1e-3
            self._port.send(heartbeat(self._own, NmtState.OPERATIONAL))

    def ask(self, wanted: Read | Write) -> None:
        """Read or write an entry of the drive's dictionary."""
        self._owed += 1
        self._port.send(request(self._node, wanted))

    def hold(self) -> None:
        """Let the drive talk and be set up, but send and obey no process data."""
        self.running, self.restarted, self._started = False, False, math.inf
        self._port.send(nmt(NmtCommand.PRE_OPERATIONAL, self._node))

    def start(self, now: float) -> None:
        """Let the drive send and obey process data; from here on it is missed when it is silent."""
        self.running, self.heard, self._booted, self._started = True, now, None, now
        self._port.send(nmt(NmtCommand.START, self._node))

    def steer(self, word: int, target: int, mode: int) -> None:
        """Send controlword, target and mode."""
        self._send(RPDO[0], packed(COMMAND, (word, target, mode)))

    def limit(self, speed: int) -> None:
        """Send the speed of the next set-point [counts/s]."""
        self._send(RPDO[1], packed(RATE, (speed,)))

    def part(self) -> None:
        """Let the drive hear from us no more, and not mind."""
        beat = cia402.CONSUMER_HEARTBEAT
        self.hold()
        self.ask(Write(beat.index, beat.sub, beat.pack(0)))

    def close(self) -> None:
        """Leave the bus."""
        self._port.close()

    # ------------------------------------------------------------------------------------------ what is heard

    def _send(self, base: int, data: bytes) -> None:
        self._port.send(CanFrame(base + self._node, data, extended=False))

    def _note(self, event: str) -> None:
        self.event = self.event or event

    def _crowded(self, now: float) -> str:
        rate = self._crowd / max(now - self.heard, SILENCE)
        return f"; the bus is full: {rate:.0f} frames/s of others" if rate > CROWDED else ""

    def _take(self, frame: CanFrame, now: float) -> None:
        kind, node = frame.id & 0x780, frame.id & 0x7F
        if frame.id == NMT:
            if len(frame.data) == 2 and frame.data[1] in (0, self._node):
                whom = f"node {self._node}" if frame.data[1] else "all nodes"
                self._note(f"another master on the bus orders {whom}: {NmtCommand.says(frame.data[0])}")
        elif frame.id == HEARTBEAT + self._own:
            self._note(f"another node on the bus has our node id {self._own}")
        elif node != self._node:
            self._crowd += 1
        elif kind in (*RPDO, SDO_REQUEST):
            self._take_of_master(kind, frame.data)
        else:
            self.heard, self._crowd = now, 0
            self._take_of_drive(kind, frame.data, now)

    def _take_of_master(self, kind: int, data: bytes) -> None:
        asked = request_of(data) if kind == SDO_REQUEST else None
        if isinstance(asked, Read):
            self._owed += 1
        elif kind != SDO_REQUEST or isinstance(asked, Write):
            self._note(f"another master on the bus commands node {self._node}")

    def _take_of_drive(self, kind: int, data: bytes, now: float) -> None:
        if kind == TPDO[0]:
            self._take_place(data, now)
        elif kind == TPDO[1]:
            self._take_speed(data)
        elif kind == SDO_REPLY:
            self._take_answer(data)
        elif kind == HEARTBEAT:
            self._take_state(data, now)
        elif kind == EMERGENCY:
            self._take_emergency(data)

    def _take_place(self, data: bytes, now: float) -> None:
        values = unpacked(PLACE, data)
        if values is None:
            self._damaged(f"a report of {len(data)} bytes")
        elif self._booted is not None:
            self._booted = None
            self._note(f"two devices have node id {self._node}: one has just booted, the other kept running")
        else:
            status, position, mode = values
            self.report = Report(status, position, mode, now)

    def _take_speed(self, data: bytes) -> None:
        values = unpacked(SPEED, data)
        if values is None:
            self._damaged(f"a report of {len(data)} bytes")
        else:
            self.velocity = values[0]

    def _take_answer(self, data: bytes) -> None:
        answer = reply_of(data)
        if self._owed == 0:
            self._note(f"two devices have node id {self._node}: both answer")
        elif answer is None:
            self._damaged(f"an invalid SDO response: {data.hex()}")
        else:
            self._owed -= 1
            self.answers.append(answer)

    def _take_state(self, data: bytes, now: float) -> None:
        state = state_of(data)
        if state is None:
            self._damaged(f"an invalid heartbeat: {data.hex()}")
        elif state is NmtState.BOOT_UP:
            self.restarted, self._booted = True, now if self.running else None
        elif self._booted is None and now > self._started + SILENCE and state is not NmtState.OPERATIONAL:
            self.restarted = True
            self._note(f"the drive at node {self._node} is {state.words} and accepts no set-points")

    def _take_emergency(self, data: bytes) -> None:
        emergency = emergency_of(data)
        if emergency is None:
            self._damaged(f"an emergency of {len(data)} bytes")
        else:
            log.warning("drive at node %d: %s", self._node, emergency)
            self.emergency = emergency if emergency.code else None

    def _damaged(self, what: str) -> None:
        self._note(f"frames of node {self._node} arrive damaged: {what}")
