"""Our messages inside TUNNEL, to pass an autopilot that drops what it does not know.

One TUNNEL carries one whole, unsigned frame of one of our messages. It is telemetry only: nothing reads an order out of
it. A ground station unwraps it in a few lines, see docs/how-to/ground-stations.md.
"""

from __future__ import annotations

from typing import Any

from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.dialect import common, ross

TYPE = ross.ROSS_TUNNEL_TYPE_FRAME
SIZE = 128  # bytes that a TUNNEL carries
OURS = "ROSS_"


class Wrapper:
    """One component's voice inside TUNNEL; the frames inside count their own sequence.

    >>> from ross_protocols.mavlink.values import Audio
    >>> message = Wrapper(1, 191).wrap(Audio(time_usec=7))
    >>> unwrap(message).value.time_usec
    7
    """

    def __init__(self, system_id: int, component_id: int) -> None:
        self._encoder = Encoder(system_id, component_id)

    def wrap(self, content: Any) -> Any:
        """Return the TUNNEL message, to everybody, that carries a value or message of our dialect."""
        frame = self._encoder.encode(content)
        return common.MAVLink_tunnel_message(0, 0, TYPE, len(frame), list(frame.ljust(SIZE, b"\0")))


def unwrap(message: Any) -> Packet | None:
    """Return what a TUNNEL message of any pymavlink dialect carries; None: nothing of ours, or not whole."""
    if message.payload_type != TYPE or not 0 < message.payload_length <= SIZE:
        return None
    packets = Decoder().feed(bytes(message.payload[: message.payload_length]))
    if len(packets) != 1 or not packets[0].name.startswith(OURS):
        return None
    return packets[0]


def unwrapped(packet: Packet) -> Packet | None:
    """Return a packet as it is, or what it carries when it is a TUNNEL; None: nothing of ours."""
    return unwrap(packet.message) if packet.name == "TUNNEL" else packet
