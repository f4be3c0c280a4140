"""What stands in paths and behind their question marks."""

from __future__ import annotations

from pydantic import Field

from ross_payload.ground.web.flight_library import MCAP, TLOG
from ross_payload.ground.web.rest.operation import Parameters
from ross_protocols.mavlink.component_id import ComponentId

LONGEST_WAIT_S = 60.0
BYTE = r"([1-9]|[1-9]\d|1\d\d|2[0-4]\d|25[0-5])"
PAYLOAD_ID = rf"^{BYTE}-{BYTE}$"
NAME = r"^[^/\x00-\x1f]{1,200}$"  # of a file or a folder


class OfPayload(Parameters):
    """A payload."""

    payload: str = Field(
        pattern=PAYLOAD_ID, description="MAVLink ids of its system and its component", examples=["1-191"]
    )

    @property
    def who(self) -> ComponentId:
        """Return it as an address."""
        return ComponentId.parse(self.payload)


class OfOrder(OfPayload):
    """An order to a payload."""

    number: int = Field(ge=1, le=2**31 - 1, description="of the order")


class OfParameter(OfPayload):
    """A parameter of a payload."""

    name: str = Field(pattern=r"^[!-.0-~]{1,16}$", description="of the parameter", examples=["EXP_UNIT"])


class OfRecording(Parameters):
    """A recorded session."""

    name: str = Field(pattern=NAME, description="of the recording", examples=["0001"])


class OfFile(OfRecording):
    """A file of a recorded session."""

    file: str = Field(pattern=NAME, description="its name in the session folder", examples=["audio.wav"])


class OfSound(Parameters):
    """A track of a flight."""

    name: str = Field(pattern=NAME, description="of the flight")
    track: str = Field(pattern=NAME, description="one of its `sound`")


class Wait(Parameters):
    """How long to wait."""

    wait: float = Field(
        0.0, ge=0, le=LONGEST_WAIT_S, description="answer when it is over, or after so long [s], whichever comes first"
    )


class WaitForList(Parameters):
    """How long to wait for a list."""

    wait: float = Field(
        5.0, ge=0, le=LONGEST_WAIT_S, description="answer when the list is complete, or after so long [s]"
    )


class Upload(Parameters):
    """How a flight is called that is brought."""

    name: str = Field(
        pattern=rf"^.{{1,120}}\.({TLOG[1:]}|{MCAP[1:]})$", description="file name of the log", examples=["flight.tlog"]
    )
