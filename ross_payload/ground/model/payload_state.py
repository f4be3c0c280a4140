"""What somebody on the ground knows of one payload: frozen values, filled from telemetry alone.

Times ``at`` are seconds on the listener's clock: monotonic while live, the log's own in a recording. Angles are as in
`ross_protocols.mavlink.values`: radians, counter-clockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ross_protocols.mavlink import values
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.computer import Computer
from ross_protocols.mavlink.stream_values import StreamReport

MISSION_TIME_WRAP_S = 2**32 / 1e3  # [s] after which mission time begins at 0 again: 32 bits of milliseconds, 49.7 days
DAY_S = 86400.0


def twins(who: ComponentId) -> str:
    """Return what to do when two payloads speak with one id."""
    remedy = "give one of them a different system_id, or a different component_id on the same vehicle"
    return f"two payloads use the id {who}: {remedy}"


@dataclass(frozen=True, slots=True)
class StatusText:
    """A text for humans, put together again from its chunks."""

    at: float  # [s]
    severity: int  # MAV_SEVERITY: 0 emergency to 7 debug
    text: str


@dataclass(frozen=True, slots=True)
class Moment:
    """One point of a mission's history."""

    at: float  # [s]
    mission_time: float  # [s]
    state: int  # ROSS_STATE
    k: int | None
    score: float | None
    criterion: float | None
    heading: float | None  # [rad]

    @classmethod
    def of(cls, status: values.Status, at: float) -> Moment:
        """Return the moment of a status that came ``at`` a time [s]."""
        return cls(at, status.mission_time, status.state, status.k, status.score, status.criterion, status.heading)


@dataclass(frozen=True, slots=True)
class SourceTrack:
    """Where a source was estimated lately; from one estimate to the next sources are told by where they are."""

    source: int  # its index in the estimate
    points: tuple[tuple[float, float], ...]  # at [s], azimuth [rad]; oldest first
    estimate: int = 0  # number of the latest estimate that has it
    earth: bool = False  # azimuths count from north
    at: float = 0.0  # its source was heard of last [s]


@dataclass(frozen=True, slots=True)
class Counts:
    """What went through the listener's link, of one payload."""

    frames: int = 0
    size: int = 0  # [bytes]
    missing: int = 0  # frames, in the sequence
    malformed: int = 0  # messages that no payload means: a NaN where a number must be, a source out of range
    routed: bool = False  # its frames come through somebody who passes on some of them

    @property
    def lost(self) -> int | None:
        """Frames that were lost; None: some are missing, and a router may have kept them to itself."""
        return None if self.routed and self.missing else self.missing


@dataclass(frozen=True, slots=True)
class PayloadState:
    """Everything that is known of one payload."""

    who: ComponentId
    first: float  # heard of [s]
    last: float  # heard of [s]
    boots: int = 1  # starts that were noticed; after a new start all else is forgotten
    tunnelled: bool = False  # its messages came inside TUNNEL
    twin: bool = False  # two senders share this id
    counts: Counts = field(default_factory=Counts)
    heartbeat: values.Heartbeat | None = None
    information: values.Information | None = None
    status: values.Status | None = None
    status_at: float | None = None  # when it came [s]
    without_status: float = 0.0  # for how long other messages have come since then [s]
    sources: tuple[values.Source, ...] = ()  # of the latest estimate, by index
    announced: int = 0  # sources that the latest estimate announces, shown or not
    trails: tuple[SourceTrack, ...] = ()
    alignments: tuple[values.Alignment, ...] = ()  # of the latest plan, by index
    separations: tuple[values.Separation, ...] = ()  # of the latest separation, by index
    densities: tuple[values.Density, ...] = ()  # of the latest exploration, by rotation
    isolations: tuple[values.Isolation, ...] = ()  # of the latest plan, by source
    audio: values.Audio | None = None
    recording: values.Recording | None = None
    links: tuple[values.LinkReport, ...] = ()  # by index
    streams: tuple[StreamReport, ...] = ()  # of live listening, by number; also those that have ended
    computer: Computer | None = None
    texts: tuple[StatusText, ...] = ()  # oldest first
    history: tuple[Moment, ...] = ()  # oldest first
    began: float | None = None  # mission time at which the latest mission began [s]; None: that was not heard
    ended: float | None = None  # mission time at which it ended [s]; None: it has not
    mirrors: tuple[tuple[str, float], ...] = ()  # NAMED_VALUE_FLOAT ross_*, for want of our dialect
    azimuths: tuple[float, ...] = ()  # clockwise [deg]: DEBUG_FLOAT_ARRAY ross_az, for want of our dialect
    flaws: tuple[str, ...] = ()  # what is odd about its messages, in words

    @property
    def earth(self) -> bool:
        """Whether its angles count from north."""
        return self.status is not None and self.status.earth

    @property
    def state(self) -> int | None:
        """Its ROSS_STATE; None: not known. Where no status arrives, heartbeats and mirrors tell it."""
        if self.status is not None:
            return self.status.state
        mirrored = dict(self.mirrors).get("ross_state")
        return self.heartbeat.state if self.heartbeat else None if mirrored is None else int(mirrored)

    @property
    def state_at(self) -> float:
        """When its state was last told [s]; where no status arrives: when it was last heard."""
        return self.last if self.status_at is None else self.status_at

    def texts_since(self, before: PayloadState | None) -> tuple[StatusText, ...]:
        """Return the texts that an earlier state of the same payload does not have; None: there is no earlier one."""
        latest = before.texts[-1] if before is not None and before.texts else None
        place = next((i for i in reversed(range(len(self.texts))) if self.texts[i] is latest), -1)
        return self.texts[place + 1 :]


def elapsed(known: PayloadState) -> float | None:
    """Return the audio that the latest mission received [s]; None: there was none, or its beginning is not known."""
    if known.status is None or known.began is None:
        return None
    now = known.status.mission_time if known.ended is None else known.ended
    return (now - known.began + DAY_S) % MISSION_TIME_WRAP_S - DAY_S  # a little less than 0 stays that


def mission_time_between(before: float, after: float) -> float:
    """Return the mission time [s] that went by from one status to another; less than 0: it went back.

    What is back by a whole round, but for a day, has gone on.

    >>> mission_time_between(100.0, 1.0), round(mission_time_between(MISSION_TIME_WRAP_S - 1.0, 0.5), 3)
    (-99.0, 1.5)
    """
    between = after - before
    if abs(between) < MISSION_TIME_WRAP_S - DAY_S:
        return between
    return between - math.copysign(MISSION_TIME_WRAP_S, between)
