"""How live listening is: its streams on the board, and words when one starts, ends, fails or recovers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

from ross_payload.mavlink.message_board import Board, Rank
from ross_payload.streams import StreamStatus, What
from ross_payload.telemetry.status_texts import Line
from ross_payload.transport.link_url import host_and_port
from ross_protocols.angle_text import rounded
from ross_protocols.mavlink.field_converters import compass
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from ross_protocols.mavlink.values import Severity

OVER_A_NETWORK = ("rtp", "tcp")  # sinks that have an address
DETAIL_LENGTH = 24  # of the field
PLACE = re.compile(r"[\d/']")  # what names of files, devices and addresses have
QUOTED = re.compile(r"'[^']*'")
CODECS = {codec.name.lower(): codec for codec in Codec}


class StreamReporter:
    """Puts the streams on the board and says what changes; ``streams`` tells how they are."""

    def __init__(
        self, board: Board, send_text: Callable[[Severity, str], None], streams: Callable[[], tuple[StreamStatus, ...]]
    ) -> None:
        self._board = board
        self._send_text = send_text
        self._streams = streams
        self._reported: tuple[StreamStatus, ...] = ()

    @property
    def streaming(self) -> bool:
        """Whether what is heard leaves the payload: a stream is on that has, or may have, a listener."""
        return any(status.on and not status.keeps and status.listeners != 0 for status in self._reported)

    @property
    def recording(self) -> bool:
        """Whether what is heard stays on a disk."""
        return any(status.on and status.keeps for status in self._reported)

    def look(self, time_usec: int, *, earth: bool) -> bool:
        """Look at the streams; return whether more than numbers have changed: those are sent at once."""
        now = self._streams()
        changed = tuple(map(lasting, now)) != tuple(map(lasting, self._reported))
        (self._board.announce if changed else self._board.put)(Rank.STREAM, reports(now, time_usec, earth=earth))
        before = {status.number: status for status in self._reported}
        self._reported = now
        for status in now if changed else ():
            text = line(before.get(status.number), status)
            if text is not None:
                self._send_text(*text)
        return changed


def lasting(status: StreamStatus) -> StreamStatus:
    """Return a stream without what changes all the time."""
    return replace(
        status, level_db=None, delay=None, lost=0, packets_lost=None, azimuth=None, group=None, source=None,
    )  # fmt: skip


def reports(streams: Sequence[StreamStatus], time_usec: int, *, earth: bool) -> list[StreamReport]:
    """Return one value per stream; where a voice is not known to come from, the place that was ordered stands."""
    count = max((status.number + 1 for status in streams), default=0)
    return [
        StreamReport(
            time_usec=time_usec,
            number=status.number,
            count=count,
            sink=status.sink,
            selection=Selection[status.selection.what.name],
            earth=earth,
            rate=status.rate,
            on=status.on,
            source=status.selection.source if status.source is None else status.source,
            azimuth=status.selection.azimuth if status.azimuth is None else status.azimuth,
            group=status.group,
            codec=CODECS.get(status.codec.lower(), Codec.OTHER),
            address=status.address,
            port=status.port,
            listeners=status.listeners,
            gain=status.gain_db,
            level=status.level_db,
            delay=status.delay,
            lost=status.lost,
            packets_lost=status.packets_lost,
            detail=brief(status.fault or status.detail),
            fault=bool(status.fault),
            muted=status.muted,
            records=status.keeps,
            separated=status.separated,
        )
        for status in streams
    ]


def brief(text: str, most: int = DETAIL_LENGTH) -> str:
    """Return what of a text says most in so many characters: the cause, since place and kind have fields of their own.

    >>> brief("tcp:127.0.0.1:5010: cannot listen: Address already in use")
    'Address already in use'
    >>> brief("the sink hangs: what it does not take is lost")
    'the sink hangs'
    >>> brief("the sound output 'USB Headphones' was disconnected")
    '..was disconnected'
    """
    if len(text) <= most:
        return text
    clauses = text.partition(";")[0].split(": ")
    ends = (": ".join(clauses[first:]) for first in range(len(clauses)))
    others = (clause for clause in reversed(clauses[:-1]) if " " in clause and not PLACE.search(clause))
    fitting = next((each for each in (*ends, *others) if len(each) <= most), None)
    if fitting is not None:
        return fitting
    words = QUOTED.sub("", clauses[-1]).split()
    while len(words) > 1 and len(" ".join(words)) > most - 2:
        del words[0]
    return f"..{' '.join(words)}"[:most]


def line(before: StreamStatus | None, now: StreamStatus) -> Line | None:
    """Return what to tell an operator about a stream; None: nothing has changed that matters."""
    name = f"stream {now.number}"
    if now.fault and (before is None or before.fault != now.fault):
        return Severity.WARNING, f"{name} fault: {now.fault}"
    if now.on and now.sink in OVER_A_NETWORK and not now.address:
        return None  # its address comes when it is open
    if now.on and (before is None or not before.on or whom(before) != whom(now) or way(before) != way(now)):
        return Severity.NOTICE, f"{name} on: {whom(now)} to {way(now)}"
    if before is not None and before.on and not now.on:
        return Severity.NOTICE, ": ".join(filter(None, (f"{name} off", now.detail)))
    if before is not None and before.fault and not now.fault:
        return Severity.NOTICE, f"{name} recovered"
    return None


def whom(status: StreamStatus) -> str:
    """Return what a stream is to carry; degrees as on a compass.

    >>> from ross_payload.streams import Selection
    >>> whom(StreamStatus(0, "rtp", Selection(What.SOURCE, source=2), on=True, rate=16000))
    'source 2'
    """
    selection = status.selection
    if selection.what is What.SOURCE:
        return f"source {selection.source}"
    if selection.what is What.AZIMUTH and selection.azimuth is not None:
        return f"azimuth {rounded(compass(selection.azimuth), 0):.0f} deg"
    return selection.what.value


def way(status: StreamStatus) -> str:
    """Return where a stream goes, and how."""
    place = host_and_port(status.address, status.port) if status.port else status.address or status.sink
    return f"{place} ({', '.join(filter(None, (status.sink, status.codec)))})"
