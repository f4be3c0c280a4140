"""What is kept of a simulated mission while it goes on: its events, the mixture, and a session to replay."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ross_payload.atomic_files import make_private
from ross_payload.audio.audio_files import WavWriter
from ross_payload.errors import ConfigError, OutputError, refused_as
from ross_payload.events import Event, SourcesEstimated, TurnStarted
from ross_payload.health import RecordingState
from ross_payload.interfaces import Clock, Input
from ross_payload.mavlink import Router
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.recorder import DRAIN_PERIOD_S, Recorder
from ross_payload.sessions.session_store import SessionStore
from ross_sim.sitl.report import EventLog


@dataclass(slots=True)
class Collector:
    """Follows a mission: keeps its events, writes the mixture and the event log as they happen."""

    mixture: WavWriter | None
    log: EventLog = field(default_factory=EventLog)

    def on_input(self, hop: Input) -> None:
        """Write one hop of the mixture."""
        if self.mixture is not None:
            self.mixture.write(hop.block.samples)

    def on_event(self, event: Event, hop: Input) -> None:
        """Keep the event, and the frame of its angles."""
        self.log.events.append(event)
        if isinstance(event, (SourcesEstimated, TurnStarted)):
            self.log.earth = hop.pointing.earth


@contextmanager
def recorded(folder: Path | None, begin: Beginning, clock: Clock, links: Router) -> Iterator[Recorder | None]:
    """Give a recorder that makes one session in ``folder``, from the first Input to the end; None for no folder.

    Raises
    ------
    ConfigError
        When the folder cannot be made.
    OutputError
        At the end, when the disk did not take everything.
    """
    if folder is None:
        yield None
        return
    with refused_as(ConfigError, f"--record {folder}: cannot be made"):
        make_private(folder)
    config = begin.config
    limits = config.recording.model_copy(update={"always": True})
    first = iter([begin])
    with Recorder(SessionStore(folder), limits, lambda: next(first, None)) as recorder:
        component = links.component(config.telemetry.component_id)
        component.tap(lambda frame: recorder.on_frame(round(clock.now() * 1e6), frame))
        with drained(clock)(recorder):
            yield recorder
    status = recorder.status()
    if status.state in (RecordingState.FULL, RecordingState.BROKEN):
        raise OutputError(f"--record {folder}: the recording is not whole: {status.reason}")


def drained(clock: Clock) -> Callable[[Recorder], AbstractContextManager[None]]:
    """Return what has a recorder write in simulated time."""

    @contextmanager
    def draining(recorder: Recorder) -> Iterator[None]:
        cancel = clock.every(DRAIN_PERIOD_S, recorder.drain)
        yield
        cancel()

    return draining
