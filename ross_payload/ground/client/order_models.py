"""What can be ordered, as models: they name the orders there are, check them, and describe them to other programs.

Degrees are those of `command_types`: clockwise, in the frame of the payload's headings.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, GetCoreSchemaHandler, create_model, model_validator
from pydantic_core import CoreSchema

from ross_payload.ground.client import command_types
from ross_payload.ground.client.stream_orders import Enrol, StopStream, Stream
from ross_protocols.mavlink.commands import LONGEST_ENROLMENT, LONGEST_NOISE, MOST_NAMES
from ross_protocols.mavlink.stream_command import MOST_DB, MOST_NUMBER, MUTED_DB

OCTET = r"(\d|[1-9]\d|1\d\d|2[0-4]\d|25[0-5])"
UNICAST = rf"^([1-9]|[1-9]\d|1\d\d|2[01]\d|22[0-3])\.{OCTET}\.{OCTET}\.{OCTET}$"  # IPv4, as `unicast` accepts it
CODECS = {"l16": "L16", "opus": "opus"}

T = TypeVar("T")


class Omissible:
    """Marks ``T | None``: a field that may be left out, and is None then; null is refused."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema without null."""
        nullable: Any = handler(source)
        inner: CoreSchema = nullable["schema"]
        return inner


def omissible(description: str = "") -> Any:
    """Return the default of such a field, which its schema does not show."""
    return Field(None, description=description or None, json_schema_extra=lambda schema: schema.pop("default"))


def _integral(value: Any) -> Any:
    """Return the integer that a float is: in JSON 2.0 is one."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _codec(value: Any) -> Any:
    return CODECS.get(value.lower(), value) if isinstance(value, str) else value


WHOLE = BeforeValidator(_integral)  # behind the bounds, which a schema would not show otherwise
SPANS = {"source": "0 to 255", "azimuth": "-360 to 360"}
Angle = Annotated[float, Field(ge=-360, le=360)]  # [deg]
Index = Annotated[int, Field(ge=0, le=255), WHOLE]  # of a source in the latest estimate
StreamNumber = Annotated[int, Field(ge=0, le=MOST_NUMBER), WHOLE]
Address = Annotated[str, Field(pattern=UNICAST, examples=["192.168.1.20"])]
Port = Annotated[int, Field(ge=1, le=65535), WHOLE]
Gain = Annotated[float, Field(ge=MUTED_DB, le=MOST_DB)]  # [dB]
VoiceNumber = Annotated[int, Field(ge=0, le=MOST_NAMES), WHOLE]
First = Annotated[int, Field(ge=0, le=command_types.MOST_AZIMUTHS - 1), WHOLE]
Enrolment = Annotated[float, Field(ge=0, le=LONGEST_ENROLMENT)]  # [s]
Codec = Annotated[Literal["opus", "L16"], BeforeValidator(_codec)]
Maybe = Annotated[T | None, Omissible()]


class OrderModel(BaseModel):
    """The root of all; a field that is not its own is an error, and so is null."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    makes: ClassVar[type[command_types.Order]]

    def order(self) -> command_types.Order:
        """Return the order.

        Raises
        ------
        ValueError
            When something cannot be meant.
        """
        return self.makes(**self.model_dump(exclude={"kind"}, exclude_none=True))


class ListenOrder(OrderModel):
    """Listen to a source of the latest estimate, to the talker at an azimuth, or else to the enrolled voice."""

    model_config = ConfigDict(json_schema_extra={"not": {"required": ["source", "azimuth"]}})
    makes = command_types.Listen
    kind: Literal["listen"]
    source: Maybe[Index] = omissible("its index in the latest estimate")
    azimuth: Maybe[Angle] = omissible("[deg]")

    @model_validator(mode="after")
    def _one_at_most(self) -> Self:
        if self.source is not None and self.azimuth is not None:
            raise ValueError("listen: expected a source or an azimuth, got both")
        return self


class InformOrder(OrderModel):
    """Find the enrolled voice among sources at known azimuths, without exploring."""

    makes = command_types.Inform
    kind: Literal["inform"]
    azimuths: list[Angle] = Field(min_length=1, max_length=command_types.MOST_AZIMUTHS, description="[deg]")
    first: Maybe[First] = omissible("index of the one to visit first")

    def order(self) -> command_types.Order:
        """Return the order."""
        return command_types.Inform(tuple(self.azimuths), self.first)


class TurnOrder(OrderModel):
    """Point the axis from microphone 1 to microphone 2 to a heading and stay there."""

    makes = command_types.Turn
    kind: Literal["turn"]
    heading: Angle = Field(description="[deg]")


class RecordOrder(OrderModel):
    """Start, or end, recording a session on the payload's disk."""

    makes = command_types.Record
    kind: Literal["record"]
    on: bool


class NoiseOrder(OrderModel):
    """Measure the noise while nobody talks."""

    makes = command_types.Noise
    kind: Literal["noise"]
    seconds: float = Field(
        0.0, ge=0, le=LONGEST_NOISE, description="how long [s]; 0: as long as the payload's configuration says"
    )


class StreamOrder(OrderModel):
    """Let somebody listen, live, at one address, or change a stream; what is left out stays as it is."""

    model_config = ConfigDict(
        json_schema_extra={
            "if": {"required": ["stream"]},
            "else": {"required": ["address"]},
            "dependentRequired": {"address": ["port"], "port": ["address"]},
            "dependentSchemas": {
                "what": {
                    "if": {"properties": {"what": {"const": "source"}}},
                    "then": {"required": ["source"]},
                    "else": {"if": {"properties": {"what": {"const": "azimuth"}}}, "then": {"required": ["azimuth"]}},
                }
            },
        }
    )
    makes = Stream
    kind: Literal["stream"]
    stream: Maybe[StreamNumber] = omissible("which one to change; without: the one that goes there, or a new one")
    what: Maybe[Literal["mixture", "target", "source", "azimuth"]] = omissible("what it carries")
    source: Maybe[Index] = omissible("which one, by its index in the latest estimate")
    azimuth: Maybe[Angle] = omissible("which one [deg]")
    address: Maybe[Address] = omissible("IPv4, of one computer, as the payload reaches it")
    port: Maybe[Port] = omissible()
    codec: Maybe[Codec] = omissible("of a new one without: Opus")
    gain: Maybe[Gain] = omissible("[dB]")
    muted: Maybe[bool] = omissible()

    @model_validator(mode="after")
    def _selected(self) -> Self:
        if self.what in SPANS and getattr(self, self.what) is None:
            raise ValueError(f"{self.what}: expected {SPANS[self.what]}, got nothing")
        return self


class StopStreamOrder(OrderModel):
    """End a stream of live listening, by its number or by where it goes, or all of them."""

    model_config = ConfigDict(
        json_schema_extra={
            "not": {"required": ["stream", "address"]},
            "dependentRequired": {"address": ["port"], "port": ["address"]},
        }
    )
    makes = StopStream
    kind: Literal["stop_stream"]
    stream: Maybe[StreamNumber] = omissible()
    address: Maybe[Address] = omissible("IPv4")
    port: Maybe[Port] = omissible()


class EnrolOrder(OrderModel):
    """Enrol the talker at a source or an azimuth, who has agreed to it."""

    model_config = ConfigDict(
        json_schema_extra={
            "if": {"required": ["source"]},
            "then": {"not": {"required": ["azimuth"]}},
            "else": {"required": ["azimuth"]},
        }
    )
    makes = Enrol
    kind: Literal["enrol"]
    source: Maybe[Index] = omissible("its index in the latest estimate")
    azimuth: Maybe[Angle] = omissible("[deg]")
    consent: bool = Field(description="of the talker", json_schema_extra={"const": True})
    voice: Maybe[VoiceNumber] = omissible("it is stored as talker-N; 0: the lowest number that is free")
    seconds: Maybe[Enrolment] = omissible("how long [s]; 0: as long as the payload's configuration says")


def _plain(makes: type[command_types.Order]) -> type[OrderModel]:
    """Return the model of an order without arguments."""
    kind: Any = Literal[makes.name]
    model = create_model(f"{makes.__name__}Order", __base__=OrderModel, __doc__=makes.__doc__, kind=(kind, ...))
    model.makes = makes
    return model


PLAIN = (
    command_types.Explore,
    command_types.Stop,
    command_types.Cancel,
    command_types.Park,
    command_types.Home,
    command_types.Rearm,
)
MODELS: dict[str, type[OrderModel]] = {makes.name: _plain(makes) for makes in PLAIN} | {
    "listen": ListenOrder,
    "inform": InformOrder,
    "turn": TurnOrder,
    "record": RecordOrder,
    "noise": NoiseOrder,
    "stream": StreamOrder,
    "stop_stream": StopStreamOrder,
    "enrol": EnrolOrder,
}
