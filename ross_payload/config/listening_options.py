"""The tables of live listening: listening, and one for each stream."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from ross_payload.config.table import Table
from ross_payload.streams import MAX_STREAMS, Selection, What

MOST_SOURCES = 16  # that a stream can be asked for
WHAT = "mixture, target, source N (0 to 15) or azimuth DEGREES"
_SELECTION = re.compile(
    r"(?P<what>mixture|target)|source (?P<source>\d{1,2})|azimuth (?P<azimuth>-?\d{1,3}(\.\d{1,6})?)"
)


class Stream(Table):
    """[[listening.streams]]: one voice, or the mixture, to one sink, live."""

    sink: Annotated[str, Field(min_length=1)]  # file, device, tcp, rtp, or one of a plug-in
    what: str = "target"  # mixture, target, `source N` (of the latest estimate, from 0) or `azimuth DEGREES`
    gain_db: Annotated[float, Field(ge=-60, le=60)] = 0.0  # added to what is heard; a limiter holds it below full scale
    muted: bool = False  # silence until a command says otherwise
    on: bool = True  # from the start; false: waits for a command
    options: dict[str, Any] = Field(default_factory=dict)  # a table of the sink's own

    @field_validator("what")
    @classmethod
    def _known(cls, text: str) -> str:
        selection_of(text)
        return text

    @property
    def selection(self) -> Selection:
        """What it carries."""
        return selection_of(self.what)


class Listening(Table):
    """[listening]: voices that leave the payload while they are heard; nothing does without a stream or an order."""

    separator: str = "auto"  # one that separates frame by frame: `auto`, `refined`, `gaussian`, `duet`
    otherwise: Literal["mixture", "silence"] = (
        "mixture"  # what a stream of a voice carries while no voice can be separated: exploring, turning, nobody known
    )
    latency_ms: Annotated[float, Field(ge=32, le=400)] = (
        100.0  # from the microphone to the sink, if the computer took no time; a shorter one costs quality
    )
    window_s: Annotated[float, Field(ge=1, le=30)] = 4.0  # of audio from which the covariances are learnt
    learn_s: Annotated[float, Field(ge=0.05, le=10)] = 0.25  # interval at which they are updated; doubled after 2 s
    sdp_port: Annotated[int, Field(ge=0, le=65535)] = 0  # TCP port of session descriptions over HTTP; 0: none
    sdp_address: Annotated[str, Field(min_length=1)] = "127.0.0.1"  # address of this computer to serve them on
    streams: Annotated[tuple[Stream, ...], Field(max_length=MAX_STREAMS)] = ()


def selection_of(text: str) -> Selection:
    """Read what a stream carries; an azimuth is counter-clockwise, in the frame of the mission's headings.

    >>> selection_of("source 2")
    Selection(what=<What.SOURCE: 'source'>, source=2, azimuth=None)

    Raises
    ------
    ValueError
        When it is anything else; says what was expected.
    """
    found = _SELECTION.fullmatch(text)
    if found is None or int(found["source"] or 0) >= MOST_SOURCES:
        raise ValueError(f"expected {WHAT}, got '{text[:80]}'")
    if found["source"]:
        return Selection(What.SOURCE, source=int(found["source"]))
    if found["azimuth"]:
        return Selection(What.AZIMUTH, azimuth=math.radians(float(found["azimuth"])))
    return Selection(What(found["what"]))


def selection_text(selection: Selection) -> str:
    """Write what a stream carries, as it stands in a configuration.

    >>> selection_text(selection_of("azimuth -40"))
    'azimuth -40'
    """
    if selection.what is What.SOURCE:
        return f"source {selection.source}"
    if selection.what is What.AZIMUTH:
        return f"azimuth {math.degrees(selection.azimuth or 0.0):.6g}"
    return selection.what.value
