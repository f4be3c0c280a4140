"""The driver as a client of a gimbal manager: whom it asks for control, when it gives it back, how it loses it.

It remembers what it has heard and says what is due; it sends nothing itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ross_payload.actuators.mavlink_gimbal.component_port import ReceivedPacket
from ross_payload.actuators.mavlink_gimbal.sender_clock import SenderClock, Verdict
from ross_protocols.mavlink import gimbal_messages
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import NOBODY, ComponentId
from ross_protocols.mavlink.gimbal_messages import GimbalControl, GimbalTravel

QUERY_PERIOD_S = 1.0  # [s] between two questions that were not answered
CONTROL_PERIOD_S = 0.3  # [s] between two requests for control, or to release it, that were not fulfilled
CONTROL_TIMEOUT_S = 2.0  # in which a manager must put us in control
# [s] without a word of a manager after which it may have restarted; its heartbeat comes once a second
MANAGER_SILENCE_S = 3.5
# times that control is released, until the manager says that it is; a silence that is longer begins them anew
RELEASE_TRIES = math.ceil(MANAGER_SILENCE_S / CONTROL_PERIOD_S)
CLOCKED = ("ATTITUDE", "SYSTEM_TIME", "GIMBAL_MANAGER_STATUS")  # messages of a manager that show its clock
REGAIN_HINT = "to take it back: home, or rearm and the next command"
ATTITUDE_RATE_HZ = 50.0  # [Hz] of attitudes
MIN_ATTITUDE_RATE_HZ = 30.0  # [Hz]: what flows at this rate is not asked for again
ACCEPTED, IN_PROGRESS = 0, 5  # MAV_RESULT
IDENTITY_TRIES = 3  # after who a gimbal behind a manager is: it need not tell
INFORMATION = "GIMBAL_DEVICE_INFORMATION"
MAX_ATTACHED_ID = len(
    gimbal_messages.COMPONENTS
)  # device ids up to this one belong to the manager, above are component ids


@dataclass(slots=True)
class QueryTimer:
    """When to ask again, and for attitudes only while too few come."""

    due: float = 0.0  # [s]
    since: float = -math.inf  # [s]
    reports: int = 0  # attitudes since then

    def is_due(self, now: float) -> bool:
        """Tell whether to ask at ``now`` [s]; the next time is a while later."""
        if now < self.due:
            return False
        self.due = now + QUERY_PERIOD_S
        return True

    def too_few(self, now: float) -> bool:
        """Tell whether too few attitudes came since this was asked last."""
        few = self.reports < MIN_ATTITUDE_RATE_HZ * (now - self.since)
        self.reports, self.since = 0, now
        return few


@dataclass(slots=True)
class GimbalManagerClient:
    """A gimbal manager, mostly an autopilot, that points the gimbal for us while we are in control.

    Control is asked for when somebody wants the gimbal turned, and released afterwards. Once it is lost, to somebody
    else or because the manager has restarted, it is not asked for again before `claim_control` or the next
    `want_control`.
    """

    manager: ComponentId
    device_id: int = 0  # 0: the first that it tells of
    travel: GimbalTravel | None = None
    device: ComponentId | None = None  # whose attitudes are the gimbal's own
    primary: ComponentId | None = None  # whom the manager names in control; None: not known
    us: ComponentId = NOBODY
    wanted: float | None = None  # since when we want control [s]; None: we do not
    had_control: bool = False  # since then
    may_have_control: bool = False  # it was asked for, or we were named, and nobody else since
    refused: bool = False  # when we asked for control
    releases: int = 0  # so many times more may we say that we release control
    due_control: float = 0.0  # when to ask who is in control [s]
    attitude_queries: int = 0  # times, for attitudes
    identity_queries: int = 0  # times, who the gimbal is
    identity: str = ""  # of the gimbal, as it tells
    heard_at: float = -math.inf  # when the manager was heard last [s]
    read_at: float = -math.inf  # when somebody has read last what arrives [s]
    queries: QueryTimer = field(default_factory=QueryTimer)
    clock: SenderClock = field(default_factory=SenderClock)  # the manager's

    def on_packet(self, received: ReceivedPacket, now: float) -> None:
        """Take in what the manager says."""
        packet, self.us = received.packet, received.us
        sender, message = packet.sender, packet.message
        if packet.name == INFORMATION and (sender == self.device or self._passed_on(sender, message)):
            self.identity = gimbal_messages.maker(message)
        if sender != self.manager:
            return
        if self._has_restarted(packet, now):
            self.releases = RELEASE_TRIES if self.idle and self.may_have_control else 0
            self.primary, self.attitude_queries, self.due_control = None, 0, 0.0
        self.heard_at = now
        if packet.name == "COMMAND_ACK" and message.command == gimbal_messages.CONFIGURE and _is_for(self.us, message):
            self.refused = message.result not in (ACCEPTED, IN_PROGRESS)
        match gimbal_messages.read(packet.message):
            case GimbalTravel() as travel if self.device_id in (0, travel.device_id):
                self._learn(travel, now)
            case GimbalControl() as control if self.travel and control.device_id == self.device_id:
                self._on_control(control.primary)

    def _on_control(self, primary: ComponentId) -> None:
        """Take in who is in control; if that was not known, and we are, with no task, an earlier one left it so."""
        before, self.primary = self.primary, primary
        self.had_control = self.had_control or self.ready
        self.may_have_control = primary == self.us != NOBODY
        if not self.may_have_control:
            self.releases = 0
        elif self.idle and before is None:
            self.releases = RELEASE_TRIES

    def _learn(self, travel: GimbalTravel, now: float) -> None:
        if self.travel is None:
            self.queries.due = self.due_control = now
        self.travel, self.device_id = travel, travel.device_id
        component = (
            gimbal_messages.COMPONENTS[travel.device_id - 1]
            if 1 <= travel.device_id <= MAX_ATTACHED_ID
            else travel.device_id
        )
        self.device = ComponentId(self.manager.system, component)

    def _has_restarted(self, packet: Packet, now: float) -> bool:
        """Tell by the manager's clock whether it has booted; after a long silence that was listened to it may have."""
        silent = self.read_at - self.heard_at > MANAGER_SILENCE_S
        clocked = packet.name in CLOCKED
        return (clocked and self.clock.judge(packet.message.time_boot_ms / 1e3, now) is Verdict.RESTARTED) or silent

    def due(self, now: float) -> list[Any]:
        """Return what to ask at ``now`` [s]: who you are, who is in control, attitudes."""
        questions = self._about_control(now)
        if not self.queries.is_due(now):
            return questions
        if self.travel is None:
            return [gimbal_messages.request(self.manager, gimbal_messages.MANAGER_INFORMATION)]
        if self.queries.too_few(now):
            questions += [
                gimbal_messages.interval(address, gimbal_messages.DEVICE_ATTITUDE, ATTITUDE_RATE_HZ)
                for address in self._reporters()
            ]
            self.attitude_queries += 1
        if not self.identity and self.identity_queries < IDENTITY_TRIES:
            questions += [
                gimbal_messages.request(address, gimbal_messages.DEVICE_INFORMATION) for address in self._reporters()
            ]
            self.identity_queries += 1
        return questions

    def _about_control(self, now: float) -> list[Any]:
        """Ask for control, or release it, until the manager says that it is so; then ask now and then whether it is."""
        if self.travel is None or now < self.due_control:
            return []
        status = gimbal_messages.request(self.manager, gimbal_messages.MANAGER_STATUS)  # it need not tell in a stream
        if self.wanted is not None and not self.trouble():
            self.due_control = now + (QUERY_PERIOD_S if self.ready else CONTROL_PERIOD_S)
            return (
                [status]
                if self.ready
                else [gimbal_messages.configure(self.manager, self.device_id, gimbal_messages.ITSELF), status]
            )
        if self.wanted is None and self.releases:
            self.releases, self.due_control = self.releases - 1, now + CONTROL_PERIOD_S
            return [gimbal_messages.configure(self.manager, self.device_id, gimbal_messages.NOBODY), status]
        return []

    def _passed_on(self, sender: ComponentId, message: Any) -> bool:
        """Tell whether the manager tells of the gimbal."""
        return sender == self.manager and self.travel is not None and message.gimbal_device_id == self.device_id

    def _reporters(self) -> list[ComponentId]:
        """Whom to ask for what the gimbal tells: the device itself, and its manager when that was not enough."""
        if self.device is None:
            return [self.manager]
        return [self.device, self.manager] if self.attitude_queries else [self.device]

    def point(self, angle: float) -> Any:
        """Return the message that points at a joint angle [rad]."""
        return gimbal_messages.point_manager(self.manager, self.device_id, angle)

    def want_control(self, now: float) -> None:
        """Ask for control from ``now`` [s] on, unless we want it already."""
        if self.wanted is None:
            self.claim_control(now)

    def claim_control(self, now: float) -> None:
        """Ask for control from ``now`` [s] on, also when it was lost."""
        if self.wanted is None or not self.ready:
            self.primary, self.wanted, self.due_control = None, now, 0.0
            self.had_control, self.refused, self.may_have_control = False, False, True

    def release_control(self) -> None:
        """Give control back, if it is ours or may be."""
        if self.wanted is not None:
            self.releases = RELEASE_TRIES if self.may_have_control else 0
            self.wanted, self.had_control, self.due_control = None, False, 0.0

    def leave(self) -> list[Any]:
        """Return what gives control back."""
        self.release_control()
        return (
            [gimbal_messages.configure(self.manager, self.device_id, gimbal_messages.NOBODY)]
            if self.releases and self.travel
            else []
        )

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
            return f"the gimbal manager, {component_name(self.manager)}, gives no information"
        if self.wanted is None or self.ready:
            return ""
        if self.refused:
            return f"the gimbal manager, {component_name(self.manager)}, denies control"
        late = now - self.wanted > CONTROL_TIMEOUT_S
        return f"the gimbal manager, {component_name(self.manager)}, does not grant control" if late else ""

    def trouble(self) -> str:
        """Say how control was lost, if it was."""
        if self.wanted is None or not self.had_control or self.primary == self.us:
            return ""
        if self.primary is None:
            return f"the gimbal manager, {component_name(self.manager)}, has restarted: control is lost; {REGAIN_HINT}"
        if self.primary == (0, 0):
            return f"the gimbal manager, {component_name(self.manager)}, no longer reports us in control; {REGAIN_HINT}"
        return f"{component_name(self.primary)} has taken control of the gimbal; {REGAIN_HINT}"


def _is_for(us: ComponentId, message: Any) -> bool:
    return (message.target_system, message.target_component) in (us, (0, 0))


def component_name(address: ComponentId) -> str:
    """Return an address in words."""
    return f"component {address.component} of system {address.system}"
