"""Orders of live listening and of enrolment, as values; wrong numbers are found out before anything is sent."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral

from ross_payload.ground.client.command_types import AZIMUTH, SOURCE, Order
from ross_payload.ground.client.events import AudioStream
from ross_protocols.mavlink import stream_command
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.stream_command import MUTED_DB, StreamCommand
from ross_protocols.mavlink.stream_values import Selection

GAIN_STEP_DB = 0.01  # below which two gains are one
SELECTIONS = {entry.name.lower(): entry for entry in Selection if entry is not Selection.NONE}


@dataclass(frozen=True, slots=True)
class Stream(Order):
    """Let somebody listen, live: start or change a stream of one voice, or of the mixture, to one address.

    What is None or empty stays as it is; of a new stream that is the target, no gain, and the codec of the payload's
    configuration. Without ``stream`` it is the one that goes to this address and port, or a new one.
    """

    number = ross.MAV_CMD_ROSS_STREAM
    name = "stream"
    task = False
    stream: int | None = None
    what: str | None = None  # "mixture", "target", "source" or "azimuth"
    source: int = 0  # of "source"
    azimuth: float = 0.0  # of "azimuth" [deg]
    address: str = ""  # IPv4, of one computer
    port: int = 0
    codec: str = ""  # "opus" or "L16"
    gain: float | None = None  # [dB]
    muted: bool | None = None  # False: at ``gain``, or at 0 dB

    def __post_init__(self) -> None:
        """Find out what cannot be meant before it is sent."""
        if self.stream is None and not self.address:
            raise ValueError("address: expected one for a new stream, got none")
        stream_command.command_of(self.numbers)

    @property
    def numbers(self) -> tuple[float, ...]:
        """As `stream_command` lays them out."""
        gain = MUTED_DB if self.muted else 0.0 if self.muted is False and self.gain is None else self.gain
        selection = None if self.what is None else SELECTIONS[self.what]
        command = StreamCommand(
            self.stream, selection, self.source, self.azimuth, gain, self.address, self.port, self.codec
        )
        return stream_command.numbers_of(command)

    @property
    def words(self) -> str:
        """Whom, and where to."""
        which = {"source": f" {self.source}", "azimuth": f" {self.azimuth:g} deg"}.get(self.what or "", "")
        what = f"{self.what}{which}" if self.what else "" if self.stream is not None else "target"
        name = "" if self.stream is None else str(self.stream)
        goes = f"to {self.address}:{self.port}" if self.address else ""
        level = "muted" if self.muted else "" if self.gain is None else f"at {self.gain:g} dB"
        return " ".join(filter(None, ("stream", name, what, goes, level)))

    def replaces(self, other: Order) -> bool:
        """Whether it is about the same stream."""
        same = isinstance(other, Stream) and (other.stream, other.address, other.port)
        return same == (self.stream, self.address, self.port)


def is_shown(order: Stream, stream: AudioStream) -> bool:
    """Tell whether an announced stream is on, and as it was ordered in all that the order says."""
    ordered = {
        "number": order.stream,
        "what": order.what,
        "source": order.source if order.what == "source" else None,
        "address": order.address or None,
        "port": order.port or None,
        "muted": order.muted,
    }
    as_ordered = all(value is None or getattr(stream, name) == value for name, value in ordered.items())
    return stream.on and as_ordered and (order.gain is None or abs(stream.gain_db - order.gain) < GAIN_STEP_DB)


@dataclass(frozen=True, slots=True)
class StopStream(Order):
    """End a stream, by its number or by where it goes, or all of them."""

    number = ross.MAV_CMD_ROSS_STREAM
    name = "stream"
    task = False
    stream: int | None = None  # None: the one that goes there, or all
    address: str = ""  # IPv4, of one computer
    port: int = 0

    def __post_init__(self) -> None:
        """Find out what cannot be meant before it is sent."""
        if self.stream is not None and self.address:
            raise ValueError("stop: expected the number of a stream or where it goes, got both")
        if self.stream is not None and (
            not isinstance(self.stream, Integral) or self.stream < 0
        ):  # which would mean all
            raise ValueError(f"stop: expected a number from 0, got {self.stream!r}")
        if self.port and not self.address:
            raise ValueError("address: expected one beside a port, got none")
        stream_command.command_of(self.numbers)

    @property
    def numbers(self) -> tuple[float, ...]:
        """As `stream_command` lays them out."""
        return stream_command.numbers_of(
            StreamCommand(self.stream, Selection.NONE, address=self.address, port=self.port)
        )

    @property
    def words(self) -> str:
        """Which."""
        if self.address:
            return f"stop the stream to {self.address}:{self.port}"
        return "stop all streams" if self.stream is None else f"stop stream {self.stream}"

    def replaces(self, other: Order) -> bool:
        """Whether it may have begun what this ends: sent again, it would begin once more."""
        if not isinstance(other, Stream):
            return False
        if self.address:
            return other.stream is not None or (other.address, other.port) == (self.address, self.port)
        return self.stream is None or other.stream in (None, self.stream)


@dataclass(frozen=True, slots=True)
class Enrol(Order):
    """Enrol the talker at a source or an azimuth, who has agreed to it."""

    number = ross.MAV_CMD_ROSS_ENROL
    name = "enrol"
    source: int | None = None
    azimuth: float | None = None  # [deg]
    seconds: float = 0.0  # 0: as long as the payload's configuration says
    consent: bool = False  # of the talker
    voice: int = 0  # it is stored as talker-N; 0: the lowest number that is free

    def __post_init__(self) -> None:
        """Find out what cannot be meant before it is sent."""
        if (self.source is None) is (self.azimuth is None):
            raise ValueError("enrol: expected a source or an azimuth")
        if not self.consent:
            raise ValueError("consent: expected that of the talker, got none")

    @property
    def numbers(self) -> tuple[float, ...]:
        """Mode, source, azimuth, seconds, consent, name."""
        mode, source, azimuth = SOURCE, float(self.source or 0), 0.0
        if self.azimuth is not None:
            mode, azimuth = AZIMUTH, self.azimuth
        return mode, source, azimuth, self.seconds, float(self.consent), float(self.voice)

    @property
    def words(self) -> str:
        """Whom."""
        name = f" as talker-{self.voice}" if self.voice else ""
        return f"enrol {f'source {self.source}' if self.azimuth is None else f'at {self.azimuth:g} deg'}{name}"
