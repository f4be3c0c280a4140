"""The payload as the master of one CANopen drive, and what it hears on the bus of the drive and of others."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

from ross_payload.actuators.canopen_drive import drive_setup
from ross_payload.actuators.canopen_drive.options import Options
from ross_payload.actuators.driver_shell import HELD_UP_S, MAX_CATCH_UP_S, TIME_TOLERANCE_S
from ross_payload.interfaces import Port
from ross_protocols.can import CanFrame
from ross_protocols.canopen import cia402, frames
from ross_protocols.canopen.sdo import Abort, Read, Value, Write, Written, reply_of, request, request_of

SILENCE_TIMEOUT_S = 0.35  # without any word of the drive [s]
BOOT_UP_WINDOW_S = 0.06  # so long it takes to tell one drive that restarts from two drives [s]
FULL_BUS_FRAMES_S = 2000  # frames of others in a second
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class DriveReport:
    """Process data of the drive."""

    status: int = 0
    position: int = 0  # [counts]
    mode: int = 0
    time: float = -math.inf  # when it was read [s]
    since: float = -math.inf  # it was sent later [s]


class DriveClient:
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
        self._next_heartbeat = now
        self._crowd = 0  # frames of others since the drive was heard
        self._owed = 0  # answers that are due to us or to somebody else's reads
        self._answered: bytes | None = b""  # the last answer; None: one has come twice
        self._booted: float | None = None
        self._started = math.inf  # [s]
        port.receive()  # what was said before we came is not for us
        self._read_at = now  # the bus [s]
        self._paused_at = self._resumed_at = self._caught_up_at = -math.inf  # of the last pause of this program [s]
        self.heard_at = -math.inf  # any word of the drive [s]
        self.running = False  # the drive is set up and has been started
        self.report = DriveReport()
        self.velocity = 0  # [counts/s]
        self.emergency: frames.Emergency | None = None
        self.answers: list[Value | Written | Abort] = []
        self.event = ""  # what went wrong and does not mend itself; whoever reads it clears it
        self.restarted = False  # it must be set up again

    @property
    def fresh(self) -> bool:
        """Whether the drive has reported since it was started."""
        return self.running and self.report.time >= self._started

    def read(self, now: float) -> None:
        """Read the bus."""
        self._look_for_pause(now)
        for frame in self._port.receive():
            if not frame.extended:
                self._on_frame(frame, now)
        self._read_at = now
        if self._booted is not None and now >= self._booted + BOOT_UP_WINDOW_S - TIME_TOLERANCE_S:
            self._booted, self.running, self._started = None, False, math.inf
            self._set_event(f"the drive at node {self._node} has restarted")
        if self.running and self.is_silent(now):
            self._set_event(f"node {self._node} has sent nothing for {now - self.heard_at:.2f} s{self._crowded(now)}")

    def is_silent(self, now: float) -> bool:
        """Whether nothing was heard of the drive for long."""
        return now > max(self.heard_at, self._resumed_at) + SILENCE_TIMEOUT_S

    @property
    def awaits_answer(self) -> bool:
        """Whether the drive still owes an answer."""
        return self._owed > 0

    def send_heartbeat(self, now: float) -> None:
        """Tell the drive that we live; when that ends it stops by itself."""
        if now >= self._next_heartbeat - TIME_TOLERANCE_S:
            self._next_heartbeat = now + drive_setup.HEARTBEAT_MS * 1e-3
            self._port.send(frames.heartbeat(self._own, frames.NmtState.OPERATIONAL))

    def send_sdo(self, wanted: Read | Write) -> None:
        """Read or write an entry of the drive's dictionary."""
        self._owed += 1
        self._port.send(request(self._node, wanted))

    def enter_pre_operational(self) -> None:
        """Let the drive talk and be set up, but send and obey no process data."""
        self.running, self.restarted, self._started = False, False, math.inf
        self._answered = b""
        self._port.send(frames.nmt(frames.NmtCommand.PRE_OPERATIONAL, self._node))

    def start(self, now: float) -> None:
        """Let the drive send and obey process data; from here on it is missed when it is silent."""
        self.running, self.heard_at, self._booted, self._started = True, now, None, now
        self._port.send(frames.nmt(frames.NmtCommand.START, self._node))

    def send_order(self, word: int, target: int, mode: int) -> None:
        """Send controlword, target and mode."""
        self._send(frames.RPDO[1], frames.packed(drive_setup.RPDO2_ITEMS, (word, target, mode)))

    def send_speed_limit(self, speed: int) -> None:
        """Send the speed of the next set-point [counts/s]."""
        self._send(frames.RPDO[0], frames.packed(drive_setup.RPDO1_ITEMS, (speed,)))

    def stop_heartbeat_watch(self) -> None:
        """Let the drive hear from us no more, and not mind."""
        beat = cia402.CONSUMER_HEARTBEAT
        self.enter_pre_operational()
        self.send_sdo(Write(beat.index, beat.sub, beat.pack(0)))

    def close(self) -> None:
        """Leave the bus."""
        self._port.close()

    # ------------------------------------------------------------------------------------------ what is heard

    def _send(self, base: int, data: bytes) -> None:
        self._port.send(CanFrame(base + self._node, data, extended=False))

    def _look_for_pause(self, now: float) -> None:
        """Take in that nobody has read for a while: in a pause of the whole computer nothing arrived either.

        What was to be sent meanwhile may come now, and a drive in another process of it makes up for the time. Only
        the first pause since the drive was heard excuses its silence: who reads seldom is not held up.
        """
        pause = now - self._read_at
        if pause > HELD_UP_S:
            self._paused_at, self._caught_up_at = self._read_at, now + min(pause, MAX_CATCH_UP_S)
            self._resumed_at = now if self.heard_at >= self._resumed_at else self._resumed_at

    def _sent_since(self, now: float) -> float:
        """Return after when what is read now was sent [s]."""
        return self._paused_at if now <= self._caught_up_at else self._read_at

    def _set_event(self, event: str) -> None:
        self.event = self.event or event

    def _crowded(self, now: float) -> str:
        rate = self._crowd / max(now - self.heard_at, SILENCE_TIMEOUT_S)
        return f"; the bus is full: {rate:.0f} frames/s of others" if rate > FULL_BUS_FRAMES_S else ""

    def _on_frame(self, frame: CanFrame, now: float) -> None:
        kind, node = frame.id & 0x780, frame.id & 0x7F
        if frame.id == frames.NMT:
            if len(frame.data) == 2 and frame.data[1] in (0, self._node):
                whom = f"node {self._node}" if frame.data[1] else "all nodes"
                self._set_event(f"another master on the bus orders {whom}: {frames.NmtCommand.says(frame.data[0])}")
        elif frame.id == frames.HEARTBEAT + self._own:
            self._set_event(f"another node on the bus has our node id {self._own}")
        elif node != self._node:
            self._crowd += 1
        elif kind in (*frames.RPDO, frames.SDO_REQUEST):
            self._on_master_frame(kind, frame.data)
        else:
            self.heard_at, self._crowd = now, 0
            self._on_drive_frame(kind, frame.data, now)

    def _on_master_frame(self, kind: int, data: bytes) -> None:
        asked = request_of(data) if kind == frames.SDO_REQUEST else None
        if isinstance(asked, Read):
            self._owed += 1
        elif kind != frames.SDO_REQUEST or isinstance(asked, Write):
            self._set_event(f"another master on the bus commands node {self._node}")

    def _on_drive_frame(self, kind: int, data: bytes, now: float) -> None:
        if kind == frames.TPDO[0]:
            self._on_position(data, now)
        elif kind == frames.TPDO[1]:
            self._on_velocity(data)
        elif kind == frames.SDO_REPLY:
            self._on_sdo_answer(data)
        elif kind == frames.HEARTBEAT:
            self._on_nmt_state(data, now)
        elif kind == frames.EMERGENCY:
            self._on_emergency(data)

    def _on_position(self, data: bytes, now: float) -> None:
        values = frames.unpacked(drive_setup.TPDO1_ITEMS, data)
        if values is None:
            self._damaged(f"a report of {len(data)} bytes")
        elif self._booted is not None:
            self._booted = None
            self._set_event(f"two devices have node id {self._node}: one has just booted, the other kept running")
        else:
            status, position, mode = values
            self.report = DriveReport(status, position, mode, now, self._sent_since(now))

    def _on_velocity(self, data: bytes) -> None:
        values = frames.unpacked(drive_setup.TPDO2_ITEMS, data)
        if values is None:
            self._damaged(f"a report of {len(data)} bytes")
        else:
            self.velocity = values[0]

    def _on_sdo_answer(self, data: bytes) -> None:
        answer = reply_of(data)
        if self._owed == 0 and data == self._answered:
            self._answered = None  # CAN may deliver a frame twice, but not every one
        elif self._owed == 0:
            self._set_event(f"two devices have node id {self._node}: both answer")
        elif answer is None:
            self._damaged(f"an invalid SDO response: {data.hex()}")
        else:
            self._owed -= 1
            self._answered = data if self._answered is not None else None
            self.answers.append(answer)

    def _on_nmt_state(self, data: bytes, now: float) -> None:
        state = frames.state_of(data)
        if state is None:
            self._damaged(f"an invalid heartbeat: {data.hex()}")
        elif state is frames.NmtState.BOOT_UP:
            self.restarted, self._booted = True, now if self.running else None
        elif (
            self._booted is None
            and self._sent_since(now) > self._started + SILENCE_TIMEOUT_S
            and state is not frames.NmtState.OPERATIONAL
        ):
            self.restarted = True
            self._set_event(f"the drive at node {self._node} is {state.words} and accepts no set-points")

    def _on_emergency(self, data: bytes) -> None:
        emergency = frames.emergency_of(data)
        if emergency is None:
            self._damaged(f"an emergency of {len(data)} bytes")
        else:
            log.warning("drive at node %d: %s", self._node, emergency)
            self.emergency = emergency if emergency.code else None

    def _damaged(self, what: str) -> None:
        self._set_event(f"frames of node {self._node} arrive damaged: {what}")
