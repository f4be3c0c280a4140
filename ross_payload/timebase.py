"""Which time it is: since boot until a UNIX time can be trusted, and how the autopilot's clock lies to ours."""

from __future__ import annotations

import logging
import math
import threading
from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Protocol

from ross_payload import trusted_autopilot
from ross_payload.interfaces import Clock
from ross_protocols.mavlink import vehicle
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.vehicle import SystemTime, TimeSync

SAMPLES = 16  # round trips kept: the quickest one tells most
ANSWER_PERIOD_S = 0.02  # [s] between two answers of ours: nobody needs more
ANSWER_TIMEOUT_S = 1.0  # [s] that an answer may take
CLOCK_DRIFT_S = 0.005  # [s] that clocks may have drifted apart since an older round trip
ORDER_S = 1.0  # by which messages may come out of order [s]
STEP_S = 0.5  # [s]: a UNIX time that is off by more is set again, a smaller difference is worked off
EASE = 0.1  # of a smaller difference, at a time
SLOWEST = 0.9  # of real time, at which time goes on while it is ahead of a clock that was set back
LOOK_PERIOD_S = 10.0  # [s] between two looks at the system's clock, where no autopilot tells the time
FAR_S = 86_400.0  # [s]: a UNIX time that is ahead by more has to be told twice in a row
PLAUSIBLE = 4_102_444_800.0  # UNIX time of 2100 [s]: a clock that says more is wrong

log = logging.getLogger(__name__)


class ReceivedPacket(trusted_autopilot.ReceivedPacket, Protocol):
    """A packet and how it came."""

    @property
    def link(self) -> str:
        """URL of the link."""


class Component(Protocol):
    """A component on the links."""

    @property
    def id(self) -> ComponentId:
        """Its address."""

    def send(self, value: Any, link: str | None = None) -> None:
        """Send a message on one link, or on all."""

    def subscribe(self, call: Callable[[Any], None]) -> None:
        """Call with everything that is heard."""


class Timebase:
    """The time for telemetry and files: microseconds that never run backwards, and never stand still.

    After the UNIX time was set back they go on at nine tenths of real time until they agree with it again.

    Everything but `usec`, `utc`, `sure_utc` and `unix` belongs to the pump. Requests of TIMESYNC to us by name are
    answered, whoever asks. Those to everybody are not: PX4 and MAVROS ask so, to know each other's clock, and take an
    answer of anybody for it. Every heartbeat of the autopilot (1 Hz) is answered with a request of our own, to it
    alone: an answer of anybody else would reach the autopilot, which may take it for one to itself.

    Parameters
    ----------
    clock
        Ours.
    system
        Tells the UNIX time [s] of the system's clock, None when that cannot be trusted.
    unkept
        Tells the UNIX time [s] of the system's clock also when nobody keeps it right: enough to confirm a date.
    system_id
        Of the vehicle; 0: that of the first autopilot.

    Examples
    --------
    >>> from ross_payload.clock import SystemClock
    >>> Timebase(SystemClock()).unix
    False
    """

    def __init__(
        self,
        clock: Clock,
        system: Callable[[], float | None] = lambda: None,
        unkept: Callable[[], float | None] = lambda: None,
        *,
        system_id: int = 0,
    ) -> None:
        self._clock = clock
        self._system = system
        self._unkept = unkept
        self._autopilot = trusted_autopilot.TrustedAutopilot(system_id)
        self._component: Component | None = None
        self._answered = -math.inf  # when a request was answered last [s]
        self._asked: deque[int] = deque(maxlen=4)  # times of our requests [ns]
        self._trips: deque[tuple[float, float]] = deque(maxlen=SAMPLES)  # round trip, our clock less theirs [s]
        self._boot = -math.inf  # its latest time since its start [s]
        self._behind = False  # the latest one was from long before
        self._far: float | None = None  # its time since its start when the latest UNIX time was far ahead [s]
        self._epoch: float | None = None  # UNIX time at 0 of our clock [s]
        self._told: float | None = None  # since when by the autopilot [s], which goes before the system
        self._doubted = False  # that nobody confirms it is in the log
        self._looked = -math.inf  # at the system's clock [s]
        self._earliest = math.inf  # of these, but for what was left by a leap more than a day ago [s]
        self._leapt: float | None = None  # since when the date is more than a day after the earliest one [s]
        self._lock = threading.Lock()
        self._latest: tuple[float, float] | None = None  # by `usec` last, and when [s]

    @property
    def unix(self) -> bool:
        """Whether `usec` counts from 1970; else since the boot of this computer."""
        with self._lock:
            return self._since_1970() is not None

    def usec(self) -> int:
        """Return the time [us]."""
        with self._lock:
            now = self._clock.now()
            time = now + (self._since_1970() or 0.0)
            if self._latest is not None:
                last, then = self._latest
                time = max(time, last + SLOWEST * (now - then))
            self._latest = time, now
        return round(time * 1e6)

    def utc(self) -> datetime | None:
        """Return the time of day; None while no clock can be trusted. It is set back at once, unlike `usec`."""
        with self._lock:
            return self._utc()

    def sure_utc(self) -> datetime | None:
        """Return the time of day; None also while the date has `leapt`, be it by this very look at a clock.

        And while nobody confirms one of the autopilot: the system's clock, or that it has stood for a day.
        """
        with self._lock:
            now = self._utc()
            return None if now is None or self.leapt or not self._confirmed(now.timestamp()) else now

    @property
    def leapt(self) -> bool:
        """Whether the date has leapt ahead by more than a day, in the last day of this program.

        That is not how time passes: it was wrong before, or is now, as that of a satellite receiver may be.
        """
        return self._leapt is not None

    def local(self, boot: float) -> float | None:
        """Return the time on our clock [s] of a time on the autopilot's; None before a round trip has told."""
        return boot + min(self._trips)[1] if self._trips else None

    def attach(self, component: Component) -> None:
        """Listen and speak as a component."""
        self._component = component
        component.subscribe(self.on_packet)

    def on_packet(self, received: ReceivedPacket) -> None:
        """Take in what any link has heard."""
        message = vehicle.read(received.packet.message)
        if isinstance(message, TimeSync) and message.answered is None:
            self._answer(message, received)
        elif not self._autopilot.sent(received):
            return
        elif isinstance(message, TimeSync) and message.answered is not None:
            self._measure(message.asked, message.answered)
        elif isinstance(message, SystemTime):
            self._on_time(message)
        elif received.packet.name == "HEARTBEAT":
            self._asked.append(self._nanoseconds())
            self._send(TimeSync(self._asked[-1], target=received.packet.sender), received.link)

    def _on_time(self, message: SystemTime) -> None:
        """Take what its clocks say; two in a row that are far behind mean that it has restarted, one is late.

        A UNIX time far ahead counts when it is told twice in a row: by a single wrong one all recordings are too old.
        """
        behind = message.boot < self._boot - ORDER_S
        if behind and not self._behind:
            self._behind = True
            return
        if behind:
            self._trips.clear()
        self._boot, self._behind = message.boot, False
        if message.unix is not None and message.unix < PLAUSIBLE:
            epoch = message.unix - (self.local(message.boot) or self._clock.now())
            with self._lock:
                before, known = self._far, self._since_1970()
            self._far = message.boot if known is not None and epoch - known > FAR_S else None
            if self._far is None or before not in (None, self._far):  # the same one may come over two links
                with self._lock:
                    self._told = self._clock.now() if self._told is None else self._told
                    self._set(epoch)

    def _answer(self, request: TimeSync, received: ReceivedPacket) -> None:
        """Tell who asks us our time, and in whose name it is told: the requests of others are alike."""
        now = self._clock.now()
        asked = self._component is not None and request.target == self._component.id
        if asked and now - self._answered >= ANSWER_PERIOD_S:
            self._answered = now
            self._send(TimeSync(request.asked, self._nanoseconds(), received.packet.sender), received.link)

    def _measure(self, asked: int, answered: int) -> None:
        """Take the answer to one of our requests for what it says half-way through its round trip."""
        now, begin = self._nanoseconds() / 1e9, asked / 1e9
        if asked not in self._asked or not 0 <= now - begin <= ANSWER_TIMEOUT_S:
            return
        trip = (now - begin, (begin + now) / 2 - answered / 1e9)
        if self._trips and abs(trip[1] - min(self._trips)[1]) > (trip[0] + min(self._trips)[0]) / 2 + CLOCK_DRIFT_S:
            self._trips.clear()  # the autopilot has restarted its count
        self._trips.append(trip)

    def _set(self, epoch: float) -> None:
        if self._epoch is None or abs(epoch - self._epoch) > STEP_S:
            if self._epoch is not None and epoch < self._epoch:
                log.warning("the time of day was set back by %.1f s: time stamps slow down", self._epoch - epoch)
            self._epoch = epoch
        else:
            self._epoch += EASE * (epoch - self._epoch)
        self._look_for_leap(self._epoch, self._clock.now())

    def _look_for_leap(self, epoch: float, now: float) -> None:
        self._earliest = min(self._earliest, epoch)
        if epoch - self._earliest <= FAR_S:
            self._leapt = None
        elif self._leapt is None:
            self._leapt = now
            days = (epoch - self._earliest) / FAR_S
            log.warning("the date has leapt ahead by %.0f days: nothing recorded is taken for old by it", days)
        elif now - self._leapt > FAR_S:
            self._earliest, self._leapt = epoch, None

    def _confirmed(self, unix: float) -> bool:
        """Tell whether a second clock, or a day, speaks for this date; say once in the log when none does."""
        kept = self._system()
        other = self._unkept() if kept is None else kept
        if self._told is None or (other is not None and abs(unix - other) <= FAR_S):
            self._doubted = False
            return True
        if kept is None and self._clock.now() - self._told > FAR_S:
            return True
        if not self._doubted:
            self._doubted = True
            days = "cannot be asked" if other is None else f"is {abs(unix - other) / FAR_S:.0f} days off"
            log.warning(
                "nobody confirms the date that the autopilot tells: the clock of this computer %s; "
                "nothing recorded is taken for old by it",
                days,
            )
        return False

    def _utc(self) -> datetime | None:
        epoch = self._since_1970()
        return None if epoch is None else datetime.fromtimestamp(self._clock.now() + epoch, UTC)

    def _since_1970(self) -> float | None:
        """Return the UNIX time at 0 of our clock [s]; that of the system goes on while our clock is suspended."""
        now = self._clock.now()
        if self._told is None and (self._epoch is None or now - self._looked >= LOOK_PERIOD_S):
            system, self._looked = self._system(), now
            if system is not None:
                self._set(system - now)
        return self._epoch

    def _send(self, value: TimeSync, link: str) -> None:
        if self._component is not None:
            self._component.send(vehicle.time_sync(value), link)

    def _nanoseconds(self) -> int:
        return round(self._clock.now() * 1e9)
