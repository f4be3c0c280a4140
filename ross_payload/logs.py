"""The log: lines for people or for machines on standard error, with priorities where the journal reads them.

Modules log to the logger of their name; `logging_to` is what hangs the one handler, for as long as the command runs.
A record may carry ``extra={"fields": {...}}``: numbers and words that the JSON format keeps apart from the message.
"""

from __future__ import annotations

import json
import logging
import os
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from datetime import UTC, datetime
from enum import Enum
from typing import Any, TextIO

from ross_payload.bounded_files import printable
from ross_payload.events import Answer, Answered, Event, Separated, StateChanged, TurnStarted
from ross_payload.health import AudioHealth, AudioTrouble, RecordingState, RecordingStatus
from ross_payload.interfaces import Input
from ross_payload.json_values import named
from ross_payload.log_writer import LogWriter
from ross_payload.mavlink import LinkStatus
from ross_payload.telemetry.status_texts import line
from ross_payload.token_bucket import TokenBucket
from ross_protocols.angle_text import bearings, rotation
from ross_protocols.mavlink.values import Severity
from ross_protocols.mavlink.vehicle import AUTOPILOT

BURST = 5.0  # warnings of one kind that come through at once
REPEAT_PERIOD_S = 10.0  # [s] between them in the long run
KINDS = 256  # of warnings that are told apart
LOOKS = 10  # at a link to an autopilot, one in a second, until it is said that none is heard
PRIORITIES = ((logging.CRITICAL, 2), (logging.ERROR, 3), (logging.WARNING, 4), (logging.INFO, 6))  # else 7, debug
LEVELS = (
    (Severity.CRITICAL, logging.CRITICAL),
    (Severity.ERROR, logging.ERROR),
    (Severity.WARNING, logging.WARNING),
    (Severity.INFO, logging.INFO),
)  # of what the operator is told


@contextmanager
def logging_to(
    stream: TextIO, level: str, form: str, environment: Mapping[str, str] = os.environ
) -> Iterator[logging.Handler]:
    """Send every log line of ``level`` ("debug", "info"...) and above to a stream, in the format "text" or "json".

    Whoever logs does not wait for a stream that is a file.
    """
    journal = is_journal(stream, environment)
    handler = _handler(stream)
    handler.setFormatter(Json(journal) if form == "json" else Text(journal))
    handler.addFilter(Repeats())
    root, before = logging.getLogger(), logging.getLogger().level
    root.addHandler(handler)
    root.setLevel(level.upper())
    try:
        yield handler
    finally:
        root.setLevel(before)
        root.removeHandler(handler)
        handler.close()


def _handler(stream: TextIO) -> logging.Handler:
    try:
        return LogWriter(stream.fileno(), stream.encoding)
    except (OSError, ValueError, RuntimeError):  # no file behind it, or no thread left: then who logs waits
        return logging.StreamHandler(stream)


def is_journal(stream: TextIO, environment: Mapping[str, str]) -> bool:
    """Tell whether a stream ends in the journal: systemd says which device and inode do."""
    try:
        status = os.fstat(stream.fileno())
    except (OSError, ValueError):  # no file behind it
        return False
    return environment.get("JOURNAL_STREAM", "") == f"{status.st_dev}:{status.st_ino}"


def priority(level: int) -> int:
    """Return the syslog priority of a level of `logging`.

    >>> [priority(level) for level in (logging.ERROR, logging.WARNING, logging.INFO, logging.DEBUG)]
    [3, 4, 6, 7]
    """
    return next((number for least, number in PRIORITIES if level >= least), 7)


class Repeats(logging.Filter):
    """Holds back warnings and errors that say the same again and again; the next that passes tells how many.

    Two are of one kind when logger, level and text before its arguments are the same.
    """

    def __init__(self) -> None:
        super().__init__()
        self._kinds: OrderedDict[tuple[str, int, str], tuple[TokenBucket, int]] = OrderedDict()

    def filter(self, record: logging.LogRecord) -> bool:
        """Tell whether a record may pass; note in it how many before it did not."""
        if record.levelno < logging.WARNING:
            return True
        kind = (record.name, record.levelno, str(record.msg))
        bucket, held = self._kinds.pop(kind, (TokenBucket(BURST, 1 / REPEAT_PERIOD_S), 0))
        passes = bucket.spend(record.created)
        self._kinds[kind] = bucket, 0 if passes else held + 1
        if len(self._kinds) > KINDS:
            self._kinds.popitem(last=False)
        if passes and held:
            record.held = held
        return passes


class Text(logging.Formatter):
    """One line for people: time, level, logger, message; in the journal, which knows the time, a priority instead."""

    def __init__(self, journal: bool) -> None:
        super().__init__()
        self._journal = journal

    def format(self, record: logging.LogRecord) -> str:
        """Return the line, and those of a traceback behind it."""
        text = f"{record.levelname.lower():<7} {_short(record.name)}: {printable(_message(record))}"
        lines = [text, *(self.formatException(record.exc_info).splitlines() if record.exc_info else ())]
        if self._journal:
            return "\n".join(f"<{priority(record.levelno)}>{each}" for each in lines)
        return f"{_time(record)} " + "\n".join(lines)


class Json(logging.Formatter):
    """One JSON object per line: time, level, logger, message, fields, and the traceback of an exception."""

    def __init__(self, journal: bool) -> None:
        super().__init__()
        self._journal = journal

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        values: dict[str, Any] = {
            "time": _time(record),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": _message(record),
            "fields": {key: named(value) for key, value in getattr(record, "fields", {}).items()},
        }
        if record.exc_info:
            values["traceback"] = self.formatException(record.exc_info)
        prefix = f"<{priority(record.levelno)}>" if self._journal else ""
        return prefix + json.dumps(values, allow_nan=False)


class LogObserver:
    """Writes what the mission says into the log."""

    def __init__(self) -> None:
        self._log = logging.getLogger("ross_payload.mission")

    def on_input(self, hop: Input) -> None:
        """Hops are not worth a line."""

    def on_event(self, event: Event, hop: Input) -> None:
        """Write one line about an event; at level debug about every event."""
        level, text = words(event, earth=hop.pointing.earth)
        if self._log.isEnabledFor(level):
            self._log.log(level, text, extra={"fields": described(event)})


class Changes:
    """Writes into the log what no event tells: links that come and go, trouble of the microphones, the recorder.

    Parameters
    ----------
    links, audio, recorder
        Tell how they are; called by `poll`.
    """

    def __init__(
        self,
        links: Callable[[], Iterable[LinkStatus]],
        audio: Callable[[], AudioHealth],
        recorder: Callable[[], RecordingStatus],
    ) -> None:
        self._links = links
        self._audio = audio
        self._recorder = recorder
        self._links_before: dict[str, tuple[bool, int]] = {}
        self._unheard: dict[str, int] = {}  # by URL: looks in a row at a link to an autopilot that heard none
        self._trouble = AudioTrouble.NONE
        self._recording = RecordingState.OFF
        self._log = logging.getLogger("ross_payload.condition")

    def poll(self) -> None:
        """Look, and say what has changed since the last look."""
        for link in self._links():
            up, twins = self._links_before.get(link.url, (None, 0))
            if link.up is not up:
                what = f"link {link.url} is {'up' if link.up else 'down'}"
                self._log.log(
                    logging.INFO if link.up else logging.WARNING, what if link.up else _colon(what, link.error)
                )
            if link.twins > twins:
                self._log.warning("link %s: another sender uses our system and component id", link.url)
            self._links_before[link.url] = link.up, link.twins
            if link.role == "autopilot" and link.up:
                self._autopilot(link)
        self._microphones(self._audio())
        self._records(self._recorder())

    def _autopilot(self, link: LinkStatus) -> None:
        looks = self._unheard.get(link.url, 0)
        if any(component == AUTOPILOT for _, component in link.peers):
            if looks >= LOOKS:
                self._log.info("link %s: an autopilot is heard", link.url)
            self._unheard[link.url] = 0
            return
        self._unheard[link.url] = looks + 1
        if looks + 1 == LOOKS:
            self._log.warning("link %s: no autopilot is heard", link.url)

    def _microphones(self, now: AudioHealth) -> None:
        begun, over = now.trouble & ~self._trouble, self._trouble & ~now.trouble
        fields = {"level_db": list(now.level_db), "lost": now.lost, "reopened": now.reopened, "waiting_s": now.waiting}
        if begun:
            self._log.warning("microphones: %s", _names(begun), extra={"fields": fields})
        if over:
            self._log.info("microphones: no longer %s", _names(over), extra={"fields": fields})
        self._trouble = now.trouble

    def _records(self, now: RecordingStatus) -> None:
        if now.state is not self._recording:
            bad = now.state in (RecordingState.FULL, RecordingState.BROKEN)
            what = f"recording is {now.state} {now.name}".rstrip()
            self._log.log(logging.WARNING if bad else logging.INFO, _colon(what, now.reason))
        self._recording = now.state


def words(event: Event, *, earth: bool) -> tuple[int, str]:
    """Return the level and the message of an event: what the operator is told, or what only the log says.

    ``earth`` tells whether its headings count from north. Angles are written as `ross_protocols.angle_text` does.

    >>> words(TurnStarted(2.0, joint=0.7854, heading=1.5708, reason="rotation 1"), earth=True)
    (20, 'turning to heading 270.0 deg from north, joint 45.0 deg counter-clockwise: rotation 1')
    """
    match event:
        case StateChanged():
            return logging.INFO, _colon(event.state.name.lower().replace("_", " "), event.detail)
        case TurnStarted():
            where = f"heading {bearings([event.heading], earth=earth)}, joint {rotation(event.joint)}"
            return logging.INFO, f"turning to {where}: {event.reason}"
        case Separated():
            seconds = f"from {event.time:.1f} s at heading {bearings([event.heading], earth=earth)}"
            return logging.INFO, f"separated {len(event.groups)} groups {seconds} by {event.method}"
        case Answered():
            level = logging.WARNING if event.answer in (Answer.REFUSED, Answer.FAILED) else logging.INFO
            level = logging.DEBUG if event.answer is Answer.PROGRESS else level
            return level, _colon(f"order {event.order} {event.answer.name.lower()}", event.reason)
    said = line(event)
    if said is None:
        return logging.DEBUG, type(event).__name__
    severity, text = said
    return next((level for least, level in LEVELS if severity <= least), logging.DEBUG), text


def described(event: Event) -> dict[str, Any]:
    """Return the plain values of an event by name, in its own units; what is made of parts is left out.

    >>> described(Answered(1.5, order=7, answer=Answer.DONE))["order"]
    7
    """
    plain = {field.name: getattr(event, field.name) for field in fields(event)}
    kept = {name: value for name, value in plain.items() if isinstance(value, (str, int, float, Enum))}
    return {"event": type(event).__name__, **kept}


def _names(trouble: AudioTrouble) -> str:
    return ", ".join(each.name.lower().replace("_", " ") for each in AudioTrouble if each in trouble and each.name)


def _colon(what: str, why: str) -> str:
    return f"{what}: {why}" if why else what


def _message(record: logging.LogRecord) -> str:
    held = getattr(record, "held", 0)
    return record.getMessage() + (f" ({held} similar lines suppressed)" if held else "")


def _short(name: str) -> str:
    return name.removeprefix("ross_payload.")


def _time(record: logging.LogRecord) -> str:
    return datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
