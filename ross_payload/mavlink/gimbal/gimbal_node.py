"""The component that is a gimbal: a device, and in mode ``standalone`` its manager, too.

`GimbalComponent` is the gimbal on the links: what it sends regularly and on request, which commands and set-points are
for it. `Gimbal` observes the mission: `on_input` and `on_event` are called on the mission's thread and only leave
things where the pump finds them; `poll` runs on the pump and does all the rest. Nothing here moves anything: set-points
become orders, which the mission obeys when it can, through the runner and the guard.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, Self

from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import Event
from ross_payload.interfaces import Actuator, Clock, Input, Mount
from ross_payload.mavlink.command_server import ACCEPTED, CommandServer, Handler, Verdict
from ross_payload.mavlink.component import Received
from ross_payload.mavlink.gimbal.control_arbiter import AWAY, UNCHANGED, ControlArbiter
from ross_payload.mavlink.gimbal.device_state import DeviceState
from ross_payload.mavlink.gimbal.roles import Make, Managed, Manager, Role
from ross_payload.mavlink.message_board import Board, Rank, Sampled
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.mavlink.message_scheduler import BEAT, MessageScheduler
from ross_payload.mavlink.router import Router
from ross_payload.orders import Order
from ross_payload.transport.async_task import drained
from ross_protocols.mavlink.commands import Command, Result
from ross_protocols.mavlink.gimbal_device import (
    FAULTS,
    PITCHYAW,
    Pose,
    attitude_status,
    commanded,
    device_information,
    flags_of,
    heartbeat,
    set_point_of,
)
from ross_protocols.mavlink.gimbal_messages import (
    COMPONENTS,
    CONFIGURE,
    DEVICE_ATTITUDE,
    DEVICE_INFORMATION,
    MANAGER_STATUS,
)

PERIOD = 0.020  # [s] between two polls
LISTENING = 1.5  # [s] for other gimbals, before we speak as one
HEARTBEAT_PERIOD_S, ATTITUDE_PERIOD_S = 1.0, 0.1
SHARE = 1 / 3  # of the budget of a link that the messages may take, beside the heartbeat
RANKS = {BEAT: Rank.HEARTBEAT, DEVICE_ATTITUDE: Rank.GIMBAL_ATTITUDE, MANAGER_STATUS: Rank.GIMBAL_MANAGER}
log = logging.getLogger(__name__)


class GimbalComponent:
    """One component, in one of the two roles.

    Parameters
    ----------
    device, arbiter
        What turns, and who is obeyed.
    role
        What the mode adds to a device.
    """

    def __init__(
        self,
        clock: Clock,
        links: Router,
        component_id: int,
        *,
        device: DeviceState,
        arbiter: ControlArbiter,
        role: Role,
    ) -> None:
        self._clock = clock
        self._device = device
        self._arbiter = arbiter
        self._role = role
        self._component = links.component(component_id)
        self._device_ids = 0, role.device_id, component_id
        number = role.device_id
        streams: dict[int, tuple[Make, float]] = {
            BEAT: (lambda boot: heartbeat(well=not self._pose().failures & FAULTS), HEARTBEAT_PERIOD_S),
            DEVICE_ATTITUDE: (lambda boot: attitude_status(boot, number, self._pose()), ATTITUDE_PERIOD_S),
        }
        streams |= role.streams(lambda: flags_of(self._pose()))
        board = Board()
        for message_id, (make, _) in streams.items():
            board.put(RANKS[message_id], [Sampled(message_id, self._timed(make))])
        periods = {message_id: period for message_id, (_, period) in streams.items()}
        self._scheduler = MessageScheduler(board, links, self._component, periods, share=SHARE)
        made = {DEVICE_INFORMATION: lambda boot: device_information(boot, number, device.axis())}
        on_request = {message_id: self._timed(make) for message_id, make in (made | role.made(device.axis)).items()}
        handlers: dict[int, Handler] = {**MessageRequests(self._component, self._scheduler, on_request).handlers}
        if role.is_manager:
            handlers |= {PITCHYAW: self._point, CONFIGURE: self._configure}
        self._server = CommandServer(self._component, handlers)
        self._component.subscribe(self._on_setpoint, *role.numbers)

    def tick(self, now: float) -> None:
        """Send what is due at ``now`` [s]."""
        self._server.tick(now)
        self._scheduler.flow(now)

    def _on_setpoint(self, received: Received) -> None:
        """Take a message with a set-point."""
        asked = set_point_of(received.packet.message)
        if asked is not None and asked.target.includes(self._component.id) and asked.device_id in self._device_ids:
            self._role.on_setpoint(asked.aim, received)

    def _point(self, command: Command, received: Received, now: float) -> Verdict:
        aim = commanded(command)
        if aim is None or command.numbers[6] not in self._device_ids:
            return Verdict(Result.DENIED)
        return self._arbiter.point(aim, received.packet.sender, self._clock.now())

    def _configure(self, command: Command, received: Received, now: float) -> Verdict:
        numbers, sender = command.numbers[:4], received.packet.sender
        if command.numbers[6] not in self._device_ids:
            return Verdict(Result.DENIED)
        try:
            control = self._arbiter.control.configured(numbers, sender)
        except ConfigError as error:
            return Verdict(Result.DENIED, str(error))
        self._arbiter.configure(control, sender, taken=numbers[0] not in (UNCHANGED, AWAY))
        return ACCEPTED

    def _pose(self) -> Pose:
        return self._device.pose(self._clock.now(), self._arbiter.aim, self._role.failures)

    def _timed(self, make: Make) -> Callable[[], Any]:
        return lambda: make(round(self._clock.now() * 1e3) % 2**32)


class Gimbal:
    """Observes a mission and speaks for what it turns. A context manager; the links belong to who opened them.

    Parameters
    ----------
    config
        Its [gimbal] mode is not "off".
    actuator
        What turns, in its guard.
    mount
        Where the base points.
    give
        Hands an order to the runner.
    tap
        Is told every frame that is sent.

    Raises
    ------
    ConfigError
        When an autopilot shall be the manager and no link leads to one.
    """

    def __init__(
        self,
        config: Config,
        clock: Clock,
        links: Router,
        actuator: Actuator,
        mount: Mount,
        *,
        give: Callable[[Order], None],
        tap: Callable[[bytes], None] = lambda frame: None,
    ) -> None:
        if config.gimbal.mode == "device" and not any(link.role == "autopilot" for link in links.status()):
            raise ConfigError('gimbal.mode = "device": expected a link with role "autopilot", got none')
        self._config = config
        self._tap = tap
        self._clock = clock
        self._links = links
        self._device = DeviceState(config, actuator, mount)
        payload = links.component(config.telemetry.component_id)
        self._arbiter = ControlArbiter(self._device, give, lambda: payload.id)
        self._component: GimbalComponent | None = None
        self._events: SimpleQueue[Event] = SimpleQueue()
        self._taken: set[int] = set()  # component ids of others
        self._since: float | None = None  # when we knew our system id [s]
        payload.subscribe(self._meet, BEAT)

    # ------------------------------------------------------------------------------------- from any thread

    def on_input(self, hop: Input) -> None:
        """Keep what was heard last."""
        self._device.on_input(hop)

    def on_event(self, event: Event, hop: Input) -> None:
        """Leave what the mission has just said to the pump."""
        self._events.put(event)

    # ------------------------------------------------------------------------------------- on the pump

    def poll(self) -> None:
        """Take in what was left here, and say what is due."""
        now = self._clock.now()
        for event in drained(self._events):
            self._arbiter.on_event(event)
        if self._component is None:
            self._appear(now)
        else:
            self._arbiter.tick(now)
            self._component.tick(now)

    def __enter__(self) -> Self:
        """Begin to listen for other gimbals."""
        self._cancel = self._clock.every(PERIOD, self.poll)
        return self

    def __exit__(self, *error: object) -> None:
        """Fall silent."""
        self._cancel()

    def _meet(self, received: Received) -> None:
        """Notice other gimbals of our vehicle."""
        packet = received.packet
        if packet.system_id == self._links.system_id:
            self._taken.add(packet.component_id)

    def _appear(self, now: float) -> None:
        """Choose a component id when others have had the time to be heard, and begin to speak."""
        if not self._links.system_id:
            return
        self._since = now if self._since is None else self._since
        if now - self._since < LISTENING:
            return
        number = self._config.gimbal.component_id or self._free()
        self._component = GimbalComponent(
            self._clock, self._links, number, device=self._device, arbiter=self._arbiter, role=self._role()
        )
        self._links.component(number).tap(self._tap)
        log.info("gimbal: component %d, %s", number, self._config.gimbal.mode)

    def _free(self) -> int:
        """Return the first component id of a gimbal that nobody has, the last one when all are taken."""
        taken = {self._config.telemetry.component_id, *self._taken}
        return next((number for number in COMPONENTS if number not in taken), COMPONENTS[-1])

    def _role(self) -> Role:
        if self._config.gimbal.mode == "standalone":
            return Manager(self._arbiter, self._clock)
        return Managed(self._arbiter, self._clock, lambda: self._links.system_id)
