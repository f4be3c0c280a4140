"""What can be asked of grbl, as scripts that go on with every poll; each ends when grbl's own reports say so."""

from __future__ import annotations

import logging
import math
from collections.abc import Generator

from ross_payload.actuators.driver_shell import HELD_UP_S, MAX_CATCH_UP_S
from ross_payload.actuators.grbl.line_protocol import LineProtocol
from ross_payload.actuators.grbl.options import Options, complaint, slower
from ross_payload.actuators.grbl.position_tracker import PositionTracker
from ross_payload.errors import ActuatorFault
from ross_payload.interfaces import Port
from ross_protocols.grbl import protocol

Script = Generator[None, None, None]
log = logging.getLogger(__name__)
START_TIMEOUT_S = 5.0  # with a board that starts [s]
ANSWER_TIMEOUT_S = 1.0  # grbl answers a line within [s]
DOUBT_S = 10.0  # so long before its settings are read a damaged line makes them doubtful [s]
STRAY_ANSWER_S = 0.2  # within which that to a line comes which was told before it started [s]
CANCEL_PERIOD_S = 0.020  # between two bytes that cancel [s]
VOID = b"$\n"  # asks for help; at the end of what somebody left half said, such as a jog, it makes that no command
GOAL_TOLERANCE_STEPS = 1  # step by which rounding may miss a goal


class GrblClient:
    """One opening of the line.

    Parameters
    ----------
    options
        Of the driver.
    port
        Open.
    now
        [s].
    """

    def __init__(self, options: Options, port: Port, now: float) -> None:
        self._options = options
        self._port = port
        self._now = now
        self._pause, self._caught_up_at = 0.0, -math.inf  # the last one of this program; when it is made up for [s]
        self._line = LineProtocol(port)
        self._settings: dict[int, float] = {}
        self._version = ""
        self._starting = True  # a banner is no surprise
        self._starts = 0  # banners
        self.tracker = PositionTracker(options.index, options.resolution)
        self.identified = False
        self._identified_at = -math.inf  # when its settings began to be read [s]; minus infinity: not, or wrong
        self.homing = False  # during which grbl tells nothing, until it has told where it is
        self.position_known = False  # whether the counter still means what it did

    @property
    def doing(self) -> protocol.State | None:
        """What grbl does, by its last report."""
        return self._line.report.state if self._line.report is not None else None

    @property
    def version(self) -> str:
        """Of the firmware; empty until it is known."""
        return self._version

    @property
    def is_doubtful(self) -> bool:
        """Whether its settings may have come damaged, which have no check sum: others have since, or about then."""
        return not self.identified or self._line.damaged_at >= self._identified_at - DOUBT_S

    @property
    def report_time(self) -> float:
        """When the last report was asked for [s]."""
        return self._line.time

    def read(self, now: float) -> str:
        """Take in what grbl says; return what is wrong, empty when all is well."""
        if now - self._now > HELD_UP_S:  # if it was the whole computer's, a simulated grbl on it makes up for the time
            self._pause = min(now - self._now, MAX_CATCH_UP_S)
            self._caught_up_at = now + self._pause
        self._now = now
        found = [self._on_message(message) for message in self._line.read(now)]
        trouble = next(filter(None, found), "")
        if trouble:
            return trouble
        noise = self._line.noise(now) if self.identified else ""
        self.position_known = self.identified
        return noise

    def poll_report(self, now: float, period: float) -> None:
        """Ask for a report, when one is due."""
        if not (self.homing and self._line.waiting):
            self._line.poll_report(now, period)

    def allows(self, count: int) -> bool:
        """Whether a counter is within grbl's soft limits, where they are on; they end at machine position 0."""
        if not self._settings.get(protocol.SOFT_LIMITS):
            return True
        place = math.degrees(count * self._options.resolution)
        return -self._settings.get(protocol.TRAVEL + self._options.index, 0.0) <= place <= 0

    def forget(self) -> None:
        """Restart: the line was lost."""
        self._line = LineProtocol(self._port)
        self.tracker = PositionTracker(self._options.index, self._options.resolution)
        self.identified = self.homing = self.position_known = False
        self._starting = True

    def close(self) -> None:
        """Give the line back."""
        self._port.close()

    # ------------------------------------------------------------------------------------------ scripts

    def wait_for_report(self) -> Script:
        """Wait for the first report, and end a jog that somebody left behind."""
        until = self._now + START_TIMEOUT_S
        while self.doing is None:
            if self._now > until:
                noise = self._line.noise(self._now)
                hint = f" ({noise}: is the baud rate right?)" if noise else ""
                raise ActuatorFault(f"no response from grbl 1.1 on {self._options.port}{hint}")
            yield
        yield from self.come_to_rest()

    def identify(self) -> Script:
        """Read version and settings and hold them against the options."""
        starts, begin, self._identified_at = -1, self._now, -math.inf
        while starts != self._starts:  # once more when it has started meanwhile
            starts, self._version = self._starts, ""
            self._settings.clear()
            for line in (VOID, b"$I\n", b"$$\n"):
                yield from self._send_line(line, refused=line == VOID)
                if starts != self._starts:
                    yield from self._wait_for_strays()
                    break
        if not self._version.startswith("1.1"):
            raise ActuatorFault(f"expected grbl 1.1, got {self._version or 'an unknown version'}")
        wrong = complaint(self._settings, self._options)
        if wrong:
            raise ActuatorFault(wrong)
        self.tracker.acceleration = math.radians(self._settings[protocol.ACCELERATION + self._options.index])
        for note in slower(self._settings, self._options):
            log.warning("%s", note)
        yield from self._fresh_report()
        self._starting, self.identified, self.position_known = False, True, True
        self._identified_at = begin

    def void(self) -> Script:
        """End what somebody left half said, or was lost on its way, so that it is refused."""
        yield from self._send_line(VOID, refused=True)

    def come_to_rest(self) -> Script:
        """Cancel what moves until grbl says that it is at rest; a reset ends homing, an answer may have been lost."""
        self.tracker.goal, again, until = None, -math.inf, self._now + ANSWER_TIMEOUT_S
        if self.homing:
            yield from self.reset()
        while self._line.waiting or not self._at_rest():
            if self._now > until:
                self._line.waiting = False
            if self.doing is protocol.State.HOME:  # it tells nothing while it homes: this one never began, nor ends
                yield from self.reset()
            self.tracker.ours = True
            if self._now >= again:
                again = self._now + CANCEL_PERIOD_S
                self._line.send_byte(protocol.HOLD if self.doing is protocol.State.RUN else protocol.JOG_CANCEL)
            yield
        self.tracker.rest()

    def jog(self, count: int, speed: float) -> Script:
        """Go to a counter [steps] at most at ``speed`` [rad/s], until grbl is idle there."""
        self.tracker.begin(count, self._now)
        yield from self._send_line(protocol.jog(self._options.axis, count * self._options.resolution, speed))
        while not self._at_rest():
            yield
        self.tracker.rest()
        here = self.tracker.count
        if here is None or abs(here - count) > GOAL_TOLERANCE_STEPS or self.doing is not protocol.State.IDLE:
            found, wanted = (math.degrees((each or 0) * self._options.resolution) for each in (here, count))
            raise ActuatorFault(
                f"another controller stopped grbl: {self.doing} at machine position {found:.2f} deg, not {wanted:.2f}"
            )

    def find_switch(self) -> Script:
        """Let grbl home; it tells nothing until it is over."""
        self.homing, self.tracker.ours = True, True
        try:
            yield from self._send_line(b"$H\n", timeout=self._options.homing_s)
            self.tracker.count = None  # the counter is another one now
            yield from self._fresh_report()
        except ActuatorFault:
            self.homing = False
            raise
        self.homing = False
        self.tracker.rest()

    def unlock(self) -> Script:
        """End an alarm."""
        yield from self._send_line(b"$X\n")
        yield from self._fresh_report()

    def sleep(self) -> Script:
        """Take the torque away; only a reset wakes grbl, which answers no line until then."""
        if self.doing is not protocol.State.SLEEP:
            yield from self._send_line(b"$SLP\n")

    def reset(self) -> Script:
        """Reset grbl: wakes it, ends its homing, a hold, a program."""
        self._starting, self.homing = True, False
        self._line.forget()
        self._line.send_byte(protocol.RESET)
        try:
            yield from self._fresh_report()
        finally:  # also when an alarm ends it: what starts later is a surprise
            self._starting = False

    # ------------------------------------------------------------------------------------------ words

    def _on_message(self, message: protocol.Message) -> str:
        if isinstance(message, protocol.Setting):
            self._settings[message.number] = message.value
        elif isinstance(message, protocol.Info):
            self._version = message.text if message.key == "VER" else self._version
        elif isinstance(message, protocol.Alarm):
            self.position_known = self.homing = False
            return f"grbl: {message.words}"
        elif isinstance(message, protocol.Banner):
            return self._on_banner()
        elif isinstance(message, protocol.Report):
            return self._on_report(message)
        return ""

    def _on_banner(self) -> str:
        self._line.forget()
        self._starts += 1
        if self._starting:
            return ""
        self.forget()
        return "grbl has restarted: the position is lost"

    def _on_report(self, report: protocol.Report) -> str:
        fastest = protocol.rate(self._settings.get(protocol.MAX_RATE + self._options.index, math.inf))
        elapsed = self._now - self._line.time + (self._pause if self._now <= self._caught_up_at else 0.0)
        if self.identified and not self.tracker.possible(report, elapsed, fastest):
            self._line.on_damage(self._now, "a position out of reach")
            return ""
        strange = self.tracker.on_report(report, self._line.on_report(report))
        return strange if self.identified else ""

    def _at_rest(self) -> bool:
        """Whether a report since the last answer says so."""
        report = self._line.report
        return self._line.is_new and report is not None and report.at_rest

    def _send_line(self, line: bytes, *, timeout: float = ANSWER_TIMEOUT_S, refused: bool = False) -> Script:
        """Say a line and wait for its answer; ``refused``: an error is one, too."""
        self._line.send_line(line)
        until = self._now + timeout
        while self._line.waiting:
            if self._now > until:
                raise ActuatorFault(f"grbl does not answer to '{line.decode().strip()}'")
            yield
        answer = self._line.answer
        if isinstance(answer, protocol.Error) and not refused:
            raise ActuatorFault(f"grbl refuses '{line.decode().strip()}': {answer.words}")

    def _wait_for_strays(self) -> Script:
        """Let the answer pass by that grbl may give to what it was told while it started."""
        until = self._now + STRAY_ANSWER_S
        while self._now < until:
            yield

    def _fresh_report(self) -> Script:
        """Wait for a report that is asked for from here on."""
        since, until = self._now, self._now + START_TIMEOUT_S
        while self.report_time < since or not self._line.is_new:
            if self._now > until:
                raise ActuatorFault("grbl does not report")
            yield
