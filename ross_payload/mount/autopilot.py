"""The mount that turns with a vehicle, as its autopilot tells."""

from __future__ import annotations

from ross_payload.interfaces import Attitude, Clock
from ross_payload.links import Component, Heard
from ross_payload.mount.history import AttitudeHistory
from ross_payload.timebase import Timebase
from ross_protocols import vehicle
from ross_protocols.vehicle import AUTOPILOT, VehicleAttitude

WANTED = 25.0  # [Hz] of ATTITUDE
ENOUGH = 18.0  # [Hz]: what flows at this rate is not asked for again
OLDEST = 1.0  # [s] that a report may have been on its way
ATTITUDE = 30  # message id


class AutopilotMount:
    """Where the base points, from ATTITUDE and AUTOPILOT_STATE_FOR_GIMBAL_DEVICE of component 1.

    Reports are dated by the autopilot's clock once a round trip has told how it lies to ours, before that by their
    arrival. The heartbeat of the autopilot tells when to look whether they flow, and when not, to ask for them.

    `heard` belongs to the pump; `attitude` to anybody.

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
    """

    def __init__(
        self, component: Component, clock: Clock, timebase: Timebase, *, fresh: float, system_id: int = 0
    ) -> None:
        self._component = component
        self._clock = clock
        self._timebase = timebase
        self._history = AttitudeHistory(fresh)
        self._system_id = system_id
        self._looked = clock.now()
        self._count = 0  # reports since then
        component.subscribe(self.heard)

    def attitude(self, time: float) -> Attitude:
        """Return the attitude at ``time`` [s]; not known, and the frame of the mount, when no report is fresh."""
        return self._history.at(time)

    def heard(self, heard: Heard) -> None:
        """Take in what any link has heard."""
        packet = heard.packet
        if heard.role != "autopilot" or packet.component_id != AUTOPILOT:
            return
        self._system_id = self._system_id or packet.system_id
        if packet.system_id != self._system_id:
            return
        if packet.name == "HEARTBEAT":
            self._look(heard.link)
        else:
            said = vehicle.read(packet.message)
            if isinstance(said, VehicleAttitude):
                self._count += 1
                self._history.note(self._time(said), said)

    def _look(self, link: str) -> None:
        """Ask for attitudes when fewer than wanted have come since the last look."""
        now = self._clock.now()
        if self._count < ENOUGH * (now - self._looked):
            self._component.send(vehicle.message_interval(self._system_id, ATTITUDE, WANTED), link)
        self._looked, self._count = now, 0

    def _time(self, report: VehicleAttitude) -> float:
        now, told = self._clock.now(), self._timebase.local(report.boot)
        return told if told is not None and now - OLDEST <= told <= now else now
