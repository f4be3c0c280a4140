"""One stream of live listening as plain JSON, and in words: what it carries, to whom, and how it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from ross_payload.ground.model.health import ACT, GOOD
from ross_payload.transport.link_url import host_and_port
from ross_protocols.angle_text import rounded
from ross_protocols.mavlink.field_converters import compass
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport

SILENCE_DB = -120.0  # re full scale; what a payload reports of samples that are all zero
CODECS = {Codec.L16: "L16", Codec.OPUS: "opus", Codec.PCM: "PCM", Codec.FLAC: "FLAC"}


def stream_row(stream: StreamReport) -> dict[str, Any]:
    """Return one stream; degrees clockwise, ``level`` as in `health` and ``words`` for whoever must act."""
    return {
        "number": stream.number,
        "sink": stream.sink,
        "on": stream.on,
        "selection": selection_name(stream.selection),
        "source": stream.source,
        "azimuth": None if stream.azimuth is None else compass(stream.azimuth),
        "group": stream.group,
        "separated": stream.separated,
        "codec": CODECS.get(stream.codec),
        "rate": stream.rate,
        "address": stream.address,
        "port": stream.port,
        "listeners": stream.listeners,
        "records": stream.records,
        "gain_db": stream.gain,
        "muted": stream.muted,
        "level_db": stream.level,
        "delay": stream.delay,
        "lost": stream.lost,
        "packets_lost": stream.packets_lost,
        "fault": stream.fault,
        "detail": stream.detail,
        "level": ACT if stream.fault else GOOD,
        "whom": whom(stream),
        "place": place(stream),
        "words": words(stream),
    }


def selection_name(selection: int) -> str:
    """Return what a stream carries, in one word; a number that the dialect does not have stays one.

    >>> selection_name(2), selection_name(9)
    ('target', '9')
    """
    return Selection(selection).name.lower() if selection in list(Selection) else str(selection)


def whom(stream: StreamReport) -> str:
    """Return whom a stream carries."""
    if stream.selection == Selection.SOURCE and stream.source is not None:
        return f"source {stream.source}"
    if stream.selection == Selection.AZIMUTH and stream.azimuth is not None:
        return f"azimuth {rounded(compass(stream.azimuth), 0):.0f} deg"
    return selection_name(stream.selection)


def place(stream: StreamReport) -> str:
    """Return where a stream goes.

    >>> place(StreamReport(0, 0, 1, "rtp", Selection.TARGET, False, 48000, address="127.0.0.1", port=5004))
    '127.0.0.1:5004'
    >>> place(StreamReport(0, 0, 1, "tcp", Selection.TARGET, False, 48000, address="::1", port=5010))
    '[::1]:5010'
    """
    return host_and_port(stream.address, stream.port) if stream.port else stream.address or stream.sink


def instead(stream: StreamReport) -> str:
    """Return what is heard while nobody's voice can be separated: the mixture or silence; empty while a voice is heard.

    >>> instead(StreamReport(0, 0, 1, "rtp", Selection.TARGET, False, 48000, on=True, detail="turning"))
    'the mixture'
    """
    if not stream.on or stream.separated or stream.muted or not stream.detail or stream.selection == Selection.MIXTURE:
        return ""
    return "silence" if stream.level is not None and stream.level <= SILENCE_DB else "the mixture"


def words(stream: StreamReport) -> str:
    """Return how a stream is, in words."""
    if stream.fault:
        return f"fault: {stream.detail or 'see the events'}"
    if not stream.on:
        return ", ".join(filter(None, ("off", stream.detail)))
    heard = "recording" if stream.records else "on" if stream.listeners is None else _listeners(stream.listeners)
    other = instead(stream)
    why = f"{other}: {stream.detail}" if other else stream.detail
    return ", ".join(filter(None, (heard, "muted" if stream.muted else "", why)))


def _listeners(count: int) -> str:
    return f"{count} listener{'' if count == 1 else 's'}" if count else "no listener"


def changed(before: tuple[StreamReport, ...], after: tuple[StreamReport, ...]) -> Iterator[StreamReport]:
    """Yield the streams of which more than levels, delays and counts have changed."""
    known = {stream.number: lasting(stream) for stream in before}
    yield from (stream for stream in after if known.get(stream.number) != lasting(stream))


def lasting(stream: StreamReport) -> StreamReport:
    """Return a stream without what changes all the time."""
    return replace(
        stream, time_usec=0, count=0, level=None, delay=None, lost=0, packets_lost=None, azimuth=None, group=None,
        separated=False,
    )  # fmt: skip
