"""[microphones] of a scenario: what the array truly is, where the payload is told otherwise."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from ross_payload.config import Array, Degrees, Table
from ross_payload.config.hardware_options import Corner
from ross_sim.noise_tables import Decibels


class Microphones(Table):
    """[microphones]: what the array truly is, where that is not what the payload is told; what is absent is."""

    spacing_m: Annotated[float, Field(ge=0.005, le=1.0)] | None = None
    offset_deg: Degrees | None = None  # as offset_deg of [array]
    gain_db: tuple[Decibels, Decibels] = (0.0, 0.0)  # of microphones 1 and 2, before the payload's own
    invert: tuple[bool, bool] = (False, False)  # their polarity
    roll_off_hz: tuple[Corner, Corner] = (0.0, 0.0)  # where they are 3 dB down at low frequencies [Hz]
    swapped: bool = False  # their cables

    def spacing(self, configured: Array) -> float:
        """Return the true distance between the microphones [m]; ``configured`` is what the payload is told."""
        return configured.spacing_m if self.spacing_m is None else self.spacing_m

    def offset(self, configured: Array) -> float:
        """Return the true offset of the array's axis [rad]; ``configured`` is what the payload is told.

        >>> Microphones().offset(Array(offset_deg=180.0)) == math.pi
        True
        """
        return math.radians(configured.offset_deg if self.offset_deg is None else self.offset_deg)
