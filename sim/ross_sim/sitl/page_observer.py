"""``--page``: the ground's page beside a mission; all that it knows of the payload came by MAVLink, over UDP.

The payload speaks to it over a link of its own, with a telemetry of its own. So the mission, its log and its report
are the same, byte for byte, whether somebody looks on or not.
"""

from __future__ import annotations

import socket
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ross_payload.actuators.guard import Guard
from ross_payload.audio.audio_health import HealthMonitor
from ross_payload.clock import SystemClock
from ross_payload.config import Config, Link
from ross_payload.config.parameter_store import Parameters
from ross_payload.errors import ConfigError
from ross_payload.events import Answer, Answered, Event
from ross_payload.ground.errors import GroundError
from ross_payload.ground.web.command import PORT
from ross_payload.interfaces import Input
from ross_payload.listening.observers import Listening
from ross_payload.mavlink import Router
from ross_payload.notify import on_signal
from ross_payload.orders import Cancel, Order, Stop
from ross_payload.plugins import install_line
from ross_payload.service.runner import Observer
from ross_payload.sessions.catalog import Catalog
from ross_payload.sessions.session_store import SessionStore
from ross_payload.telemetry.component import Telemetry
from ross_sim.clock import SimClock

if TYPE_CHECKING:
    from ross_payload.ground.web.page_state import PageState
    from ross_payload.ground.web.server import Served

SCRIPTED = "this mission runs by itself and accepts only stop and cancel; for all commands: ross sitl --serve --page"
POLL = 0.010  # [s]
WAITING = 0.2  # [s]
ENDED = "The simulation has ended."


class PageObserver:
    """The page: ``url`` for browsers, ``link`` where the payload speaks, ``state`` of the page where there is one."""

    def __init__(self, url: str, link: str, state: PageState | None = None) -> None:
        self.url = url
        self.link = link
        self._state = state
        self.stopped = False  # from the page

    @contextmanager
    def aboard(
        self, config: Config, clock: SimClock, actuator: Guard, order: Callable[[Order], None], voices: Listening
    ) -> Iterator[list[Observer]]:
        """Speak to the page; give what has to observe the mission.

        ``order`` takes a stop to the runner, ``voices`` what the page asks to hear.
        """

        def stop(wanted: Order) -> None:
            self.stopped = True
            order(wanted)

        system = config.telemetry.system_id or 1
        with ExitStack() as stack:
            links = stack.enter_context(Router.open([Link(url=self.link)], clock, system_id=system))
            stack.callback(clock.every(POLL, links.poll))
            monitor, gate = HealthMonitor(config), OrderGate(stop)
            settings = stack.enter_context(Fixed(config))
            telemetry = stack.enter_context(
                Telemetry(
                    config,
                    clock,
                    links,
                    actuator=actuator,
                    give=gate.give,
                    parameters=settings,
                    health=monitor.health,
                    listening=voices,
                    descriptions=voices.descriptions,
                )
            )
            gate.answer = telemetry.on_event
            with voices:
                yield [monitor, telemetry, gate, voices]

    def tell(self, pace: str) -> None:
        """Have the page say how fast simulated time goes; empty: as the clock."""
        if self._state is not None:
            self._state.pace = pace

    def linger(self, flown: bool, *, aside: bool) -> None:
        """Say what the page is good for now, and wait for Ctrl-C or SIGTERM.

        Parameters
        ----------
        flown
            There is a log of the mission.
        aside
            Say it on the error output.
        """
        if self._state is not None:
            self._state.over = ENDED
        ended: list[bool] = []
        clock = SystemClock()
        with on_signal(lambda _: ended.append(True)):
            good = f"replays the mission: {self.url}#/flights" if flown else f"shows how it ended: {self.url}"
            click.echo(f"the page {good} (Ctrl-C ends it)", err=aside)
            while not ended:
                clock.sleep(WAITING)


class OrderGate:
    """Passes on what ends a scripted mission, and refuses the rest in words."""

    def __init__(self, stop: Callable[[Order], None]) -> None:
        self.answer: Callable[[Event, Input], None] = lambda event, hop: None
        self._stop = stop
        self._unanswered: list[Order] = []

    def give(self, order: Order) -> None:
        """Take an order."""
        if isinstance(order, (Stop, Cancel)):
            self._stop(order)
        if not isinstance(order, Stop):
            self._unanswered.append(order)

    def on_input(self, hop: Input) -> None:
        """Answer what came since the last hop."""
        for order in self._unanswered:
            answer, why = (Answer.ACCEPTED, "") if isinstance(order, Cancel) else (Answer.REFUSED, SCRIPTED)
            self.answer(Answered(hop.block.time, order.number, answer, why), hop)
        self._unanswered.clear()

    def on_event(self, event: Event, hop: Input) -> None:
        """What the mission says is no order."""


class Fixed(Parameters):
    """The settings of a scripted mission: they can be read."""

    def set(self, name: str, value: float) -> None:
        """Refuse.

        Raises
        ------
        ConfigError
            Always.
        """
        raise ConfigError(f"{name}: {SCRIPTED}")


@contextmanager
def page_observer(folder: Path | None, recordings: Path | None = None) -> Iterator[PageObserver]:
    """Serve the page; it plays the flights in ``folder``, too, and offers the sessions in ``recordings``.

    Raises
    ------
    click.UsageError
        When what the page needs is not installed.
    """
    port = free_port()
    catalog = None if recordings is None else Catalog(SessionStore(recordings))
    with _served([f"udpin:127.0.0.1:{port}"], folder, catalog) as served:
        yield PageObserver(served.url, f"udpout:127.0.0.1:{port}", served.state)


@contextmanager
def _served(urls: list[str], folder: Path | None, recordings: Catalog | None) -> Iterator[Served]:
    try:
        from ross_payload.ground.web.app import in_background  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        if error.name != "aiohttp":
            raise
        raise click.UsageError(f"--page needs aiohttp: {install_line('ground')}") from error
    with ExitStack() as stack:
        try:
            served = stack.enter_context(in_background(urls, port=PORT, flights=folder, recordings=recordings))
        except GroundError:  # somebody else has the port
            served = stack.enter_context(in_background(urls, flights=folder, recordings=recordings))
        yield served


def free_port() -> int:
    """Return a UDP port that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
