"""The MAVLink component: what the mission says goes out to the ground, what the ground asks comes in.

`on_input` and `on_event` run on the mission's thread and only leave things where the pump finds them; `poll` runs on
the pump and does all the rest, so that a separation that computes for seconds delays no heartbeat. In simulated time
the same calls happen on one thread.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from queue import SimpleQueue
from typing import Protocol, Self

from ross_payload.clock import Every
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.events import Event
from ross_payload.health import AudioHealth, RecordingStatus
from ross_payload.interfaces import Actuator, Clock, Feedback, Input
from ross_payload.mavlink import Component, Received, Router
from ross_payload.mavlink.component_info import files
from ross_payload.mavlink.ftp_server import FtpServer
from ross_payload.mavlink.message_board import MESSAGE_IDS, Board, Rank
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.mavlink.message_scheduler import MessageScheduler, periods
from ross_payload.mavlink.mission_commands import MissionCommands, StopMemory, no_streams
from ross_payload.mavlink.param_server import ParamServer
from ross_payload.mavlink.recording_files import Recordings
from ross_payload.orders import Order
from ross_payload.streams import StreamOrder, StreamStatus
from ross_payload.telemetry import event_messages
from ross_payload.telemetry.health_report import HealthReport
from ross_payload.telemetry.reporter import Reporter
from ross_payload.telemetry.snapshot import Moment, Snapshot, information, standing
from ross_payload.telemetry.status_texts import OperatorTexts
from ross_payload.telemetry.stream_report import StreamReporter
from ross_payload.timebase import Timebase
from ross_payload.transport.async_task import drained
from ross_payload.transport.tlog import TlogRecorder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.computer import Computer
from ross_protocols.mavlink.stream_values import description_file
from ross_protocols.mavlink.values import DIALECT_VERSION, Information, Severity

PERIOD = 0.020  # [s] between two polls
OBSERVING = 0.1  # [s] between two looks at the array, when nothing is to be sent
LOOKING = 1.0  # [s] between two looks at the payload itself
COMPLAINING = 60.0  # [s] between two words about a signing time that locks peers out
MIRRORING = 0.1  # [s] between two looks into the mirrors
FLUSHING = 1.0  # [s] at most, until the pump has sent what was said last
STRANGERS = 16  # that are remembered
log = logging.getLogger(__name__)


def no_recorder(on: bool) -> str:
    """Refuse to record."""
    return "this payload has no recorder"


class Recorder(Protocol):
    """Records sessions."""

    def record(self, on: bool) -> str:
        """Begin or end; return '' or why not."""

    def status(self) -> RecordingStatus:
        """Tell how the recording is."""


class Listening(Protocol):
    """Lets others listen, live. Both methods are called on the pump and do not wait."""

    def order(self, order: StreamOrder) -> str:
        """Start, change or end a stream; return '' or why not."""

    def streams(self) -> tuple[StreamStatus, ...]:
        """Tell how every stream is, also those that have ended, by number."""


class Telemetry:
    """Observes a mission and speaks for it. A context manager; the links belong to who opened them.

    Parameters
    ----------
    tlog
        File for everything that is sent; None: no file.
    actuator
        What turns; None: only what is heard tells the joint angle.
    give
        Hands an order to the runner; None: nobody orders anything.
    parameters, changed
        What is in force and may be set in flight (None: the configuration, for good), and who is told of a change.
    recorder, health, computer
        Tell how the recording, the microphones and the computer are; None: nothing is said of them.
    listening
        Lets others listen, live; None: nobody can.
    descriptions
        Tells the session description (SDP, RFC 8866) of every stream that has one, by its number: they are offered
        over MAVLink FTP as ``stream-<number>.sdp``.
    timebase
        Tells the time; None: time is since the boot.
    recordings
        Are offered over MAVLink FTP; None: they are not.
    latch
        Tells when a stop is on the disk, which is acknowledged then; None: nothing outlives this process.
    sought
        A voice is enrolled from the beginning, and scores say how much others sound like it.

    Raises
    ------
    ConfigError
        When the log cannot be made.
    """

    def __init__(
        self,
        config: Config,
        clock: Clock,
        links: Router,
        tlog: Path | None = None,
        actuator: Actuator | None = None,
        *,
        give: Callable[[Order], None] | None = None,
        parameters: Parameters | None = None,
        changed: Callable[[str, float], None] = lambda name, value: None,
        recorder: Recorder | None = None,
        health: Callable[[], AudioHealth] | None = None,
        computer: Callable[[], Computer] | None = None,
        listening: Listening | None = None,
        descriptions: Callable[[], Mapping[int, str]] = dict,
        timebase: Timebase | None = None,
        recordings: Recordings | None = None,
        latch: StopMemory | None = None,
        sought: bool = True,
    ) -> None:
        self._config = config
        self._clock = clock
        self._links = links
        self._actuator = actuator
        self._parameters = parameters
        self._open_loop = actuator is not None and actuator.capabilities.feedback is Feedback.MODEL
        self._timebase = timebase or Timebase(clock)
        self._events: SimpleQueue[tuple[Event, Input]] = SimpleQueue()
        self._latest: Input | None = None
        self._strangers: set[ComponentId] = set()
        self._twin: int | None = None
        self._other_autopilot: int | None = None
        self._trouble = ""  # of the signed links
        self._observing, self._looking, self._mirroring = Every(OBSERVING), Every(LOOKING), Every(MIRRORING)
        self._complaining = Every(COMPLAINING)
        self._board = Board()
        component = links.component(config.telemetry.component_id)
        self._scheduler = MessageScheduler(self._board, links, component, periods(config.telemetry))
        self._send_text = OperatorTexts(self._scheduler.queue_texts, clock.now).send
        self._reporter = Reporter(self._board, self._send_text, sought=sought)
        taping = None if recorder is None else recorder.status
        self._health_report = HealthReport(self._board, self._send_text, health, taping, computer)
        self._streams = StreamReporter(self._board, self._send_text, tuple if listening is None else listening.streams)
        stream = no_streams if listening is None else listening.order
        self._commands = None if give is None else self._server(component, give, recorder, stream, latch)
        self._settings = (
            None if parameters is None else ParamServer(component, parameters, changed, self._send_text, links.rates)
        )
        self._files = None if give is None else self._file_server(component, recordings, descriptions)
        self._tlog = None if tlog is None else TlogRecorder(tlog)
        component.tap(self._record)
        component.subscribe(self._meet, MESSAGE_IDS[Information])

    def _server(
        self,
        component: Component,
        give: Callable[[Order], None],
        recorder: Recorder | None,
        stream: Callable[[StreamOrder], str],
        latch: StopMemory | None,
    ) -> MissionCommands:
        record = no_recorder if recorder is None else recorder.record
        requests = MessageRequests(component, self._scheduler)
        return MissionCommands(component, give, record, self._send_text, requests, stream=stream, latch=latch)

    def _file_server(
        self, component: Component, recordings: Recordings | None, descriptions: Callable[[], Mapping[int, str]]
    ) -> FtpServer:
        def passing() -> dict[str, bytes]:
            return {description_file(number): text.encode() for number, text in descriptions().items() if text}

        return FtpServer(component, files(), recordings, self._links.rates, passing, claim=self._links.claim)

    # ------------------------------------------------------------------------------------- from any thread

    def on_input(self, hop: Input) -> None:
        """Keep what was heard last."""
        self._latest = hop

    def on_event(self, event: Event, hop: Input) -> None:
        """Leave what the mission has just said to the pump."""
        self._events.put((event, hop))

    # ------------------------------------------------------------------------------------- on the pump

    def send_text(self, severity: Severity, text: str) -> None:
        """Tell an operator something."""
        self._send_text(severity, text)

    def poll(self) -> None:
        """Take in what was left here, and send what is due."""
        now = self._clock.now()
        for event, heard in drained(self._events):
            self._reporter.handle(event, self._snapshot(heard))
            if self._commands is not None:
                self._commands.on_event(event)
        for part in (self._commands, self._settings, self._files):
            if part is not None:
                part.tick(now)
        if self._observing.due(now) or not self._scheduler.quiet(now):
            self._reporter.observe(self._snapshot(self._latest))
            if self._looking.due(now):
                self._look(now)
            if self._mirroring.due(now):
                status, sources = self._reporter.status, self._reporter.sources
                numbers = event_messages.named(status, sources, self._health_report.health, now)
                self._board.put(Rank.MIRROR, [*numbers, event_messages.azimuths(status.time_usec, sources)])
                self._streams.look(self._timebase.usec(), earth=status.earth)
            self._scheduler.flow(now)

    def __enter__(self) -> Self:
        """Begin to speak."""
        self._cancel = self._clock.every(PERIOD, self.poll)
        return self

    def __exit__(self, *error: object) -> None:
        """Wait until the pump has sent what was said last, then close the log."""
        end = self._clock.now() + FLUSHING
        try:
            try:
                while not self._events.empty() and self._clock.now() < end:
                    self._clock.sleep(PERIOD)
            finally:
                self._cancel()  # two threads may not send at once
            if self._streams.look(self._timebase.usec(), earth=self._reporter.status.earth):  # they have ended
                self._scheduler.flow(self._clock.now())
        finally:
            if self._tlog is not None:
                self._tlog.close()

    def _meet(self, received: Received) -> None:
        """Notice another payload that speaks another version of our dialect; say it once."""
        told, who = received.packet.value, received.packet.sender
        if not isinstance(told, Information) or told.dialect_version == DIALECT_VERSION or who in self._strangers:
            return
        if len(self._strangers) < STRANGERS:
            self._strangers.add(who)
            versions = f"dialect {told.dialect_version}, expected {DIALECT_VERSION}"
            self._send_text(Severity.WARNING, f"payload {who[0]}/{who[1]}: {versions}")

    def _look(self, now: float) -> None:
        """Look at the payload itself."""
        config = self._in_force()
        self._scheduler.renew(periods(config.telemetry))
        twin = self._links.twin
        if twin is not None and self._twin is None:
            self._send_text(Severity.ERROR, f"another sender uses our component id {twin}: change one")
        self._twin = twin
        other = self._links.other_autopilot
        if other is not None and self._other_autopilot is None:
            text = f"autopilot ignored: its system id is {other}, not {self._links.system_id}"
            log.warning("%s", text)
            self._send_text(Severity.WARNING, text)
        self._other_autopilot = other
        if (ahead := self._links.signing_ahead) and self._complaining.due(now):
            self._send_text(Severity.WARNING, f"{ahead}: see the log")
        trouble = self._links.trouble
        if trouble and not self._trouble:
            self._send_text(Severity.CRITICAL, f"signed links will soon accept only a stop: {trouble}")
        elif self._trouble and not trouble:
            self._send_text(Severity.INFO, "signed links accept commands again")
        self._trouble = trouble
        capabilities = None if self._actuator is None else self._actuator.capabilities
        self._health_report.look(information(config, capabilities, self._timebase.usec()), self._links.status(), now)

    def _snapshot(self, hop: Input | None) -> Snapshot:
        state = None if self._actuator is None else self._actuator.state()
        moment = Moment(
            self._timebase.usec(),
            self._timebase.unix,
            self._in_force(),
            self._open_loop,
            streaming=self._streams.streaming,
            recording=self._streams.recording or self._health_report.recording,
        )
        return standing(hop, state, moment)

    def _in_force(self) -> Config:
        return self._config if self._parameters is None else self._parameters.config

    def _record(self, frame: bytes) -> None:
        if self._tlog is not None:
            self._tlog.write(self._timebase.usec(), frame)
