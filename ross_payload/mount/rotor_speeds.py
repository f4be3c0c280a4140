"""How fast the rotors of the vehicle turn, as its autopilot tells over the link."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace

from ross_payload.interfaces import Attitude, Clock, Mount
from ross_payload.mavlink import Component, Received
from ross_payload.trusted_autopilot import TrustedAutopilot
from ross_protocols.mavlink import rotor_speeds, vehicle

WANTED = 10.0  # [Hz] of every message
SPEED_TIMEOUT_S = 1.0  # [s]: an older speed is not known
KEPT = 2000  # reports: more than a minute of three messages at 10 Hz
ASKED = (*rotor_speeds.TELEMETRY, rotor_speeds.STATUS, rotor_speeds.SENSORS)


class RotorSpeeds:
    """Speeds of the rotors, from what component 1 says about its speed controllers.

    `on_packet` belongs to the pump; `at` to anybody. What is told by the controllers counts before what sensors of
    speed tell. Reports are dated by their arrival: speeds change little while a message is on its way.

    Parameters
    ----------
    component
        Who asks, and where it is heard.
    clock
        Ours.
    system_id
        Of the vehicle; 0: that of the first autopilot.
    """

    def __init__(self, component: Component, clock: Clock, system_id: int = 0) -> None:
        self._component, self._clock, self._autopilot = component, clock, TrustedAutopilot(system_id)
        self._kept: tuple[list[float], list[dict[int, float]]] = ([], [])  # times [s], fresh speeds; only appended to
        self._latest: dict[int, tuple[float, float]] = {}  # time and speed by rotor
        self._controllers = float("-inf")  # when a controller was heard last [s]
        component.subscribe(self.on_packet)

    def at(self, time: float) -> tuple[float, ...]:
        """Return the speed [1/s] of every rotor at ``time`` [s]; 0: it stands, or nobody tells; (): none turns."""
        times, reports = self._kept
        count = len(times)
        after = bisect_right(times, time, 0, count)
        if after < count and (after == 0 or times[after] - time < time - times[after - 1]):
            after += 1  # the nearest
        if after == 0 or abs(time - times[after - 1]) > SPEED_TIMEOUT_S:
            return ()
        return rotor_speeds.merged(reports[after - 1])

    def on_packet(self, received: Received) -> None:
        """Take in what any link has heard."""
        packet = received.packet
        if not self._autopilot.sent(received):
            return
        now = self._clock.now()
        if packet.name == "HEARTBEAT":
            self._ask(received.link, now)
            return
        told = rotor_speeds.speeds_of(packet.message)
        if told is None or (packet.name == "RPM" and now - self._controllers < SPEED_TIMEOUT_S):
            return
        if packet.name != "RPM":
            self._controllers = now
        self._latest |= {number: (now, speed) for number, speed in told.items()}
        self._note(
            now, {number: speed for number, (when, speed) in self._latest.items() if now - when < SPEED_TIMEOUT_S}
        )

    def _ask(self, link: str, now: float) -> None:
        """Ask for all that an autopilot may know while nothing comes; what it does not know it refuses."""
        times, _ = self._kept
        if times and now - times[-1] < SPEED_TIMEOUT_S:
            return
        for message_id in ASKED:
            self._component.send(vehicle.message_interval(self._autopilot.system_id, message_id, WANTED), link)

    def _note(self, now: float, speeds: dict[int, float]) -> None:
        times, reports = self._kept
        if len(times) >= 2 * KEPT:  # others may be reading the old lists
            self._kept = times, reports = times[-KEPT:], reports[-KEPT:]
        reports.append(speeds)
        times.append(now)


@dataclass(frozen=True, slots=True)
class WithRotors:
    """A mount that also tells how fast the rotors of its vehicle turn."""

    mount: Mount
    rotors: RotorSpeeds

    def attitude(self, time: float) -> Attitude:
        """Return the attitude at ``time`` [s], with the speeds of the rotors."""
        return replace(self.mount.attitude(time), rotor_speeds=self.rotors.at(time))
