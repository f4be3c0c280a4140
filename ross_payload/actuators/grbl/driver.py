"""A stepper motor behind a microcontroller with stock grbl 1.1, which owns the timing of the steps.

A goal becomes one jog; grbl plans the trapezoid with its own $110 and $120. A goal that replaces another, and a stop,
cancel the jog (0x85), which slows down; the new jog begins from rest. ``?`` asks for a report every 20 ms. It tells
grbl's counter of steps: where the motor was told to be, which is why the feedback is a model; nobody measures. Reset,
alarm, sleep or a line that was lost make the position unknown until `home`.

What takes several exchanges is a script: a generator that goes on with every poll. Only the pump (`poll`) runs them;
the other methods leave a request in a queue.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import replace
from types import TracebackType
from typing import Any, Self

from ross_payload.actuators.grbl.link import EARLY
from ross_payload.actuators.grbl.options import Options
from ross_payload.actuators.grbl.session import Session
from ross_payload.actuators.requests import Ask, Move, Requests
from ross_payload.errors import ActuatorFault, LimitError, LinkError, NotHomed
from ross_payload.interfaces import Actuator, ActuatorState, Capabilities, Feedback, Services
from ross_protocols.grbl import State

PERIOD = 0.020  # [s] between two reports
STALE = 0.3  # [s]: a report that is older proves nothing
PAUSE = 0.010  # between two polls while closing [s]
Script = Generator[None, None, None]


class Grbl:
    """The driver: sans I/O over a port of bytes."""

    def __init__(self, options: Options, services: Services) -> None:
        self._options = options
        self._services = services
        self._session: Session | None = None
        self._requests = Requests()
        self._forgets = False  # a request waits that gives up the zero
        self._script: Script | None = None
        self._zero: int | None = None  # grbl's counter at joint angle 0
        self._opening = False  # who is there is not known yet
        self._left: int | None = None  # grbl's counter when it was closed
        self._fault = ""
        self._now = -math.inf
        self._state = ActuatorState(0.0, 0.0, settled=False, homed=False, healthy=True, time=-math.inf)
        self.capabilities = Capabilities(
            lower=-math.inf,
            upper=math.inf,
            max_speed=math.radians(options.max_speed_deg_s),
            max_acceleration=math.radians(options.max_acceleration_deg_s2),
            resolution=options.resolution,
            continuous=True,
            feedback=Feedback.MODEL,
            finds_zero=options.zero == "switch",
        )

    @property
    def identity(self) -> str:
        """Who answered, in words; empty while nobody has."""
        version = self._session.version if self._session is not None else ""
        return f"grbl {version.rstrip(':')}" if version else ""

    def command(self, angle: float, rate: float | None = None) -> None:
        """Go to the microstep nearest to a joint angle [rad], at most at ``rate`` [rad/s]; replaces the goal."""
        if not math.isfinite(angle):
            raise LimitError(f"goal {angle} rad is not finite")
        if self._fault:
            raise ActuatorFault(self._fault)
        if self._session is None or self._zero is None or self._forgets:
            raise NotHomed("the zero is not known: home first")
        goal = round(angle / self._options.resolution)
        if not self._session.allows(self._zero + goal):
            raise LimitError(f"goal {math.degrees(angle):.2f} deg is beyond grbl's soft limits")
        speed = min(rate or math.inf, self.capabilities.max_speed)
        self._requests.put(Move(goal * self._options.resolution, speed))

    def state(self) -> ActuatorState:
        """Return the state at the last poll; not settled while a request waits, nor homed if it gives up the zero."""
        if self._requests.empty:
            return self._state
        return replace(self._state, settled=False, homed=self._state.homed and not self._forgets)

    def stop(self) -> None:
        """Cancel the jog: grbl decelerates."""
        self._requests.put(Ask.HALT)

    def home(self) -> None:
        """Come to rest, unlock, and find the limit switch, or declare that here is the zero; clears a fault."""
        self._forgets = True
        self._requests.put(Ask.HOME)

    def release(self) -> None:
        """Come to rest and sleep, without torque; the position is unknown afterwards."""
        self._forgets = True
        self._requests.put(Ask.RELEASE)

    def poll(self, now: float) -> None:
        """Take in what grbl says, obey requests, go on with what is under way, publish the state at ``now`` [s]."""
        session = self._session
        if session is None:
            return
        self._now = now
        try:
            trouble = session.listen(now)
            if trouble:
                self._lose(trouble, known=session.position_known)
            for request in self._requests.taken():
                self._script = self._obey(session, request)
            self._go_on()
            session.ask(now, PERIOD)
        except LinkError as error:
            session.forget()
            self._lose(str(error), known=False)
            raise
        finally:
            self._publish(session)

    def __enter__(self) -> Self:
        """Open the line; nothing moves, and a jog that somebody left behind ends."""
        clock = self._services.clock
        self._session = Session(self._options, self._services.open_port(self._options.port), clock.now())
        self._script = self._open(self._session)
        self._fault, self._opening = "", True
        self._state = replace(self._state, settled=False, healthy=True, time=-math.inf, fault="")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Cancel the jog, wait until it has come to rest, and close the line; idempotent."""
        session, clock = self._session, self._services.clock
        if session is None:
            return
        self.stop()
        patience = clock.now() + self.capabilities.max_speed / self.capabilities.max_acceleration + 1.0
        try:
            self.poll(clock.now())
            while self._script is not None and clock.now() < patience:
                clock.sleep(PAUSE)
                self.poll(clock.now())
        except LinkError as gone:
            self._fault = str(gone)
        self._left = session.track.count if self._script is None else None
        self._session = self._script = None
        session.close()

    # ------------------------------------------------------------------------------------------ scripts

    def _go_on(self) -> None:
        """Let the script that is under way do what it can."""
        if self._script is None:
            return
        try:
            next(self._script)
        except StopIteration:
            self._script = None
        except ActuatorFault as error:
            self._script = None
            self._lose(str(error), known=self._session is not None and self._session.position_known)

    def _obey(self, session: Session, request: Move | Ask) -> Script | None:
        self._opening = False
        if isinstance(request, Move):
            return self._move(session, request) if not self._fault and self._zero is not None else self._script
        if request is Ask.HALT:
            return session.come_to_rest()
        self._zero, self._forgets = None, False
        return self._release(session) if request is Ask.RELEASE else self._home(session)

    def _open(self, session: Session) -> Script:
        """Find out who is there; a zero that is declared is where the counter stands."""
        yield from session.meet()
        if session.doing is State.SLEEP:
            self._zero, self._opening = None, False
            return
        yield from session.identify()
        self._opening = False
        count = session.track.count
        if self._zero is not None and count != self._left:
            self._zero = None
        elif self._options.zero == "declared" and self._left is None and session.doing is State.IDLE:
            self._zero = count

    def _move(self, session: Session, move: Move) -> Script:
        yield from session.come_to_rest()
        if self._zero is None:
            raise ActuatorFault("the zero is not known: home first")
        yield from session.jog(self._zero + round(move.goal / self._options.resolution), move.rate)

    def _home(self, session: Session) -> Script:
        yield from session.come_to_rest()
        if session.doing not in (State.IDLE, State.ALARM):
            yield from session.reset()
        if not session.identified:
            yield from session.identify()
        at = 0.0
        if self._options.zero == "switch":
            yield from session.find_switch()
            at = math.radians(self._options.home_deg)
        elif session.doing is State.ALARM:
            yield from session.unlock()
        if session.track.count is not None:
            self._zero = session.track.count - round(at / self._options.resolution)
            self._fault = ""

    def _release(self, session: Session) -> Script:
        yield from session.come_to_rest()
        yield from session.sleep()

    # ------------------------------------------------------------------------------------------ state

    def _lose(self, fault: str, *, known: bool) -> None:
        """Latch a fault, which ends what is under way; unless it is still known, the position is lost."""
        if not (known and self._fault):
            self._script = None
        self._fault = self._fault or fault
        self._zero = self._zero if known else None

    def _still(self, session: Session) -> bool:
        """Whether grbl has been idle at one place for settle_ms."""
        return session.report_time - session.track.still_since >= self._options.settle_ms * 1e-3 - EARLY

    def _publish(self, session: Session) -> None:
        track, time = session.track, self._now if session.homing else session.report_time
        time = -math.inf if self._opening else time
        known = track.count is not None
        angle = ((track.count or 0) - (self._zero or 0)) * self._options.resolution if known else self._state.angle
        fresh = self._now - session.report_time <= STALE
        self._state = ActuatorState(
            angle=angle,
            rate=track.rate,
            settled=not self._fault and self._script is None and fresh and self._still(session),
            homed=self._zero is not None,
            healthy=not self._fault,
            time=time,
            fault=self._fault,
        )


class GrblBackend:
    """Stepper motor behind a microcontroller with grbl 1.1 on a serial line: jogs, open loop."""

    Config: type[Any] = Options

    def open(self, config: Options, services: Services) -> Actuator:
        """Make the driver."""
        return Grbl(config, services)


backend = GrblBackend()
