"""What is answered of the page as a whole: links, control, the fleet, orders, parameters and files."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ross_payload.ground.web.rest.health_answers import Health
from ross_payload.ground.web.rest.view_answers import (
    Answer,
    Candidate,
    Degrees,
    Density,
    Group,
    Index,
    Isolation,
    Level,
    Mission,
    Moment,
    Pointing,
    Seconds,
    Source,
    Standing,
    StatusText,
    StreamState,
)

OrderState = Literal["sent", "acknowledged", "in_progress", "done", "refused", "failed", "cancelled", "no_answer"]
ParameterState = Literal["known", "sending", "set", "refused", "no_answer"]


class Link(Answer):
    """A link of this ground station."""

    url: str
    up: bool
    bytes_s: float
    frames_s: float
    loss: float | None = Field(description="0 to 1, of the last seconds; null: not known")
    error: str
    last: Seconds | None = Field(description="when the last good frame came")


class Control(Answer):
    """Who may command: one browser or program at a time."""

    holder: str | None
    name: str | None = Field(description="as chrome at 127.0.0.1; null: control is free")
    yours: bool


class Station(Answer):
    """The ground station."""

    version: str
    mode: Literal["live", "flight"] = Field(description="flight: without links, for recorded flights only")
    now: Seconds
    control: Control
    links: list[Link]
    advice: str = Field(description="what to do when no telemetry arrives; empty: nothing")
    over: str = Field(description="not empty: the simulation has ended")
    pace: str = Field(description="not empty: simulated time is not as fast as the clock")


class Position(Answer):
    """Where something is."""

    lat: float = Field(description="[deg]")
    lon: float = Field(description="[deg]")


class PlacedPayload(Position):
    """Where a payload stands."""

    heading: float | None = Field(description="of its vehicle, or of its mount's zero where it was typed [deg]")
    from_: Literal["autopilot", "typed"] = Field(alias="from")


class Bearing(Answer):
    """A direction in which a payload hears something."""

    id: str
    source: Index
    azimuth: float = Field(description="clockwise from north [deg]")
    sigma: float = Field(description="[deg]")


class Fix(Position):
    """Where the bearings of two payloads intersect."""

    east: float = Field(description="of the first payload [m]")
    north: float = Field(description="of the first payload [m]")
    covariance: list[list[float]] = Field(description="east, north [m2]")
    payloads: list[str]
    sources: list[int] = Field(description="one of each payload")
    ghost: bool = Field(description="another intersection is more likely")


class Summary(Answer):
    """One payload of several."""

    id: str
    state: str | None
    state_at: Seconds
    health_level: Level
    heading: Degrees | None
    earth: bool
    k: int | None
    last: Seconds
    target: Index | None
    position: Position | None
    actuator: str | None
    twin: bool


class Hidden(Answer):
    """Ids that are received and not among the 64 payloads listed."""

    count: int
    ids: list[str] = Field(description="those received most steadily")


class Payloads(Answer):
    """All payloads that are received, and where their bearings intersect."""

    now: Seconds
    payloads: list[Summary]
    hidden: Hidden
    places: dict[str, PlacedPayload] = Field(description="by id")
    bearings: list[Bearing]
    fixes: list[Fix]


class OfOne(Answer):
    """What is told of one payload."""

    id: str
    now: Seconds
    heard: int = Field(description="when its newest message came, UNIX time [ms]")


class PayloadState(OfOne):
    """What a payload does, where it points, and how it is."""

    standing: Standing
    pointing: Pointing
    mission: Mission
    health: Health


class Sources(OfOne):
    """Sources of the latest estimate."""

    sources: list[Source]


class Streams(OfOne):
    """Live listening."""

    streams: list[StreamState]


class AlignmentPlan(OfOne):
    """Alignment candidates in order of travel."""

    current: int | None = Field(description="the one that is turned to or stayed at")
    candidates: list[Candidate]


class Exploration(OfOne):
    """What was measured: a density per orientation, an isolation per source."""

    densities: list[Density]
    isolation: list[Isolation]


class Separation(OfOne):
    """The latest separation."""

    groups: list[Group]


class History(OfOne):
    """K, score and state over time, oldest first."""

    history: list[Moment]


class Texts(OfOne):
    """Texts for people, oldest first."""

    texts: list[StatusText]


class OrderStatus(Answer):
    """An order, and what has become of it."""

    url: str = Field(description="where to ask again")
    number: int
    id: str = Field(description="of the payload")
    words: str = Field(description="what was ordered")
    state: OrderState = Field(description="over: done, refused, failed, cancelled, no_answer")
    over: bool
    progress: float | None = Field(description="0 to 1")
    reason: str = Field(description="why not, in the payload's own words where it sent any")
    since: Seconds = Field(description="when it was ordered [s]")
    at: Seconds = Field(description="when that changed last [s]")


class Orders(Answer):
    """The latest orders, newest last, whoever gave them."""

    orders: list[OrderStatus]


class Parameter(Answer):
    """One parameter; null and empty are what the payload does not say."""

    name: str
    value: float
    default: float | None
    min: float | None
    max: float | None
    unit: str
    description: str
    group: str
    whole: bool = Field(description="it is a whole number")
    state: ParameterState = Field(description="of its latest change")
    reason: str


class ParameterList(Answer):
    """Parameters as far as they have arrived."""

    complete: bool
    notes: list[str] = Field(description="what is odd about them")
    parameters: list[Parameter]


class Flight(Answer):
    """A recorded flight."""

    name: str
    duration: float | None = Field(description="[s]; null: large, or still written")
    start: float | None = Field(description="UNIX time [s]")
    simulated: bool = Field(description="its times are simulated")
    notes: list[str]
    sound: list[str] = Field(description="names of its tracks")


class Flights(Answer):
    """Recorded flights, the newest first."""

    flights: list[Flight]


class FlightName(Answer):
    """How a flight is called here."""

    name: str


class Recording(Answer):
    """A recorded session."""

    name: str
    bytes: int
    seconds: float = Field(description="of sound [s]")
    state: str = Field(description="why it ended")
    running: bool


class Recordings(Answer):
    """Recorded sessions of this computer."""

    folder: str | None = Field(description="null: none are offered")
    recordings: list[Recording]


class RecordedFile(Answer):
    """A file of a recorded session."""

    name: str
    bytes: int


class RecordedFiles(Answer):
    """Files of a recorded session."""

    files: list[RecordedFile]
