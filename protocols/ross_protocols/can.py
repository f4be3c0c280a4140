"""Frames of classic CAN."""

from __future__ import annotations

from dataclasses import dataclass

MOST_DATA = 8  # of a frame [bytes]


@dataclass(frozen=True, slots=True)
class CanFrame:
    """One data frame: DroneCAN's identifiers have 29 bits, CANopen's 11."""

    id: int
    data: bytes  # at most 8 bytes
    extended: bool = True  # the identifier has 29 bits
