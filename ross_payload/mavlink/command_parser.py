"""What a command of the dialect asks for: pure functions from its numbers to an order."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

from ross_payload import orders
from ross_payload.angles import difference
from ross_payload.config import APART_DEG
from ross_payload.errors import ConfigError
from ross_payload.streams import Selection, StreamOrder, What
from ross_protocols.mavlink import stream_command
from ross_protocols.mavlink.commands import LONGEST_ENROLMENT, LONGEST_NOISE, MOST_NAMES, Command, direction
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.stream_command import MUTED_DB, StreamCommand
from ross_protocols.mavlink.stream_values import Selection as Selected

VOICE, SOURCE, AZIMUTH = ross.ROSS_LISTEN_MODE_VOICE, ross.ROSS_LISTEN_MODE_SOURCE, ross.ROSS_LISTEN_MODE_AZIMUTH
INFORM = ross.MAV_CMD_ROSS_INFORM
STOP = ross.MAV_CMD_ROSS_STOP


@dataclass(frozen=True, slots=True)
class Record:
    """Start or stop the recording: for the recorder, not for the mission."""

    on: bool


Asked = orders.Order | Record | StreamOrder


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


def _listen(command: Command) -> orders.Order:
    mode = _whole(command, 1, "mode", VOICE, AZIMUTH)
    if mode == VOICE:
        return orders.Seek()
    if mode == SOURCE:
        return orders.ListenTo(_whole(command, 2, "source", 0, 255))
    return orders.ListenAt(_direction(command, 3, "azimuth"))


def _inform(command: Command) -> orders.Order:
    told = [not math.isnan(number) for number in command.numbers[1:]]
    count = sum(told)
    if not all(told[:count]) or not count:
        raise ConfigError("azimuths: expected at least one, and NaN only behind the last, got a gap")
    azimuths = tuple(_direction(command, index + 2, f"azimuth {index}") for index in range(count))
    for i, j in combinations(range(count), 2):
        if abs(difference(azimuths[i], azimuths[j])) < math.radians(APART_DEG):
            raise ConfigError(f"azimuths {i} and {j} are less than {APART_DEG:g} deg apart")
    first = _whole(command, 1, "first", -1, count - 1)
    return orders.Informed(azimuths, first=None if first < 0 else first)


def _turn(command: Command) -> orders.Order:
    return orders.TurnTo(_direction(command, 1, "heading"))


def _measure(command: Command) -> orders.Order:
    return orders.MeasureNoise(_number(command, 1, "time", 0, LONGEST_NOISE))


def _record(command: Command) -> Record:
    return Record(bool(_whole(command, 1, "start", 0, 1)))


def _stream(command: Command) -> StreamOrder:
    try:
        told = stream_command.command_of(command.numbers)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    if told.selection is Selected.NONE:
        return StreamOrder(on=False, number=told.number, address=told.address, port=told.port)
    if told.number is None and not told.address:
        raise ConfigError("address: expected one for a new stream, got 0.0.0.0")
    return StreamOrder(
        on=True,
        number=told.number,
        selection=_selection(told),
        gain_db=None if told.gain == MUTED_DB else told.gain,
        muted=None if told.gain is None else told.gain == MUTED_DB,
        address=told.address,
        port=told.port,
        codec=told.codec,
    )


def _selection(told: StreamCommand) -> Selection | None:
    if told.selection is None:
        return None
    what = What[told.selection.name]
    if what is What.SOURCE:
        return Selection(what, source=told.source)
    return Selection(what, azimuth=direction(told.azimuth)) if what is What.AZIMUTH else Selection(what)


def _enrol(command: Command) -> orders.Order:
    mode = _whole(command, 1, "mode", SOURCE, AZIMUTH)
    if command.numbers[4] != 1:
        raise ConfigError("consent: expected 1, since the talker must have agreed")
    name = _whole(command, 6, "name", 0, MOST_NAMES)
    return orders.Enrol(
        source=_whole(command, 2, "source", 0, 255) if mode == SOURCE else None,
        azimuth=_direction(command, 3, "azimuth") if mode == AZIMUTH else None,
        seconds=_number(command, 4, "time", 0, LONGEST_ENROLMENT),
        name=f"talker-{name}" if name else "",
        consent=True,
    )


READERS: dict[int, Callable[[Command], Asked]] = {
    ross.MAV_CMD_ROSS_EXPLORE: lambda command: orders.Explore(),
    ross.MAV_CMD_ROSS_LISTEN: _listen,
    INFORM: _inform,
    ross.MAV_CMD_ROSS_TURN: _turn,
    STOP: lambda command: orders.Stop(),
    ross.MAV_CMD_ROSS_CANCEL: lambda command: orders.Cancel(),
    ross.MAV_CMD_ROSS_PARK: lambda command: orders.Park(),
    ross.MAV_CMD_ROSS_MEASURE_NOISE: _measure,
    ross.MAV_CMD_ROSS_RECORD: _record,
    ross.MAV_CMD_ROSS_REARM: lambda command: orders.Rearm(),
    ross.MAV_CMD_ROSS_HOME: lambda command: orders.Home(),
    ross.MAV_CMD_ROSS_STREAM: _stream,
    ross.MAV_CMD_ROSS_ENROL: _enrol,
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
