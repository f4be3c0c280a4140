"""The component that is a gimbal: a device, and in mode ``standalone`` its manager, too.

`on_input` and `on_event` are called on the mission's thread and only leave things where the pump finds them; `poll`
runs on the pump and does all the rest. Nothing here moves anything: set-points become orders, which the mission obeys
when it can, through the runner and the guard.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from queue import SimpleQueue
from typing import Self

from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import Event
from ross_payload.interfaces import Actuator, Clock, Input, Mount
from ross_payload.mavlink import Received, Router
from ross_payload.mavlink.gimbal.component import GimbalComponent
from ross_payload.mavlink.gimbal.control_arbiter import ControlArbiter
from ross_payload.mavlink.gimbal.device_state import DeviceState
from ross_payload.mavlink.gimbal.roles import Managed, Manager, Role
from ross_payload.mavlink.message_scheduler import BEAT
from ross_payload.orders import Order
from ross_payload.transport.async_task import drained
from ross_protocols.mavlink.gimbal_messages import COMPONENTS

PERIOD = 0.020  # [s] between two polls
LISTENING = 1.5  # [s] for other gimbals, before we speak as one

log = logging.getLogger(__name__)


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
