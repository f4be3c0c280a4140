"""The seven numbers of MAV_CMD_ROSS_STREAM, there and back: whom a stream carries, and to which address.

A number of a command is a float of 32 bits, which is exact for whole numbers up to 2^24. So an IPv4 address travels as
two halves of 16 bits, and the port beside the codec: below 3 * 2^16. Angles are degrees, clockwise, as in all commands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from ipaddress import AddressValueError, IPv4Address

from ross_protocols.mavlink.stream_values import Codec, Selection

HALF = 1 << 16
CODECS = {"": Codec.OTHER, "l16": Codec.L16, "opus": Codec.OPUS}  # that can be commanded, by name
NAMES = {Codec.OTHER: "", Codec.L16: "L16", Codec.OPUS: "opus"}
MUTED_DB = -100.0
MOST_DB = 40.0
MOST_NUMBER = 254
NEW = -1


@dataclass(frozen=True, slots=True)
class StreamCommand:
    """What MAV_CMD_ROSS_STREAM asks for; what is to stay as it is, is None or empty."""

    number: int | None = None  # None: a new one, or all that end
    selection: Selection | None = None  # NONE: end it
    source: int = 0  # of SOURCE
    azimuth: float = 0.0  # of AZIMUTH [deg]
    gain: float | None = None  # [dB]; `MUTED_DB`: muted
    address: str = ""  # IPv4
    port: int = 0
    codec: str = ""  # a key of `CODECS`, in either case


def unicast(address: str) -> IPv4Address:
    """Return an IPv4 address that belongs to one computer.

    >>> str(unicast("192.168.1.20"))
    '192.168.1.20'

    Raises
    ------
    ValueError
        When it is none, or one of many or of all computers.
    """
    try:
        numeric = IPv4Address(address)
    except AddressValueError:
        raise ValueError(f"address: expected IPv4, as in 192.168.1.20, got '{address[:60]}'") from None
    if numeric.is_multicast or numeric.is_reserved or int(numeric) >> 24 == 0:
        raise ValueError(f"address: expected that of one computer, got {numeric}")
    return numeric


def place_of(text: str) -> tuple[str, int, str]:
    """Read address, port and codec of whoever listens.

    >>> place_of("192.168.1.20:5004"), place_of("127.0.0.1:5004/L16")
    (('192.168.1.20', 5004, 'opus'), ('127.0.0.1', 5004, 'L16'))

    Raises
    ------
    ValueError
        When it is no such place.
    """
    place, _, codec = text.partition("/")
    address, _, port = place.rpartition(":")
    if not address or not port.isdecimal() or not port.isascii():
        raise ValueError(f"expected address:port, as in 192.168.1.20:5004, got '{text[:60]}'")
    host, number, name = str(unicast(address)), int(_between("port", float(port), 1, HALF - 1)), codec or "opus"
    if CODECS.get(name.lower(), Codec.OTHER) is Codec.OTHER:
        raise ValueError(f"codec: expected opus or L16, got '{name[:60]}'")
    return host, number, name


def numbers_of(command: StreamCommand) -> tuple[float, ...]:
    """Return the numbers of the command.

    >>> numbers_of(StreamCommand(None, Selection.SOURCE, 2, gain=0.0, address="127.0.0.1", port=5004, codec="opus"))
    (-1.0, 3.0, 2.0, 0.0, 32512.0, 1.0, 136076.0)

    Raises
    ------
    ValueError
        When address, port or codec cannot be meant.
    """
    high, low = divmod(int(unicast(command.address)), HALF) if command.address else (0, 0)
    if command.address:
        _between("port", command.port, 1, HALF - 1)
    codec = CODECS.get(command.codec.lower())
    if codec is None:
        raise ValueError(f"codec: expected opus or L16, got '{command.codec[:60]}'")
    which = {Selection.SOURCE: float(command.source), Selection.AZIMUTH: command.azimuth}
    return (
        float(NEW if command.number is None else command.number),
        math.nan if command.selection is None else float(command.selection),
        which.get(command.selection, 0.0) if command.selection is not None else 0.0,
        math.nan if command.gain is None else command.gain,
        float(high),
        float(low),
        float(command.port + HALF * codec),
    )


def command_of(numbers: Sequence[float]) -> StreamCommand:
    """Read the seven numbers of the command.

    Raises
    ------
    ValueError
        When one of them cannot be meant.
    """
    number, selected, which, gain, high, low, last = numbers
    selection = None if math.isnan(selected) else Selection(_whole("selection", selected, 0, max(Selection)))
    address = _whole("address 1", high, 0, HALF - 1) * HALF + _whole("address 2", low, 0, HALF - 1)
    codec, port = divmod(_whole("port and codec", last, 0, HALF * (Codec.OPUS + 1) - 1), HALF)
    if bool(address) != bool(port):
        raise ValueError(f"port: expected {'1 to 65535' if address else '0 without an address'}, got {port}")
    stream = _whole("stream", number, NEW, MOST_NUMBER)
    return StreamCommand(
        number=None if stream == NEW else stream,
        selection=selection,
        source=_whole("source", which, 0, 255) if selection is Selection.SOURCE else 0,
        azimuth=_between("azimuth", which, -360, 360) if selection is Selection.AZIMUTH else 0.0,
        gain=None if math.isnan(gain) else _between("gain", gain, MUTED_DB, MOST_DB),
        address=str(unicast(str(IPv4Address(address)))) if address else "",
        port=port,
        codec=NAMES[Codec(codec)],
    )


def _between(name: str, value: float, lower: float, upper: float) -> float:
    if not lower <= value <= upper:
        raise ValueError(f"{name}: expected {lower:g} to {upper:g}, got {value:g}")
    return float(value)


def _whole(name: str, value: float, lower: int, upper: int) -> int:
    if _between(name, value, lower, upper) % 1:
        raise ValueError(f"{name}: expected a whole number, got {value:g}")
    return int(value)
