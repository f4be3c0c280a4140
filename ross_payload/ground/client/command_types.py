"""What an operator can ask of a payload, as values; and the command that asks for it.

Degrees are those of the page and of the commands: clockwise, in the frame of the payload's headings.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import ClassVar

from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.field_converters import FLOAT32_MAX

MOST_AZIMUTHS = 6  # of an `Inform`
VOICE, SOURCE, AZIMUTH = ross.ROSS_LISTEN_MODE_VOICE, ross.ROSS_LISTEN_MODE_SOURCE, ross.ROSS_LISTEN_MODE_AZIMUTH


@dataclass(frozen=True, slots=True)
class Order:
    """The root of all orders; ``number`` is their MAV_CMD, ``name`` what the payload's texts call it."""

    number: ClassVar[int]
    name: ClassVar[str]
    task: ClassVar[bool] = True  # takes time: it must not be done twice

    @property
    def numbers(self) -> tuple[float, ...]:
        """The parameters of the command, from the first to the last that matters."""
        return tuple(float(getattr(self, each.name)) for each in fields(self))

    @property
    def words(self) -> str:
        """What is asked for."""
        return self.name

    def replaces(self, other: Order) -> bool:
        """Whether an earlier order must not be said again after this one: it would undo it."""
        return False

    def check(self) -> None:
        """Find out before anything is sent what no command can carry; NaN and infinity are the payload's to refuse.

        Raises
        ------
        ValueError
            When a number is none, or too large for a 32-bit float.
        """
        try:
            _, numbers = self.words, [float(each) for each in self.numbers]
        except (TypeError, ValueError) as error:
            raise ValueError(f"{self.name}: expected numbers, got {self}") from error
        except OverflowError as error:
            raise ValueError(f"{self.name}: expected numbers that a 32-bit float can hold") from error
        if any(FLOAT32_MAX < abs(each) < math.inf for each in numbers):
            raise ValueError(f"{self.name}: expected numbers that a 32-bit float can hold, got {self}")


class Explore(Order):
    """Find the number of sources and every azimuth."""

    number = ross.MAV_CMD_ROSS_EXPLORE
    name = "explore"


@dataclass(frozen=True, slots=True)
class Listen(Order):
    """Listen to a source of the latest estimate, to the talker at an azimuth, or to the enrolled voice."""

    number = ross.MAV_CMD_ROSS_LISTEN
    name = "listen"
    source: int | None = None
    azimuth: float | None = None  # [deg]

    @property
    def numbers(self) -> tuple[float, ...]:
        """Mode, source, azimuth."""
        if self.source is not None:
            return SOURCE, self.source
        return (VOICE,) if self.azimuth is None else (AZIMUTH, 0, self.azimuth)

    @property
    def words(self) -> str:
        """To whom."""
        if self.source is not None:
            return f"listen to source {self.source}"
        return "find the enrolled voice" if self.azimuth is None else f"listen at {self.azimuth:g} deg"


@dataclass(frozen=True, slots=True)
class Inform(Order):
    """Find the enrolled voice among sources at known azimuths, without exploring."""

    number = ross.MAV_CMD_ROSS_INFORM
    name = "inform"
    azimuths: tuple[float, ...]  # [deg], 1 to `MOST_AZIMUTHS`
    first: int | None = None  # index of the one to visit first

    @property
    def numbers(self) -> tuple[float, ...]:
        """The first to visit, azimuths; NaN: there are no more."""
        empty = [math.nan] * (MOST_AZIMUTHS - len(self.azimuths))
        return -1.0 if self.first is None else float(self.first), *self.azimuths, *empty

    @property
    def words(self) -> str:
        """Where to look."""
        return f"find the enrolled voice at {', '.join(f'{azimuth:g}' for azimuth in self.azimuths)} deg"


@dataclass(frozen=True, slots=True)
class Turn(Order):
    """Point the axis to a heading and stay there."""

    number = ross.MAV_CMD_ROSS_TURN
    name = "turn"
    heading: float  # [deg]

    @property
    def words(self) -> str:
        """Where to."""
        return f"turn to {self.heading:g} deg"


class Park(Order):
    """Turn to the parking position."""

    number = ross.MAV_CMD_ROSS_PARK
    name = "park"


class Home(Order):
    """Find the zero of the joint."""

    number = ross.MAV_CMD_ROSS_HOME
    name = "home"


@dataclass(frozen=True, slots=True)
class Noise(Order):
    """Measure the noise while nobody talks; 0 s: as long as the lead-in of the configuration."""

    number = ross.MAV_CMD_ROSS_MEASURE_NOISE
    name = "measure noise"
    seconds: float = 0.0


class Stop(Order):
    """Decelerate now and refuse to move until re-armed."""

    number = ross.MAV_CMD_ROSS_STOP
    name = "stop"
    task = False


class Cancel(Order):
    """End what is going on."""

    number = ross.MAV_CMD_ROSS_CANCEL
    name = "cancel"
    task = False


class Rearm(Order):
    """Accept moves again after a stop or a fault."""

    number = ross.MAV_CMD_ROSS_REARM
    name = "rearm"
    task = False


@dataclass(frozen=True, slots=True)
class Record(Order):
    """Start or end record a session on the payload's disk."""

    number = ross.MAV_CMD_ROSS_RECORD
    name = "record"
    task = False
    on: bool

    @property
    def words(self) -> str:
        """Which of the two."""
        return "start recording" if self.on else "stop recording"

    def replaces(self, other: Order) -> bool:
        """One of them undoes the other."""
        return isinstance(other, Record)


def undoes(order: Order, earlier: Order) -> bool:
    """Tell whether an order ends an earlier one, or would be ended or undone by it."""
    if isinstance(order, Stop):
        return not isinstance(earlier, Stop)
    ends = order.task or isinstance(order, Cancel)
    return ends and (earlier.task or (order.task and isinstance(earlier, Cancel)))
