"""A microcontroller with stock grbl 1.1: bytes in, bytes out, counters of steps.

Written after grbl's own documentation and behaviour, not from its code: real-time bytes act when they arrive, lines
wait in a receive buffer of 128 bytes, every line is answered once it is taken, a jog that is cancelled slows down and
takes the jogs behind it along, a reset in mid-move loses the position, and homing answers nobody.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator

from ross_protocols.grbl.protocol import HOMING, IDLE_DELAY, SOFT_LIMITS, State
from ross_sim.devices.grbl_gcode import GcodeError, GcodeLine, Modes, understood
from ross_sim.devices.grbl_planner import Motion
from ross_sim.devices.grbl_settings import DEVIATION, Settings, homing

RECEIVE_BUFFER = 128  # [bytes]
LONGEST = 80  # line [bytes]
BANNER = "\r\nGrbl 1.1h ['$' for help]"
BUILD = ("[VER:1.1h.20190825:]", "[OPT:V,15,128]")
HELP = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]"
OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G28", "G30", "G92")
LOCKED = "[MSG:'$H'|'$X' to unlock]"
MOVES = (State.JOG, State.RUN, State.HOLD, State.HOME)


class Firmware:
    """The controller.

    Parameters
    ----------
    settings
        As ``$$`` tells them, on top of the defaults.
    axes
        Letters of the axes it has.
    turning
        The axis whose switch homes it.
    switch
        Whether that axis stands at its limit switch.
    """

    def __init__(self, settings: dict[int, float], axes: str, turning: str, switch: Callable[[], bool]) -> None:
        self.settings = Settings(settings, len(axes))
        self.out = bytearray()
        self._axes = axes
        self._turning = axes.index(turning)
        self._switch = switch
        self.motion = Motion(self.settings.axes, self.settings[DEVIATION])
        self._asked = self._cancelling = False
        self._begin(self._locked)

    def boot(self) -> None:
        """Restart, as after power-up or a pulse on DTR: a motor that moves is stopped dead, the counters are 0."""
        self.motion = Motion(self.settings.axes, self.settings[DEVIATION])
        self._begin(self._locked)

    @property
    def _locked(self) -> State:
        return State.ALARM if self.settings[HOMING] else State.IDLE

    @property
    def energised(self) -> bool:
        """Whether the motors have current."""
        return self.state is not State.SLEEP and (self.settings[IDLE_DELAY] == 255 or self.busy)

    @property
    def busy(self) -> bool:
        """Whether it needs to be ticked for anything to happen."""
        return self.state in MOVES or self.motion.moving or bool(self._received) or self._asked

    @property
    def count(self) -> int:
        """The step counter of the axis that turns."""
        return self.motion.position[self._turning]

    @property
    def forward(self) -> bool:
        """Whether the axis that turns is not to go back."""
        return self.motion.planned[self._turning] >= self.count

    def on_bytes(self, data: bytes) -> None:
        """Take in bytes from the line; what does not fit into the buffer is lost."""
        for byte in data:
            if byte in b"?!~\x18" or byte >= 0x80:
                self._at_once(byte)
            elif len(self._received) < RECEIVE_BUFFER:
                self._received.append(byte)

    def tick(self) -> tuple[float, float]:
        """Live for one piece; return where the axis that turns was before and is after it [steps]."""
        if self._asked and self._homing is None:
            self._asked = False
            self._send(self._report())
        if self._homing is not None:
            self._home(self._homing)
        else:
            self._read()
        before, after = self.motion.piece()
        if self.state in (State.JOG, State.RUN, State.HOLD) and not self.motion.moving:
            self._come_to_rest()
        return before[self._turning], after[self._turning]

    def obey(self, line: str) -> None:
        """Take a line from somebody else, who gets the answer."""
        said = bytes(self.out)
        self._execute(line)
        self.out[:] = said

    # ------------------------------------------------------------------------------------------ states

    def _begin(self, state: State) -> None:
        self.state = state
        self._modes = Modes()
        self._received: deque[int] = deque()
        self._line = bytearray()
        self._asked = self._cancelling = False
        self._homing: Generator[None, None, int] | None = None
        self._reports = 0  # reports, which tell more now and then
        self._send(BANNER)
        if state is State.ALARM:
            self._send(LOCKED)

    def _at_once(self, byte: int) -> None:
        if byte == 0x18:
            self._reset()
        elif byte == ord("?"):
            self._asked = True
        elif byte == 0x85 and self.state is State.JOG:
            self._cancelling = True
            self.motion.hold()
        elif byte == ord("!") and self.state in (State.JOG, State.RUN):
            self._cancelling = self.state is State.JOG
            self.motion.hold()
            self.state = State.JOG if self._cancelling else State.HOLD
        elif byte == ord("~") and self.state is State.HOLD and not self.motion.moving:
            self.motion.resume()
            self.state = State.RUN

    def _reset(self) -> None:
        if self.state in MOVES and (self.state is State.HOME or self.motion.moving):
            self._alarm(6 if self.state is State.HOME else 3)
        locked = self.state in (State.ALARM, State.SLEEP)
        self.motion.clear()
        self._begin(State.ALARM if locked else State.IDLE)

    def _alarm(self, number: int) -> None:
        self.motion.clear()
        self.state, self._homing = State.ALARM, None
        self._send(f"ALARM:{number}")

    def _home(self, cycle: Generator[None, None, int]) -> None:
        try:
            next(cycle)
        except StopIteration as over:
            if over.value:
                self._alarm(over.value)
                self._begin(State.ALARM)
            else:
                self.state, self._homing = State.IDLE, None
                self._send("ok")

    def _come_to_rest(self) -> None:
        if self.state is State.HOLD:
            return
        if self._cancelling:
            self.motion.clear()
            self._cancelling = False
        self.state = State.IDLE

    # ------------------------------------------------------------------------------------------ lines

    def _read(self) -> None:
        """Take lines out of the buffer for as long as there is room for what they order."""
        while self._received and self.motion.free and self._homing is None and self.state is not State.SLEEP:
            byte = self._received.popleft()
            if byte not in b"\r\n":
                self._line.append(byte)
                continue
            line, self._line = self._line.decode("ascii").upper().replace(" ", ""), bytearray()
            try:
                if len(line) > LONGEST:
                    raise GcodeError(11)
                self._execute(line)
            except GcodeError as refusal:
                self._send(f"error:{refusal.number}")

    def _execute(self, line: str) -> None:
        if line.startswith("$"):
            self._system(line[1:])
            if self._homing is not None:
                return  # answers when it is over
        elif line:
            self._move(line)
        self._send("ok")

    def _system(self, command: str) -> None:
        if command.startswith("J"):
            self._jog(command)
        elif command == "$":
            if self.state in (State.RUN, State.HOLD):
                raise GcodeError(8)
            self._send(*self.settings.lines())
        elif command == "X":
            if self.state is State.ALARM:
                self.state = State.IDLE
                self._send("[MSG:Caution: Unlocked]")
        elif command in ("", "G"):
            modes = self._modes
            kept = f"[GC:{modes.motion} G54 G17 {modes.units} {modes.distance} G94 M5 M9 T0 F{modes.feed:.0f} S0]"
            self._send(kept if command else HELP)
        elif self.state not in (State.IDLE, State.ALARM):
            raise GcodeError(8)
        else:
            self._at_rest(command)

    def _at_rest(self, command: str) -> None:
        if command == "I":
            self._send(*BUILD)
        elif command == "#":
            zeros = self._vector([0.0] * len(self._axes))
            self._send(*(f"[{name}:{zeros}]" for name in OFFSETS), "[TLO:0.000]", f"[PRB:{zeros}:0]")
        elif command.startswith("H"):
            if not self.settings[HOMING]:
                raise GcodeError(5)
            self.state = State.HOME
            if command != "H":  # refused too late: it stays in that state, in which nothing moves, until a reset
                raise GcodeError(3)
            self._homing = homing(self.motion, self.settings, self._turning, self._switch)
        elif command == "SLP":
            self.state = State.SLEEP
            self._send("[MSG:Sleeping]")
        else:
            self.settings.assign(command)
            self.motion.axes = tuple(self.settings.axes)

    def _jog(self, command: str) -> None:
        if self.state not in (State.IDLE, State.JOG):
            raise GcodeError(8)
        if not command.startswith("J="):
            raise GcodeError(3)
        line = understood(command[2:], self._modes, self._axes, jog=True)
        target = self._target(line)
        if self.settings[SOFT_LIMITS] and self.settings.beyond(target):
            raise GcodeError(15)
        if self.motion.add(target, line.feed):
            self.state = State.JOG

    def _move(self, text: str) -> None:
        if self.state not in (State.IDLE, State.RUN):
            raise GcodeError(9)
        line = understood(text, self._modes, self._axes)
        self._modes = line.modes
        if not line.axes:
            return
        target = self._target(line)
        if self.settings[SOFT_LIMITS] and self.settings.beyond(target):
            self._alarm(2)
        elif self.motion.add(target, line.feed):
            self.state = State.RUN

    def _target(self, line: GcodeLine) -> list[int]:
        absolute = line.machine or line.modes.distance == "G90"
        target = list(self.motion.planned)
        for n, (letter, axis) in enumerate(zip(self._axes, self.motion.axes, strict=True)):
            if letter in line.axes:
                steps = round(line.axes[letter] * axis.steps)
                target[n] = steps if absolute else target[n] + steps
        return target

    # ------------------------------------------------------------------------------------------ words

    def _report(self) -> str:
        places = [steps / axis.steps for steps, axis in zip(self.motion.position, self.motion.axes, strict=True)]
        speed = self.motion.speed * 60 if self.state in MOVES else 0.0
        held = f":{int(self.motion.moving)}" if self.state is State.HOLD else ""
        machine = self._vector(places)
        zeros = self._vector([0.0] * len(self._axes))
        more = {0: f"|WCO:{zeros}", 1: "|Ov:100,100,100"}.get(self._reports % 30, "")
        pins = f"|Pn:{self._axes[self._turning]}" if self._switch() else ""
        self._reports += 1
        return f"<{self.state}{held}|MPos:{machine}|FS:{speed:.0f},0{pins}{more}>"

    def _vector(self, places: list[float]) -> str:
        return ",".join(f"{place:.3f}" for place in places)

    def _send(self, *lines: str) -> None:
        for line in lines:
            self.out += line.encode() + b"\r\n"
