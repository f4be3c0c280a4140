"""Where the base of the payload points and how high it is: one that never turns, or a vehicle, as its autopilot tells.

Audio is read late and asks where the base pointed when it was captured: attitudes of the recent past are kept.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, replace
from typing import Literal

from ross_payload.angles import wrap
from ross_payload.config import VEHICLE_YAW, Config
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Attitude, Clock, Mount
from ross_payload.mavlink import Component, Received, Router
from ross_payload.mount.rotor_speeds import RotorSpeeds, WithRotors
from ross_payload.timebase import Timebase
from ross_payload.trusted_autopilot import TrustedAutopilot
from ross_protocols.mavlink import vehicle
from ross_protocols.mavlink.vehicle import VehicleAttitude

WANTED = 25.0  # [Hz] of ATTITUDE
ENOUGH = 18.0  # [Hz]: what flows at this rate is not asked for again
MAX_DELAY_S = 1.0  # [s] that a report may have been on its way
ATTITUDE, POSITION = 30, 33  # message ids
POSITION_WANTED = 2.0  # [Hz] of GLOBAL_POSITION_INT, where it tells the height
HEIGHT_TIMEOUT_S = 3.0  # [s]: an older height is not known
MOUTH = 1.6  # of somebody who stands, above the ground [m]
EXTRAPOLATION_S = 0.1  # [s] beyond the newest report that its rate is trusted
MOST = 5000  # reports kept at least, of the newest: 100 s at 50 Hz


class AttitudeHistory:
    """The latest reports of a vehicle; written by the pump, read by the mission's thread.

    Parameters
    ----------
    fresh
        An attitude whose latest report is older than this [s] is not known.
    """

    def __init__(self, fresh: float) -> None:
        self._fresh = fresh
        self._kept: tuple[list[float], list[VehicleAttitude]] = ([], [])  # times [s] and reports; only appended to

    def note(self, time: float, report: VehicleAttitude) -> None:
        """Keep a report of ``time`` [s]; one that is not newer than the last one is dropped."""
        times, reports = self._kept
        if times and time <= times[-1]:
            return
        if len(times) >= 2 * MOST:  # others may be reading the old lists
            self._kept = times, reports = times[-MOST:], reports[-MOST:]
        reports.append(report)
        times.append(time)

    def newest(self) -> float | None:
        """Return the time of the latest report [s]."""
        times, _ = self._kept
        return times[-1] if times else None

    def at(self, time: float) -> Attitude:
        """Return the attitude at ``time`` [s]: interpolated, or a little ahead of the newest report.

        ``age`` is that of the last report before; ``sigma`` is what the rate may have changed by since, no more: what
        the compass is worth nobody knows here. Not known means yaw 0, the frame of the mount.
        """
        times, reports = self._kept
        count = len(times)
        after = bisect_right(times, time, 0, count)
        if after == 0 or time - times[after - 1] > self._fresh:
            return Attitude(0.0, age=time - times[after - 1] if after else float("inf"), known=False)
        last, age = reports[after - 1], time - times[after - 1]
        if after < count and times[after] - times[after - 1] <= self._fresh:
            return _between(last, reports[after], age / (times[after] - times[after - 1]), age)
        yaw = wrap(last.yaw + last.yaw_rate * min(age, EXTRAPOLATION_S))
        return Attitude(yaw, last.pitch, last.roll, sigma=abs(last.yaw_rate) * age, age=age)


class AutopilotMount:
    """Where the base points, from ATTITUDE and AUTOPILOT_STATE_FOR_GIMBAL_DEVICE of component 1.

    Reports are dated by the autopilot's clock once a round trip has told how it lies to ours, before that by their
    arrival. The heartbeat of the autopilot tells when to look whether they flow, and when not, to ask for them.

    `on_packet` belongs to the pump; `attitude` to anybody.

    Parameters
    ----------
    component
        Who asks, and where it is heard.
    clock
        Ours.
    timebase
        How the autopilot's clock lies to it.
    fresh
        An attitude that is older than this [s] is not known.
    system_id
        Of the vehicle; 0: that of the first autopilot.
    height
        Above the mouths of those who talk [m]; ``"autopilot"``: above home, less `MOUTH`; None: not known.
    """

    def __init__(
        self,
        component: Component,
        clock: Clock,
        timebase: Timebase,
        *,
        fresh: float,
        system_id: int = 0,
        height: float | Literal["autopilot"] | None = None,
    ) -> None:
        self._component = component
        self._clock = clock
        self._timebase = timebase
        self._history = AttitudeHistory(fresh)
        self._autopilot = TrustedAutopilot(system_id)
        self._asked_height = height == "autopilot"
        self._height = None if height == "autopilot" else height
        self._risen = -math.inf  # when the height was told last [s]
        self._looked = clock.now()
        self._count = 0  # reports since then
        component.subscribe(self.on_packet)

    def attitude(self, time: float) -> Attitude:
        """Return the attitude at ``time`` [s]; not known, and the frame of the mount, when no report is fresh."""
        stale = self._asked_height and abs(time - self._risen) > HEIGHT_TIMEOUT_S
        return replace(self._history.at(time), height=None if stale else self._height)

    def on_packet(self, received: Received) -> None:
        """Take in what any link has heard."""
        packet = received.packet
        if not self._autopilot.sent(received):
            return
        if packet.name == "HEARTBEAT":
            self._look(received.link)
        elif self._asked_height and (height := vehicle.height_of(packet.message)) is not None:
            self._height, self._risen = height - MOUTH, self._clock.now()
        else:
            said = vehicle.read(packet.message)
            if isinstance(said, VehicleAttitude):
                self._count += 1
                self._history.note(self._time(said), said)

    def _look(self, link: str) -> None:
        """Ask for attitudes when fewer than wanted have come since the last look."""
        now = self._clock.now()
        if self._count < ENOUGH * (now - self._looked):
            self._component.send(vehicle.message_interval(self._autopilot.system_id, ATTITUDE, WANTED), link)
        if self._asked_height and now - self._risen > 1 / POSITION_WANTED + MAX_DELAY_S:
            self._component.send(vehicle.message_interval(self._autopilot.system_id, POSITION, POSITION_WANTED), link)
        self._looked, self._count = now, 0

    def _time(self, report: VehicleAttitude) -> float:
        now, told = self._clock.now(), self._timebase.local(report.boot)
        return told if told is not None and now - MAX_DELAY_S <= told <= now else now


def _between(one: VehicleAttitude, other: VehicleAttitude, share: float, age: float) -> Attitude:
    yaw, pitch, roll = (
        wrap(a + share * wrap(b - a))
        for a, b in ((one.yaw, other.yaw), (one.pitch, other.pitch), (one.roll, other.roll))
    )
    return Attitude(yaw, pitch, roll, age=age)


@dataclass(frozen=True, slots=True)
class FixedMount:
    """A base that never turns; ``yaw`` [rad] in the earth frame and ``height`` [m], None when nobody knows them."""

    yaw: float | None = None
    height: float | None = None

    def attitude(self, time: float) -> Attitude:
        """Return the fixed attitude, flagged unknown (mount frame) when no yaw was given."""
        return Attitude(yaw=self.yaw or 0.0, known=self.yaw is not None, height=self.height)


def fixed_mount(config: Config) -> FixedMount:
    """Make the mount of a base that never turns; a compass turns clockwise, we do not.

    A vehicle that is itself the joint is turned on the earth: its joint angle is 0 to the north.
    """
    yaw = 0.0 if config.actuator.kind == VEHICLE_YAW else config.mount.yaw_deg
    height = config.mount.height_m
    return FixedMount(None if yaw is None else -math.radians(yaw), None if height == "autopilot" else height)


def mount_of(config: Config, clock: Clock, links: Router, timebase: Timebase) -> Mount:
    """Make the mount that a configuration describes; it tells the speeds of rotors where their noise is learnt.

    Raises
    ------
    ConfigError
        When the attitude is wanted from an autopilot and no link leads to one.
    """
    flies = any(link.role == "autopilot" for link in links.status())
    if config.mount.source != "fixed" and not flies:
        raise ConfigError('mount.source = "autopilot": expected a [[links]] table with role = "autopilot", got none')
    asked, told, address = config.mount, config.telemetry.system_id, config.telemetry.component_id
    mount: Mount = fixed_mount(config)
    if asked.source != "fixed":
        component = links.component(address)
        mount = AutopilotMount(component, clock, timebase, fresh=asked.fresh_s, system_id=told, height=asked.height_m)
    if config.ego_noise.learn and flies:
        return WithRotors(mount, RotorSpeeds(links.component(address), clock, told))
    return mount
