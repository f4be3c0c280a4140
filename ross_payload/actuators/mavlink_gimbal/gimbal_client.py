"""The driver as a client of a gimbal manager: whom it asks for control, when it gives it back, how it loses it.

It remembers what it has heard and says what is due; it sends nothing itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ross_payload.actuators.mavlink_gimbal.clock import SenderClock, Verdict
from ross_payload.actuators.mavlink_gimbal.port import Arrived
from ross_protocols import gimbal
from ross_protocols.codec import Packet
from ross_protocols.gimbal import Address, GimbalControl, GimbalTravel

AGAIN = 1.0  # [s] between two questions that were not answered
AGAIN_CONTROL = 0.3  # [s] between two requests for control, or to release it, that were not fulfilled
CONTROL_TIMEOUT_S = 2.0  # in which a manager must put us in control
RELEASES = 5  # times that control is released, until the manager says that it is
SILENT = 3.5  # [s] without a word of a manager after which it may have restarted; its heartbeat comes once a second
CLOCKED = ("ATTITUDE", "SYSTEM_TIME", "GIMBAL_MANAGER_STATUS")  # messages of a manager that show its clock
TAKE_AGAIN = "to take it back: home, or rearm and the next command"
WANTED = 50.0  # [Hz] of attitudes
ENOUGH = 30.0  # [Hz]: what flows at this rate is not asked for again
ACCEPTED, IN_PROGRESS = 0, 5  # MAV_RESULT
INQUIRIES = 3  # after who a gimbal behind a manager is: it need not tell
INFORMATION = "GIMBAL_DEVICE_INFORMATION"
ATTACHED = len(gimbal.COMPONENTS)  # device ids up to this one belong to the manager, above are component ids


@dataclass(slots=True)
class Asking:
    """When to ask again, and for attitudes only while too few come."""

    due: float = 0.0  # [s]
    since: float = -math.inf  # [s]
    reports: int = 0  # attitudes since then

    def is_due(self, now: float) -> bool:
        """Tell whether to ask at ``now`` [s]; the next time is a while later."""
        if now < self.due:
            return False
        self.due = now + AGAIN
        return True

    def too_few(self, now: float) -> bool:
        """Tell whether too few attitudes came since this was asked last."""
        few = self.reports < ENOUGH * (now - self.since)
        self.reports, self.since = 0, now
        return few


@dataclass(slots=True)
class Client:
    """A gimbal manager, mostly an autopilot, that points the gimbal for us while we are in control.

    Control is asked for when somebody wants the gimbal turned, and released afterwards. Once it is lost, to somebody
    else or because the manager has restarted, it is not asked for again before `claim` or the next `take`.
    """

    manager: Address
    device_id: int = 0  # 0: the first that it tells of
    travel: GimbalTravel | None = None
    device: Address | None = None  # whose attitudes are the gimbal's own
    primary: Address | None = None  # whom the manager names in control; None: not known
    us: Address = (0, 0)
    wanted: float | None = None  # since when we want control [s]; None: we do not
    had_control: bool = False  # since then
    refused: bool = False  # when we asked for control
    releases: int = 0  # so many times more may we say that we release control
    due_control: float = 0.0  # when to ask who is in control [s]
    asked: int = 0  # times, for attitudes
    inquired: int = 0  # times, who the gimbal is
    identity: str = ""  # of the gimbal, as it tells
    heard_at: float = -math.inf  # when the manager was heard last [s]
    asking: Asking = field(default_factory=Asking)
    clock: SenderClock = field(default_factory=SenderClock)  # the manager's

    def heard(self, arrived: Arrived, now: float) -> None:
        """Take in what the manager says."""
        packet, self.us = arrived.packet, arrived.us
        sender, said = (packet.system_id, packet.component_id), packet.message
        if packet.name == INFORMATION and (sender == self.device or self._passed_on(sender, said)):
            self.identity = gimbal.maker(said)
        if sender != self.manager:
            return
        if self._has_restarted(packet, now):
            self._forget_control()
        self.heard_at = now
        if packet.name == "COMMAND_ACK" and said.command == gimbal.CONFIGURE and _is_for(self.us, said):
            self.refused = said.result not in (ACCEPTED, IN_PROGRESS)
        match gimbal.read(packet.message):
            case GimbalTravel() as travel if self.device_id in (0, travel.device_id):
                self._learn(travel, now)
            case GimbalControl() as control if self.travel and control.device_id == self.device_id:
                self.primary = control.primary
                self.had_control = self.had_control or self.ready
                self.releases = self.releases if self.primary == self.us else 0

    def _learn(self, travel: GimbalTravel, now: float) -> None:
        if self.travel is None:
            self.asking.due = self.due_control = now
        self.travel, self.device_id = travel, travel.device_id
        component = gimbal.COMPONENTS[travel.device_id - 1] if 1 <= travel.device_id <= ATTACHED else travel.device_id
        self.device = self.manager[0], component

    def _has_restarted(self, packet: Packet, now: float) -> bool:
        """Tell by the manager's clock whether it has booted; after a long silence it may have."""
        silent = now - self.heard_at > SILENT
        clocked = packet.name in CLOCKED
        return (clocked and self.clock.judge(packet.message.time_boot_ms / 1e3, now) is Verdict.RESTARTED) or silent

    def _forget_control(self) -> None:
        self.primary, self.releases, self.asked, self.due_control = None, 0, 0, 0.0

    def due(self, now: float) -> list[Any]:
        """Return what to ask at ``now`` [s]: who you are, who is in control, attitudes."""
        questions = self._about_control(now)
        if not self.asking.is_due(now):
            return questions
        if self.travel is None:
            return [gimbal.request(self.manager, gimbal.MANAGER_INFORMATION)]
        if self.asking.too_few(now):
            questions += [gimbal.interval(address, gimbal.DEVICE_ATTITUDE, WANTED) for address in self._reporters()]
            self.asked += 1
        if not self.identity and self.inquired < INQUIRIES:
            questions += [gimbal.request(address, gimbal.DEVICE_INFORMATION) for address in self._reporters()]
            self.inquired += 1
        return questions

    def _about_control(self, now: float) -> list[Any]:
        """Ask for control, or release it, until the manager says that it is so; then ask now and then whether it is."""
        if self.travel is None or now < self.due_control:
            return []
        status = gimbal.request(self.manager, gimbal.MANAGER_STATUS)  # it need not tell in a stream
        if self.wanted is not None and not self.trouble():
            self.due_control = now + (AGAIN if self.ready else AGAIN_CONTROL)
            return [status] if self.ready else [gimbal.configure(self.manager, self.device_id, gimbal.ITSELF), status]
        if self.wanted is None and self.releases:
            self.releases, self.due_control = self.releases - 1, now + AGAIN_CONTROL
            return [gimbal.configure(self.manager, self.device_id, gimbal.NOBODY), status]
        return []

    def _passed_on(self, sender: Address, said: Any) -> bool:
        """Tell whether the manager tells of the gimbal."""
        return sender == self.manager and self.travel is not None and said.gimbal_device_id == self.device_id

    def _reporters(self) -> list[Address]:
        """Whom to ask for what the gimbal tells: the device itself, and its manager when that was not enough."""
        if self.device is None:
            return [self.manager]
        return [self.device, self.manager] if self.asked else [self.device]

    def point(self, angle: float) -> Any:
        """Return the message that points at a joint angle [rad]."""
        return gimbal.point_manager(self.manager, self.device_id, angle)

    def take(self, now: float) -> None:
        """Ask for control from ``now`` [s] on, unless we want it already."""
        if self.wanted is None:
            self.claim(now)

    def claim(self, now: float) -> None:
        """Ask for control from ``now`` [s] on, also when it was lost."""
        if self.wanted is None or not self.ready:
            self.primary, self.wanted, self.due_control = None, now, 0.0
            self.had_control = self.refused = False

    def release(self) -> None:
        """Give control back, if it is ours or may be."""
        if self.wanted is not None:
            self.releases = RELEASES if self.primary in (self.us, None) and not self.trouble() else 0
            self.wanted, self.had_control, self.due_control = None, False, 0.0

    def leave(self) -> list[Any]:
        """Return what gives control back."""
        self.release()
        return [gimbal.configure(self.manager, self.device_id, gimbal.NOBODY)] if self.releases and self.travel else []

    @property
    def idle(self) -> bool:
        """Whether others may turn the gimbal."""
        return self.wanted is None

    @property
    def ready(self) -> bool:
        """Whether it points where we say."""
        return self.wanted is not None and self.primary == self.us != (0, 0)

    def relays(self, device_id: int) -> bool:
        """Tell whether an attitude with this device id, sent by the manager, is the gimbal's."""
        return device_id == self.device_id

    def missing(self, now: float) -> str:
        """Say at ``now`` [s] what it has not told in time; empty when nothing is missing."""
        if self.travel is None:
            return f"the gimbal manager, {name_of(self.manager)}, gives no information"
        if self.wanted is None or self.ready:
            return ""
        if self.refused:
            return f"the gimbal manager, {name_of(self.manager)}, denies control"
        late = now - self.wanted > CONTROL_TIMEOUT_S
        return f"the gimbal manager, {name_of(self.manager)}, does not grant control" if late else ""

    def trouble(self) -> str:
        """Say how control was lost, if it was."""
        if self.wanted is None or not self.had_control or self.primary == self.us:
            return ""
        if self.primary is None:
            return f"the gimbal manager, {name_of(self.manager)}, has restarted: control is lost; {TAKE_AGAIN}"
        if self.primary == (0, 0):
            return f"the gimbal manager, {name_of(self.manager)}, no longer reports us in control; {TAKE_AGAIN}"
        return f"{name_of(self.primary)} has taken control of the gimbal; {TAKE_AGAIN}"


def _is_for(us: Address, said: Any) -> bool:
    return (said.target_system, said.target_component) in (us, (0, 0))


def name_of(address: Address) -> str:
    """Return an address in words."""
    return f"component {address[1]} of system {address[0]}"
