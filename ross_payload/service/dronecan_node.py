"""The payload's node on a DroneCAN bus, from the configuration: first the node alone, then what it says and answers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from ross_payload import __version__
from ross_payload.actuators.registry import checked_options
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.dronecan.allocator import Allocator
from ross_payload.dronecan.node import Identity, Node
from ross_payload.dronecan.parameter_service import ParameterService
from ross_payload.dronecan.persistence import PersistentIds
from ross_payload.dronecan.shared_bus import SharedBusPort
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Actuator, Clock, Port
from ross_payload.orders import Order, Set, Shutdown
from ross_payload.service.runner import POLL_PERIOD_S
from ross_payload.telemetry.dronecan_reporter import DronecanReport
from ross_payload.timebase import Timebase
from ross_protocols.dronecan.services import MAGIC, RestartRequest, RestartResponse
from ross_protocols.mavlink.values import Severity

NAME = "org.ross.payload"
FILE = "dronecan.json"  # in the state folder


@contextmanager
def node_on_bus(
    config: Config, clock: Clock, open_port: Callable[[str], Port], state: Path | None, rng: np.random.Generator
) -> Iterator[Aboard | None]:
    """Join the bus that the configuration names; None: it names none.

    Raises
    ------
    ConfigError
        When the URL is wrong, or a driver on the same bus has another node id.
    LinkError
        When the bus cannot be joined.
    """
    if not config.dronecan.port:
        yield None
        return
    check_one_id(config)
    with ExitStack() as stack:
        kept = stack.enter_context(PersistentIds(None if state is None else state / FILE, rng))
        port = open_port(config.dronecan.port)
        node = Node(identity(config, kept), port, rng, clock.now(), kept.had)
        stack.callback(node.close)
        if isinstance(port, SharedBusPort):
            port.bus.node = node
        stack.callback(clock.every(POLL_PERIOD_S, lambda: node.poll(clock.now())))
        yield Aboard(config, clock, node, kept)


def identity(config: Config, kept: PersistentIds) -> Identity:
    """Return who we are on the bus."""
    major, minor, *_ = (int(number) for number in re.findall(r"\d+", __version__))
    return Identity(NAME, kept.unique_id, config.dronecan.node_id, kept.node_id, (major, minor))


def check_one_id(config: Config) -> None:
    """One payload is one node on a bus.

    Raises
    ------
    ConfigError
        When the driver of a servo on the bus of our node has a node id of its own, or the servo has ours.
    """
    asked, options = config.dronecan, checked_options(config)
    if config.actuator.kind != "dronecan_servo" or options.port != asked.port:
        return
    if options.node_id == asked.node_id:
        raise ConfigError(
            f"actuator.options.node_id: expected the servo's own, got {asked.node_id}, which is that of [dronecan]"
        )
    own = options.own_node_id if "own_node_id" in options.model_fields_set else asked.node_id
    if own != asked.node_id:
        expected = f"expected {asked.node_id}, the node_id of [dronecan] on the same bus, or nothing"
        raise ConfigError(f"actuator.options.own_node_id: {expected}, got {own}")


class Aboard:
    """Our node on the bus, that does not yet say anything about the mission."""

    def __init__(self, config: Config, clock: Clock, node: Node, kept: PersistentIds) -> None:
        self._config = config
        self._clock = clock
        self._kept = kept
        self._trouble = ""
        self.node = node

    @contextmanager
    def speaking(
        self,
        parameters: Parameters,
        actuator: Actuator,
        timebase: Timebase,
        *,
        give: Callable[[Order], None],
        send_text: Callable[[Severity, str], None],
        restart: Callable[[], None] | None,
        sought: bool,
    ) -> Iterator[DronecanReport]:
        """Answer about parameters and restarts, give ids, and tell of the mission.

        Parameters
        ----------
        give
            Hands an order to the runner.
        send_text
            Tells an operator something.
        restart
            Sees to it that this program is started again when it has ended; None: nobody would.
        sought
            A voice is enrolled from the beginning.
        """
        asked = self._config.dronecan
        ParameterService(self.node, parameters, lambda name, value: give(Set(name, value)), may_set=asked.may_set)
        report = DronecanReport(self.node, actuator, timebase, lambda: parameters.config, sought=sought)
        again = restart if asked.may_restart else None
        self.node.serve(RestartRequest, lambda request: _restarted(request, report, give, again))
        allocator = Allocator(self.node, self._kept, self._clock.now()) if asked.allocator else None

        def poll() -> None:
            now = self._clock.now()
            report.poll(now)
            self._complain(send_text)
            if allocator is not None:
                allocator.poll(now)

        cancel = self._clock.every(POLL_PERIOD_S, poll)
        try:
            yield report
        finally:
            cancel()

    def _complain(self, send_text: Callable[[Severity, str], None]) -> None:
        """Tell an operator once what is wrong with the bus or our id: over the bus nobody would hear it."""
        before, self._trouble = self._trouble, self.node.trouble
        if self._trouble and self._trouble != before:
            send_text(Severity.WARNING, f"CAN: {self._trouble}")


def _restarted(
    request: RestartRequest, report: DronecanReport, give: Callable[[Order], None], again: Callable[[], None] | None
) -> RestartResponse:
    """Shut down in order, unless a task runs: what it has found would be lost, and whoever means it can cancel it."""
    if again is None or request.magic != MAGIC or not report.resting:
        return RestartResponse(False)
    again()
    give(Shutdown())
    return RestartResponse(True)
