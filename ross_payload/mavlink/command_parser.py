"""What a command of the dialect asks for: pure functions from its numbers to an order."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

from ross_payload.angles import difference
from ross_payload.config import APART_DEG
from ross_payload.errors import ConfigError
from ross_payload.orders import (
    Cancel,
    Explore,
    Home,
    Informed,
    ListenAt,
    ListenTo,
    MeasureNoise,
    Order,
    Park,
    Rearm,
    Seek,
    Stop,
    TurnTo,
)
from ross_protocols.mavlink.commands import Command, direction
from ross_protocols.mavlink.dialect import ross

LONGEST_NOISE = 60.0  # [s]
VOICE, SOURCE, AZIMUTH = ross.ROSS_LISTEN_MODE_VOICE, ross.ROSS_LISTEN_MODE_SOURCE, ross.ROSS_LISTEN_MODE_AZIMUTH
INFORM = ross.MAV_CMD_ROSS_INFORM
STOP = ross.MAV_CMD_ROSS_STOP


@dataclass(frozen=True, slots=True)
class Record:
    """Start or stop the recording: for the recorder, not for the mission."""

    on: bool


Asked = Order | Record


def asked(command: Command) -> Asked:
    """Return what a command of the dialect asks for.

    Raises
    ------
    ConfigError
        When one of its numbers cannot be meant.
    """
    return READERS[command.number](command)


def _number(command: Command, index: int, name: str, lower: float, upper: float) -> float:
    value = command.numbers[index - 1]
    if not lower <= value <= upper:
        raise ConfigError(f"{name}: expected {lower:g} to {upper:g}, got {value:g}")
    return float(value)


def _whole(command: Command, index: int, name: str, lower: int, upper: int) -> int:
    value = _number(command, index, name, lower, upper)
    if value % 1:
        raise ConfigError(f"{name}: expected a whole number, got {value:g}")
    return int(value)


def _direction(command: Command, index: int, name: str) -> float:
    return direction(_number(command, index, name, -360, 360))


def _listen(command: Command) -> Order:
    mode = _whole(command, 1, "mode", VOICE, AZIMUTH)
    if mode == VOICE:
        return Seek()
    if mode == SOURCE:
        return ListenTo(_whole(command, 2, "source", 0, 255))
    return ListenAt(_direction(command, 3, "azimuth"))


def _inform(command: Command) -> Order:
    told = [not math.isnan(number) for number in command.numbers[1:]]
    count = sum(told)
    if not all(told[:count]) or not count:
        raise ConfigError("azimuths: expected at least one, and NaN only behind the last, got a gap")
    azimuths = tuple(_direction(command, index + 2, f"azimuth {index}") for index in range(count))
    for i, j in combinations(range(count), 2):
        if abs(difference(azimuths[i], azimuths[j])) < math.radians(APART_DEG):
            raise ConfigError(f"azimuths {i} and {j} are less than {APART_DEG:g} deg apart")
    first = _whole(command, 1, "first", -1, count - 1)
    return Informed(azimuths, first=None if first < 0 else first)


def _turn(command: Command) -> Order:
    return TurnTo(_direction(command, 1, "heading"))


def _measure(command: Command) -> Order:
    return MeasureNoise(_number(command, 1, "time", 0, LONGEST_NOISE))


def _record(command: Command) -> Record:
    return Record(bool(_whole(command, 1, "start", 0, 1)))


READERS: dict[int, Callable[[Command], Asked]] = {
    ross.MAV_CMD_ROSS_EXPLORE: lambda command: Explore(),
    ross.MAV_CMD_ROSS_LISTEN: _listen,
    INFORM: _inform,
    ross.MAV_CMD_ROSS_TURN: _turn,
    STOP: lambda command: Stop(),
    ross.MAV_CMD_ROSS_CANCEL: lambda command: Cancel(),
    ross.MAV_CMD_ROSS_PARK: lambda command: Park(),
    ross.MAV_CMD_ROSS_MEASURE_NOISE: _measure,
    ross.MAV_CMD_ROSS_RECORD: _record,
    ross.MAV_CMD_ROSS_REARM: lambda command: Rearm(),
    ross.MAV_CMD_ROSS_HOME: lambda command: Home(),
}


def name_of(command: Command) -> str:
    """Return what a command is called in a text.

    >>> from ross_protocols.mavlink.component_id import ComponentId
    >>> name_of(Command(ross.MAV_CMD_ROSS_MEASURE_NOISE, (0.0,) * 7, ComponentId(1, 191), long=True))
    'measure noise'
    """
    known = ross.enums["MAV_CMD"].get(command.number)
    prefixes = "MAV_CMD_ROSS_", "MAV_CMD_"
    name = "command" if known is None else str(known.name)
    for prefix in prefixes:
        name = name.removeprefix(prefix)
    return name.lower().replace("_", " ")
