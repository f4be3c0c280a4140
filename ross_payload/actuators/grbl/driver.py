"""A stepper motor behind a microcontroller with stock grbl 1.1, which owns the timing of the steps.

A goal becomes one jog; grbl plans the trapezoid with its own $110 and $120. A goal that replaces another, and a stop,
cancel the jog (0x85), which slows down; the new jog begins from rest. ``?`` asks for a report every 20 ms. It tells
grbl's counter of steps: where the motor was told to be, which is why the feedback is a model; nobody measures. Reset,
alarm, sleep or a line that was lost make the position unknown until `home`.

What takes several exchanges is a script: a generator that goes on with every poll.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from ross_payload.actuators.driver_shell import TIME_TOLERANCE_S, Driver, DriverBackend, Move, Request, capabilities_of
from ross_payload.actuators.grbl.grbl_client import GrblClient, Script
from ross_payload.actuators.grbl.options import Options
from ross_payload.errors import ActuatorFault, LimitError, LinkError
from ross_payload.interfaces import ActuatorState, Clock, Feedback, Port
from ross_protocols.grbl.protocol import State

REPORT_PERIOD_S = 0.020  # [s] between two reports
STALE_REPORT_S = 0.3  # [s]: a report that is older proves nothing


class Grbl(Driver):
    """The driver: sans I/O over a port of bytes."""

    forgets_zero = True

    def __init__(self, options: Options) -> None:
        self._options = options
        self._client: GrblClient
        self._script: Script | None = None
        self._zero: int | None = None  # grbl's counter at joint angle 0
        self._opening = False  # who is there is not known yet
        self._count_at_close: int | None = None  # grbl's counter when it was closed
        self._fault = ""
        self._angle = 0.0  # last published [rad]
        self.capabilities = capabilities_of(
            options, options.resolution, Feedback.MODEL, endless=True, finds_zero=options.zero == "switch"
        )

    @property
    def identity(self) -> str:
        """Who answered, in words; empty while nobody has."""
        version = self._client.version
        return f"grbl {version.rstrip(':')}" if version else ""

    def goal(self, angle: float) -> float:
        """Return the microstep nearest to a joint angle [rad]."""
        steps = round(angle / self._options.resolution)
        if self._zero is not None and not self._client.allows(self._zero + steps):
            raise LimitError(f"goal {math.degrees(angle):.2f} deg is beyond grbl's soft limits")
        return steps * self._options.resolution

    def open(self, port: Port, now: float) -> None:
        """Begin to find out who is there; a jog that somebody left behind ends."""
        self._client = GrblClient(self._options, port, now)
        self._script = self._open(self._client)
        self._fault, self._opening = "", True

    def read(self, now: float) -> None:
        """Take in what grbl says."""
        trouble = self._client.read(now)
        if trouble:
            self._lose(trouble, known=self._client.position_known)

    def obey(self, request: Move | Request, now: float) -> None:
        """Begin the script of a request, in place of the one under way."""
        client, self._opening = self._client, False
        if isinstance(request, Move):
            self._script = self._move(client, request) if not self._fault and self._zero is not None else self._script
        elif request is Request.HALT:
            self._script = client.come_to_rest()
        else:
            self._zero = None
            self._script = self._release(client) if request is Request.RELEASE else self._home(client)

    def write(self, now: float) -> None:
        """Let the script that is under way do what it can, and ask for a report."""
        try:
            next(self._script or iter(()))
        except StopIteration:
            self._script = None
        except ActuatorFault as error:
            self._script = None
            self._lose(str(error), known=self._client.position_known)
        self._client.poll_report(now, REPORT_PERIOD_S)

    def snapshot(self, now: float) -> ActuatorState:
        """Return the state at ``now`` [s]."""
        client, tracker = self._client, self._client.tracker
        time = -math.inf if self._opening else now if client.homing else client.report_time
        if tracker.count is not None:
            self._angle = (tracker.count - (self._zero or 0)) * self._options.resolution
        return ActuatorState(
            angle=self._angle,
            rate=tracker.rate,
            settled=not self._fault
            and self._script is None
            and now - client.report_time <= STALE_REPORT_S
            and client.report_time - tracker.still_since >= self._options.settle_ms * 1e-3 - TIME_TOLERANCE_S,
            homed=self._zero is not None,
            healthy=not self._fault,
            time=time,
            fault=self._fault,
        )

    def link_lost(self, error: LinkError) -> bool:
        """Latch it: the position is lost."""
        self._client.forget()
        self._lose(str(error), known=False)
        return False

    def leave(self, clock: Clock) -> Iterator[None]:
        """Cancel the jog and wait until it has come to rest."""
        until = clock.now() + self.capabilities.max_speed / self.capabilities.max_acceleration + 1.0
        self.obey(Request.HALT, clock.now())
        yield
        while self._script is not None and clock.now() < until:
            yield

    def close(self) -> None:
        """Close the line."""
        self._count_at_close = self._client.tracker.count if self._script is None else None
        self._script = None
        self._client.close()

    # ------------------------------------------------------------------------------------------ scripts

    def _open(self, client: GrblClient) -> Script:
        """Find out who is there; a zero that is declared is where the counter stands."""
        yield from client.wait_for_report()
        if client.doing is State.SLEEP:
            self._zero, self._opening = None, False
            return
        yield from client.identify()
        self._opening = False
        count = client.tracker.count
        if self._zero is not None and count != self._count_at_close:
            self._zero = None
        elif self._options.zero == "declared" and self._count_at_close is None and client.doing is State.IDLE:
            self._zero = count

    def _move(self, client: GrblClient, move: Move) -> Script:
        yield from client.come_to_rest()
        if self._zero is None:
            raise ActuatorFault("the zero is not known: home first")
        yield from client.jog(self._zero + round(move.goal / self._options.resolution), move.rate)

    def _home(self, client: GrblClient) -> Script:
        yield from client.come_to_rest()
        if client.doing not in (State.IDLE, State.ALARM):
            yield from client.reset()
        yield from client.identify() if client.is_doubtful else client.void()
        at = 0.0
        if self._options.zero == "switch":
            yield from client.find_switch()
            at = math.radians(self._options.home_deg)
        elif client.doing is State.ALARM:
            yield from client.unlock()
        if client.tracker.count is not None:
            self._zero = client.tracker.count - round(at / self._options.resolution)
            self._fault = ""

    def _release(self, client: GrblClient) -> Script:
        yield from client.come_to_rest()
        yield from client.sleep()

    def _lose(self, fault: str, *, known: bool) -> None:
        """Latch a fault, which ends what is under way; unless it is still known, the position is lost."""
        if not (known and self._fault):
            self._script = None
        self._fault = self._fault or fault
        self._zero = self._zero if known else None


backend = DriverBackend(
    "Stepper motor behind a microcontroller with grbl 1.1 on a serial line: jogs, open loop.", Options, Grbl
)
