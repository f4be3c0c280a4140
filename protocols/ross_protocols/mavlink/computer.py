"""How a computer is: ONBOARD_COMPUTER_STATUS, as far as both sides use it. SI units; None is not known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ross_protocols.mavlink.dialect import common

NO_LOAD, NO_HEAT, NO_SIZE = 255, 127, 2**32 - 1  # what is not known, on the wire
CORES, HEATS = 8, 8


@dataclass(frozen=True, slots=True)
class Computer:
    """One computer at one moment."""

    uptime: float  # [s]
    loads: tuple[float, ...] = ()  # of every core, 0 to 1
    temperature: float | None = None  # of the processor [degC]
    memory_used: float | None = None  # [bytes]
    memory_total: float | None = None  # [bytes]
    disk_used: float | None = None  # [bytes]
    disk_total: float | None = None  # [bytes]


def computer_of(message: Any) -> Computer | None:
    """Return what a message tells of a computer; None: it is no ONBOARD_COMPUTER_STATUS."""
    if message.get_msgId() != common.MAVLINK_MSG_ID_ONBOARD_COMPUTER_STATUS:
        return None
    heats = [heat for heat in message.temperature_core if heat != NO_HEAT]
    return Computer(
        uptime=message.uptime / 1e3,
        loads=tuple(load / 100 for load in message.cpu_cores if load != NO_LOAD),
        temperature=float(max(heats)) if heats else None,
        memory_used=_bytes(message.ram_usage),
        memory_total=_bytes(message.ram_total),
        disk_used=_bytes(message.storage_usage[0]),
        disk_total=_bytes(message.storage_total[0]),
    )


def computer_message(computer: Computer, time_usec: int) -> Any:
    """Return ONBOARD_COMPUTER_STATUS at a time [us]; cores beyond eight have no room.

    >>> computer_of(computer_message(Computer(uptime=5.0, loads=(0.25, 1.0)), 0)).loads
    (0.25, 1.0)
    """
    loads = [round(100 * min(max(load, 0.0), 1.0)) for load in computer.loads[:CORES]]
    heat = NO_HEAT if computer.temperature is None else round(min(max(computer.temperature, -128.0), 126.0))
    return common.MAVLink_onboard_computer_status_message(
        time_usec,
        uptime=round(computer.uptime * 1e3) % 2**32,
        type=0,
        cpu_cores=loads + [NO_LOAD] * (CORES - len(loads)),
        cpu_combined=[NO_LOAD] * 10,
        gpu_cores=[NO_LOAD] * 4,
        gpu_combined=[NO_LOAD] * 10,
        temperature_board=NO_HEAT,
        temperature_core=[heat] + [NO_HEAT] * (HEATS - 1),
        fan_speed=[-1] * 4,
        ram_usage=_mebi(computer.memory_used),
        ram_total=_mebi(computer.memory_total),
        storage_type=[NO_SIZE] * 4,
        storage_usage=[_mebi(computer.disk_used)] + [NO_SIZE] * 3,
        storage_total=[_mebi(computer.disk_total)] + [NO_SIZE] * 3,
        link_type=[NO_SIZE] * 6,
        link_tx_rate=[NO_SIZE] * 6,
        link_rx_rate=[NO_SIZE] * 6,
        link_tx_max=[NO_SIZE] * 6,
        link_rx_max=[NO_SIZE] * 6,
    )


def _bytes(wire: int) -> float | None:
    return None if wire == NO_SIZE else wire * 2.0**20


def _mebi(size: float | None) -> int:
    return NO_SIZE if size is None else min(round(size / 2**20), NO_SIZE - 1)
