"""What is answered of a payload's health: the parts of `condition`."""

from __future__ import annotations

from pydantic import Field

from ross_payload.ground.web.rest.view_answers import Answer, Level, Seconds


class Part(Answer):
    """How one part is, with words for whoever must act."""

    level: Level
    words: str


class Microphones(Part):
    """The microphones."""

    level_db: list[float] | None = Field(None, description="of each, re full scale")
    peak_db: list[float] | None = Field(None, description="of each, re full scale")
    lost: int | None = Field(None, description="samples")
    reopened: int | None = None
    waiting: float | None = Field(None, description="audio that waits [s]")
    rate: float | None = Field(None, description="[Hz]")


class ActuatorHealth(Part):
    """What turns the array."""

    at: Seconds | None
    error: float | None = Field(None, description="between heading and goal [deg]")
    open_loop: bool | None = None


class PayloadLink(Part):
    """One link of the payload, as it sees it."""

    url: str
    up: bool
    autopilot: bool
    sent: int = Field(description="frames")
    dropped: int = Field(description="frames")
    received: int = Field(description="frames")
    lost: int | None = Field(description="frames; null: not known behind a router")
    bad: int
    refused: int = Field(description="frames")
    reconnects: int


class Reception(Part):
    """What reaches this ground station."""

    frames: int
    bytes: int
    lost: int | None = Field(description="frames; null: not known behind a router")
    malformed: int


class Processor(Part):
    """The payload's computer."""

    loads: list[float] | None = Field(None, description="of every core, 0 to 1")
    memory: float | None = Field(None, description="0 to 1")
    temperature: float | None = Field(None, description="[degC]")
    uptime: float | None = Field(None, description="[s]")


class RecordingState(Part):
    """The recorder."""

    on: bool
    name: str | None = None
    duration: float | None = Field(None, description="[s]")
    free: float | None = Field(None, description="on its disk [bytes]")


class Listening(Part):
    """Live listening."""

    on: bool = Field(description="sound leaves the payload")


class Health(Answer):
    """How a payload is, part by part."""

    microphones: Microphones
    actuator: ActuatorHealth
    links: list[PayloadLink]
    reception: Reception
    processor: Processor
    recording: RecordingState
    listening: Listening
