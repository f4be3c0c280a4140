"""How the computer is that the payload runs on: read from /proc and /sys, and the disk on a thread of its own.

A network share, or a disk that is about to fail, may take minutes to say how full it is; the pump does not wait for it.

Not for lock-step simulation: what it says depends on the machine.
"""

from __future__ import annotations

import os
from concurrent.futures import Future, wait
from pathlib import Path

from ross_payload.named_paths import nearest_there
from ross_payload.transport.async_task import begin
from ross_protocols.mavlink.computer import Computer

PERIOD = 5.0  # [s] between two looks
DISK_TIMEOUT_S = 0.02  # that a look waits for the disk; what it says later is told by the next one
COLDEST, HOTTEST = 1.0, 125.0  # of what a thermal zone can mean [degC]
IDLE = 3, 4  # columns of /proc/stat: idle, and waiting for disks

Ticks = dict[str, tuple[int, int]]  # busy and all, by core


class ComputerReader:
    """Tells how the computer is, each time that it is called; loads are those since the call before.

    ``folder`` lies, or will lie, on the disk that matters; what cannot be read is not known.
    """

    def __init__(self, folder: Path, proc: Path = Path("/proc"), thermal: Path = Path("/sys/class/thermal")) -> None:
        self._folder, self._proc, self._thermal = folder, proc, thermal
        self._before: Ticks = {}
        self._asked: Future[os.statvfs_result] | None = None  # the disk

    def __call__(self) -> Computer:
        """Look at everything."""
        memory = _sizes(_text(self._proc / "meminfo"))
        total, free = memory.get("MemTotal"), memory.get("MemAvailable")
        disk_used, disk_total = self._disk()
        return Computer(
            uptime=float((_text(self._proc / "uptime").split() or ["0"])[0]),
            loads=self._loads(),
            temperature=max(self._heats(), default=None),
            memory_used=None if total is None or free is None else total - free,
            memory_total=total,
            disk_used=disk_used,
            disk_total=disk_total,
        )

    def _loads(self) -> tuple[float, ...]:
        before, self._before = self._before, _ticks(_text(self._proc / "stat"))
        pairs = [(before[core], ticks) for core, ticks in self._before.items() if core in before]
        return tuple((busy - was) / max(whole - all_, 1) for (was, all_), (busy, whole) in pairs)

    def _heats(self) -> list[float]:
        texts = (_text(zone / "temp").strip() for zone in sorted(self._thermal.glob("thermal_zone*")))
        heats = (int(text) / 1e3 for text in texts if text.lstrip("-").isdigit())
        return [heat for heat in heats if COLDEST <= heat <= HOTTEST]

    def _disk(self) -> tuple[float | None, float | None]:
        late = self._asked is not None
        asked = self._asked = self._asked or self._ask()
        if not late:
            wait([asked], DISK_TIMEOUT_S)
        if not asked.done():
            return None, None
        self._asked = self._ask() if late else None  # of a slow disk every look tells what the one before has asked
        try:
            disk = asked.result()
        except OSError:
            return None, None
        return float((disk.f_blocks - disk.f_bfree) * disk.f_frsize), float(disk.f_blocks * disk.f_frsize)

    def _ask(self) -> Future[os.statvfs_result]:
        return begin(lambda: os.statvfs(nearest_there(self._folder)))


def _ticks(stat: str) -> Ticks:
    """Read the lines ``cpu0 user nice system idle ...``.

    >>> _ticks("cpu0 10 0 5 80 5 0 0")
    {'cpu0': (15, 100)}
    """
    rows = (line.split() for line in stat.splitlines() if line.startswith("cpu") and line[3:4].isdigit())
    counted = {name: [int(number) for number in numbers[:8]] for name, *numbers in rows}
    return {name: (sum(row) - sum(row[place] for place in IDLE), sum(row)) for name, row in counted.items()}


def _sizes(meminfo: str) -> dict[str, float]:
    """Read the lines ``MemTotal:  16 kB`` [bytes].

    >>> _sizes("MemTotal:       2 kB")
    {'MemTotal': 2048.0}
    """
    rows = (line.split() for line in meminfo.splitlines())
    return {row[0].rstrip(":"): int(row[1]) * 1024.0 for row in rows if len(row) > 1 and row[1].isdigit()}


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""
