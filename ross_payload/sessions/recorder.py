"""Records a mission while it runs: a queue between the mission and a disk that may be slow, full or gone.

`on_input`, `on_event` and what `noting` hears belong to the mission's thread, `on_frame` to the pump, `on_voice` to
live listening, and they only queue; `drain` does the writing, on a thread of its own (`in_background`) or, in simulated
time, as a periodic call. `record` and `status` may be called from any thread.
"""

from __future__ import annotations

import errno
import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Self

from ross_payload import config
from ross_payload.errors import ConfigError, RossError, refused_as
from ross_payload.events import Event
from ross_payload.health import RecordingState, RecordingStatus
from ross_payload.interfaces import Clip, Input, Real, Score, VoiceBlock, VoicePrint
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.session_store import GB, SessionStore
from ross_payload.sessions.session_writer import SessionWriter
from ross_payload.transport.async_task import drained

BACKLOG_S = 30.0  # [s] of audio that wait for the disk: then it is too slow
DRAIN_PERIOD_S = 0.2  # [s] between two looks at the queue
TIDY_PERIOD_S = 5.0  # [s] of audio between two looks at what is left of the disk
IDLE_TIDY_PERIOD_S = 3600.0  # [s] between two looks for what is too old, while nothing is recorded
UNDATED_TIDY_PERIOD_S = 60.0  # [s] the same, while nobody has told the date: at the start nobody has
SLOW = f"the disk is too slow: {BACKLOG_S:.0f} s of audio wait for it"
SHARED = (
    "recording.folder: another payload records into %s: max_gb and max_days hold for the sessions of both, the oldest "
    "of either are deleted; give each a folder of its own"
)
KEPT_OLD = (
    "%d sessions look older than recording.max_days = %g by the clock of this computer, and stay as long as nobody "
    "confirms its date, neither NTP nor an autopilot; max_gb holds, and ross sessions delete"
)
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)

Begin = Callable[[], Beginning | None]  # None while a task runs


@dataclass(slots=True, eq=False)
class OngoingRecording:
    """One recording, as the mission's thread and the disk's both know it."""

    hop: float  # of an Input [s]
    inputs: int = 0  # queued, counted on the mission's thread
    written: int = 0  # taken from the queue, counted on the disk's thread
    writer: SessionWriter | None = None  # of the disk's thread alone
    tidied: float = 0.0  # [s] of audio, when the store was looked after last
    over: bool = False  # set on the disk's thread: nothing more is written
    failed: bool = False  # and nobody wants another one


log = logging.getLogger(__name__)


class Recorder:
    """Watches a mission and records it when asked to. A context manager.

    Parameters
    ----------
    store : SessionStore
        Where the sessions lie.
    limits : config.Recording
        How much and for how long; with ``always`` the recording begins by itself.
    begin : Begin
        Tells what a replay must know before the next Input; None while a task runs, which cannot be replayed from
        its middle. Called on the mission's thread and by `record`.
    stamp : Callable[[], str]
        The time as in ``20261121T145421Z``, empty when the clock is not set.
    today : Callable[[], str], optional
        The same, by which sessions are too old, empty also while it is not sure; then the log says once that what
        looks too old stays. Default: ``stamp``.
    """

    def __init__(
        self,
        store: SessionStore,
        limits: config.Recording,
        begin: Begin,
        stamp: Callable[[], str] = lambda: "",
        today: Callable[[], str] | None = None,
    ) -> None:
        self._store = store
        self._limits = limits
        self._begin = begin
        self._stamp = stamp
        self._today = today or stamp
        self._queue: SimpleQueue[Callable[[], None]] = SimpleQueue()
        self._wanted = limits.always
        self._recording: OngoingRecording | None = None  # what the mission's thread fills
        self._disk: OngoingRecording | None = None  # what the disk's thread writes
        self._status = RecordingStatus()
        self._tidied_at: float | None = None  # on the clock of the Inputs [s], while nothing was recorded
        self._untidy: RecordingStatus | None = None  # what was told of the latest look that failed meanwhile
        self._dated = today is None  # the date was known at the latest look
        self._told_why = today is None  # it is in the log that too old sessions stay; a simulation has no date
        self._before = self._status  # and what was told before it

    def record(self, on: bool) -> str:
        """Begin or end a recording with the next hop; return '' or why not."""
        recording = self._recording
        over = recording is None or recording.over
        if on and over and self._begin() is None:
            return "a task is running, and a recording begins between tasks: cancel it or wait"
        if recording is not None and over:  # the mission's thread, which may compute, has not seen its end yet
            recording.failed = False
        self._wanted = on
        return ""

    def status(self) -> RecordingStatus:
        """Tell how the recording is."""
        return self._status

    def recording(self) -> bool:
        """Tell whether Inputs are recorded at present; from any thread."""
        recording = self._recording
        return recording is not None and not recording.over

    @property
    def folder(self) -> Path:
        """Where the sessions lie."""
        return self._store.folder

    # ------------------------------------------------------------------------------- on the mission's thread

    def on_input(self, hop: Input) -> None:
        """Queue one Input; a recording begins and ends here."""
        recording = self._recording
        if recording is not None and recording.over:
            self._recording, self._wanted = None, self._wanted and not recording.failed
        if self._wanted != (self._recording is not None):
            if self._recording is not None:
                self._put(self._recording, partial(self._end, reason="ended by order"))
                self._recording = None
            elif (begin := self._begin()) is not None:
                self._recording = OngoingRecording(begin.config.audio.hop_ms / 1000)
                self._put(self._recording, partial(self._start, begin=begin))
        if self._recording is None:
            self._tidy_now_and_then(hop.block.time)
            return
        self._recording.inputs += 1
        self._put(self._recording, partial(_write_input, hop=hop))
        if (self._recording.inputs - self._recording.written) * self._recording.hop > BACKLOG_S:
            self._status = replace(self._status, state=RecordingState.BROKEN, reason=SLOW)
            self._put(self._recording, partial(self._fail, state=RecordingState.BROKEN, reason=SLOW))
            self._recording, self._wanted = None, False

    def _tidy_now_and_then(self, now: float) -> None:
        """Have what is too old deleted, also by a payload that lives for months and records nothing."""
        self._tidied_at = now if self._tidied_at is None else self._tidied_at
        if now - self._tidied_at >= (IDLE_TIDY_PERIOD_S if self._dated else UNDATED_TIDY_PERIOD_S):
            self._tidied_at = now
            self._queue.put(self._tidy)

    def on_event(self, event: Event, hop: Input) -> None:
        """Queue an event, unless it answers an Input from before the recording."""
        if self._recording is not None and self._recording.inputs > 1:
            self._write(self._recording, lambda writer: writer.write_event(event))

    def noting(self, voiceprint: VoicePrint) -> VoicePrint:
        """Return a voice print whose answers are recorded, so that the same mission can be replayed without it."""
        return RecordingVoicePrint(voiceprint, self._scored)

    def _scored(self, score: Score) -> None:
        if self._recording is not None:
            number = self._recording.inputs
            self._write(self._recording, lambda writer: writer.write_score(number, score))

    # ------------------------------------------------------------------------------- on the thread that listens

    def on_voice(self, name: str, block: VoiceBlock) -> None:
        """Queue samples of a separated voice."""
        recording = self._recording
        if recording is not None:
            self._write(recording, lambda writer: writer.write_voice(name, block))

    # ---------------------------------------------------------------------------------------- on the pump

    def on_frame(self, time_usec: int, frame: bytes) -> None:
        """Queue a frame of telemetry as it went over the wire."""
        recording = self._recording
        if recording is not None:
            self._write(recording, lambda writer: writer.write_frame(time_usec, frame))

    # ------------------------------------------------------------------------------------- where it is written

    def drain(self) -> None:
        """Write what waits."""
        for write in drained(self._queue):
            write()

    def close(self) -> None:
        """End the recording and write the rest; idempotent."""
        self._recording, self._wanted = None, False
        self.drain()
        if self._disk is not None:
            self._guarded(self._disk, partial(self._end, reason="the program ended"))

    def __enter__(self) -> Self:
        """Delete what is too old."""
        self._tidy()
        return self

    def __exit__(self, *exception: object) -> None:
        """End the recording."""
        self.close()

    def _tidy(self) -> None:
        """Delete what is too old or too much while nothing is recorded."""
        try:
            self._tidied()
        except (OSError, RossError) as error:
            if self._status is not self._untidy:
                self._before = self._status
            self._status = self._untidy = replace(self._status, state=RecordingState.BROKEN, reason=_why(error))
        else:
            if self._status is self._untidy:  # of a recording that has failed it is told on
                self._status = self._before

    def _tidied(self, running: Path | None = None) -> str:
        """Delete what is too old or too much; return why ``running`` must stop, or ''."""
        today = self._today()
        self._dated = self._dated or bool(today)
        why = self._store.tidy(self._limits, running, today)
        if not today and not self._told_why:
            self._told_why = True
            if count := self._store.doubtful(self._limits):
                log.warning(KEPT_OLD, count, self._limits.max_days)
        return why

    def _put(self, recording: OngoingRecording, job: Callable[[OngoingRecording], None]) -> None:
        self._queue.put(partial(self._guarded, recording, job))

    def _write(self, recording: OngoingRecording, call: Callable[[SessionWriter], None]) -> None:
        self._put(recording, lambda recording: None if recording.writer is None else call(recording.writer))

    def _guarded(self, recording: OngoingRecording, job: Callable[[OngoingRecording], None]) -> None:
        """Do a job of a recording that is not over; what goes wrong with the disk ends it, and only it."""
        if recording.over:
            return
        try:
            job(recording)
            self._look_after(recording)
        except (OSError, RossError) as error:
            cause = error if isinstance(error, OSError) else error.__cause__
            full = isinstance(cause, OSError) and cause.errno in FULL
            self._fail(recording, RecordingState.FULL if full else RecordingState.BROKEN, _why(error))
        except Exception as error:  # the thread goes on, and what it is says why nothing is recorded any more
            log.exception("the recording has failed")
            self._fail(recording, RecordingState.BROKEN, f"{type(error).__name__}: {error}")

    def _start(self, recording: OngoingRecording, begin: Beginning) -> None:
        self._disk = recording
        stamp = self._stamp()
        with refused_as(ConfigError, f"recording.folder: {self._store.folder} cannot be written"):
            folder = self._store.add(stamp)
        self._status = RecordingStatus(RecordingState.ON, folder.name, path=str(folder.absolute()))
        try:
            if stamp and not self._today():
                self._store.doubt(folder)
            recording.writer = SessionWriter(folder, begin, stamp)
        except (OSError, RossError):
            self._store.discard(folder)
            raise
        recording.tidied = -TIDY_PERIOD_S
        if any(kept.running and kept.path != folder for kept in self._store.all()):
            log.warning(SHARED, self._store.folder)

    def _look_after(self, recording: OngoingRecording) -> None:
        writer = recording.writer
        if writer is None or recording.over:
            return
        if writer.over:  # what is wanted stays, so that another session begins between tasks
            self._end(recording, "the audio file is full")
        elif writer.seconds - recording.tidied >= TIDY_PERIOD_S:
            recording.tidied = writer.seconds
            why = self._tidied(writer.folder)
            self._status = replace(self._status, seconds=writer.seconds, free_gb=self._store.free() / GB)
            if why:
                self._fail(recording, RecordingState.FULL, why)
        else:
            self._status = replace(self._status, seconds=writer.seconds)

    def _end(self, recording: OngoingRecording, reason: str) -> None:
        recording.over, self._disk = True, None
        self._status = replace(self._status, state=RecordingState.OFF)
        if recording.writer is not None:
            recording.writer.finish(reason)

    def _fail(self, recording: OngoingRecording, state: RecordingState, reason: str) -> None:
        """Stop for a reason; what is on the disk stays, and the mission goes on."""
        recording.over, recording.failed, self._disk = True, True, None
        self._status = replace(self._status, state=state, reason=reason)
        if recording.writer is not None:
            _close(recording.writer, reason)


class RecordedVoice(AbstractContextManager["RecordedVoice"]):
    """An AudioSink that hands a voice to the recorder, which tells of itself what goes wrong."""

    fault = ""
    lost = 0

    def __init__(self, recorder: Recorder, name: str) -> None:
        self._recorder = recorder
        self._name = name

    def write(self, block: VoiceBlock) -> None:
        """Have samples recorded."""
        self._recorder.on_voice(self._name, block)

    def __exit__(self, *exception: object) -> None:
        """The recorder goes on."""


class RecordingVoicePrint:
    """A voice print that tells its answers."""

    def __init__(self, voiceprint: VoicePrint, on_score: Callable[[Score], None]) -> None:
        self._voiceprint = voiceprint
        self._on_score = on_score

    def score(self, voice: Real, rate: int) -> Score:
        """Score, and report the score."""
        return self._reported(self._voiceprint.score(voice, rate))

    def score_clips(self, clips: Sequence[Clip], rate: int) -> Score:
        """Score what was heard of one voice, and report the score."""
        return self._reported(self._voiceprint.score_clips(clips, rate))

    def _reported(self, score: Score) -> Score:
        self._on_score(score)
        return score


@contextmanager
def in_background(recorder: Recorder) -> Iterator[None]:
    """Write on a thread of its own: the mission must not wait for an SD card."""
    done = threading.Event()

    def work() -> None:
        while not done.wait(DRAIN_PERIOD_S):
            recorder.drain()

    thread = threading.Thread(target=work, name="recorder")
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _write_input(recording: OngoingRecording, hop: Input) -> None:
    recording.written += 1
    if recording.writer is not None:
        recording.writer.write_input(hop)


def _why(error: Exception) -> str:
    if isinstance(error, ConfigError):  # which names the folder
        return str(error)
    cause = error if isinstance(error, OSError) else error.__cause__
    return (cause.strerror if isinstance(cause, OSError) else None) or str(error)


def _close(writer: SessionWriter, reason: str) -> None:
    """Finish as far as a full disk allows."""
    try:
        writer.finish(reason)
    except (OSError, RossError):
        writer.close()
    except Exception:  # the thread goes on, to record again when that is asked for
        log.exception("the recording cannot be closed")
