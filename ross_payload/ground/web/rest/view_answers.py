"""What is answered of one payload: the sections of `view`, with names, types and meanings that others can read.

What the view tells does not fit if a field is missing here, or has another type; then nothing is answered.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Degrees = Annotated[float, Field(description="[deg], clockwise: from north where `earth` is true, else from the nose")]
Seconds = Annotated[float, Field(description="[s] on the clock of the ground process, as `now`")]
Level = Literal["good", "watch", "act", "unknown"]
Index = Annotated[int, Field(description="index of a source in the latest estimate")]


class Answer(BaseModel):
    """The root of all answers: every field is always there, null where the payload did not tell it."""

    model_config = ConfigDict(frozen=True, extra="forbid", json_schema_serialization_defaults_required=True)


class Standing(Answer):
    """Who it is, what it does, and since when it was not heard of."""

    who: str
    system: int
    component: int
    last: Seconds
    boots: int = Field(description="starts that were noticed")
    twin: bool = Field(description="two payloads use this id")
    tunnelled: bool = Field(description="its messages come inside TUNNEL")
    mirrors_only: bool = Field(description="only NAMED_VALUE_FLOAT is heard of it")
    state: str | None = Field(description="an entry of ROSS_STATE in lower case")
    state_meaning: str
    outcome: str | None = Field(description="an entry of ROSS_OUTCOME in lower case; null: not over")
    health: str | None
    version: str | None
    dialect: int | None
    actuator: str | None
    streaming: bool | None = Field(description="sound leaves it live")
    recording: bool | None = Field(description="sound is kept on a disk")
    flaws: list[str] = Field(description="what is odd about its messages")


class Pointing(Answer):
    """Where the axis from microphone 1 to microphone 2 points and may point."""

    earth: bool = Field(description="headings count from north, else from the nose")
    heading: Degrees | None
    goal: Degrees | None
    joint: float | None = Field(None, description="[deg], clockwise, not wrapped")
    joint_rate: float | None = Field(None, description="[deg/s]")
    mount_yaw: float | None = Field(None, description="[deg], clockwise from north")
    limits: list[float] | None = Field(
        description="headings [deg] from the first clockwise to the second; null: all round"
    )
    present: bool = Field(description="there is an actuator")
    settled: bool | None = None
    homed: bool | None = None
    fault: bool | None = None
    open_loop: bool | None = Field(None, description="nothing measures where it is")


class Mission(Answer):
    """How far the mission is."""

    k: int | None = Field(description="number of sources")
    target: Index | None
    score: float | None = Field(description="similarity of the best voice to the enrolled one")
    rotation: int | None = Field(None, description="orientations so far")
    rotation_max: int | None = None
    target_found: bool | None = None
    criterion: float | None = Field(None, description="score from which a voice is the target's")
    certain: bool | None = Field(None, description="the number of sources is certain")
    noise_measured: bool | None = None
    time: float | None = Field(None, description="mission time [s]")
    elapsed: float | None = Field(None, description="audio that it received [s]")
    expected: float | None = Field(None, description="about how long it takes [s]; null until its parameters are known")
    si_sdr: float | None = Field(None, description="of the target, as the payload estimates it [dB]")
    si_sdri: float | None = Field(None, description="its improvement [dB]")
    gain: float | None = Field(None, description="predicted of the current alignment [dB]")


class Source(Answer):
    """One source of the latest estimate."""

    source: Index
    azimuth: Degrees
    mirror: Degrees | None = Field(description="where it may be instead; null: the mirror image is ruled out")
    sigma: float | None = Field(description="[deg]")
    elevation: float | None = Field(description="[deg], upwards")
    confidence: float | None = Field(description="probability that a talker is within 10 deg")
    weight: float | None = Field(description="share of the sound, 0 to 1")
    score: float | None
    resolved: bool = Field(description="the mirror image is ruled out")
    target: bool = Field(description="it is the enrolled voice")
    final: bool = Field(description="the exploration is over")
    earth: bool
    tracked: bool
    rate: float | None = Field(description="of the azimuth [deg/s]; null: it is not tracked")
    age: float | None = Field(description="since it was last heard, while it is tracked [s]")
    announced: int = Field(description="sources that the estimate has, received or not")
    trail: list[tuple[float, float]] = Field(description="where it was: time [s] and azimuth [deg], oldest first")


class Candidate(Answer):
    """One heading at which a source is set apart."""

    candidate: int
    source: Index
    gain: float | None = Field(description="predicted SI-SDR improvement [dB]")
    heading: Degrees
    joint: float | None = Field(description="[deg], clockwise, not wrapped")
    isolation_us: float
    aliased: list[int] = Field(description="sources that share one delay there")
    rule: str | None = Field(description="an entry of ROSS_ALIGNMENT_RULE in lower case")
    rule_meaning: str
    state: str | None = Field(description="an entry of ROSS_CANDIDATE_STATE in lower case")


class Plan(Answer):
    """Alignment candidates in order of travel."""

    current: int | None = Field(description="the one that is turned to or stayed at")
    candidates: list[Candidate]


class Density(Answer):
    """ITD density of one orientation, at equal steps."""

    rotation: int
    heading: Degrees
    first_us: float = Field(description="ITD of the first point [us]")
    last_us: float = Field(description="ITD of the last point [us]")
    density: list[float] = Field(description="0 to 1")


class Isolation(Answer):
    """How well a source is set apart over half a turn, at equal steps."""

    source: Index
    first: float | None = Field(description="heading of the first point [deg], clockwise, not wrapped")
    last: float | None = Field(description="heading of the last point [deg]")
    maximum_us: float
    isolation: list[float] = Field(description="0 to 1 of the maximum")


class Group(Answer):
    """One group of the latest separation."""

    group: int
    method: str
    score: float | None
    criterion: float | None
    si_sdr: float | None = Field(description="[dB]")
    si_sdri: float | None = Field(description="[dB]")
    accepted: bool
    target: bool
    phase: str | None = Field(description="an entry of ROSS_SEPARATION_PHASE in lower case")
    members: list[int] = Field(description="sources")
    heading: Degrees | None


class StreamState(Answer):
    """One stream of live listening; it stays when it has ended, off, until its number is given to another."""

    number: int
    sink: str
    on: bool
    selection: str = Field(description="mixture, target, source or azimuth")
    source: Index | None
    azimuth: Degrees | None
    group: int | None
    separated: bool = Field(description="a voice is heard at present, else the mixture or silence")
    codec: str | None
    rate: int = Field(description="[Hz]")
    address: str
    port: int
    listeners: int | None = Field(description="null: the payload does not tell; with RTP 1, or 0 when nobody takes it")
    records: bool = Field(description="what it carries stays on a disk")
    gain_db: float
    muted: bool
    level_db: float | None = Field(description="re full scale")
    delay: float | None = Field(description="from the microphone until it leaves the payload [s]")
    lost: int = Field(description="samples that did not get out")
    packets_lost: int | None
    fault: bool
    detail: str
    level: Level
    whom: str
    place: str
    words: str


class Moment(Answer):
    """One point of a mission's history."""

    at: Seconds
    time: float = Field(description="mission time [s]")
    state: str | None
    k: int | None
    score: float | None
    criterion: float | None
    heading: Degrees | None


class StatusText(Answer):
    """A text for people."""

    at: Seconds
    severity: int = Field(description="MAV_SEVERITY: 0 emergency to 7 debug")
    text: str
