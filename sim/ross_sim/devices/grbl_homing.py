"""The homing cycle of grbl for one axis."""

from __future__ import annotations

from collections.abc import Callable, Generator

from ross_sim.devices.grbl_planner import Motion
from ross_sim.devices.grbl_settings import DIRECTION, LOCATE, PULL_OFF, SEEK, Settings

NOT_CLEARED, NOT_FOUND = 8, 9  # alarms


def homing(motion: Motion, settings: Settings, n: int, switch: Callable[[], bool]) -> Generator[None, None, int]:
    """Seek the switch of axis ``n``, pull off, find it again slowly, pull off; the position is then known.

    Returns the alarm it ends with, 0 when all is well.
    """
    sign = -1 if int(settings[DIRECTION]) >> n & 1 else 1
    travel, pull_off, steps = settings.travels[n], settings[PULL_OFF], motion.axes[n].steps
    for rate, search in ((settings[SEEK], 1.5 * travel), (settings[LOCATE], 5 * pull_off)):
        _go(motion, n, sign * search, rate)
        while motion.moving and not switch():
            yield
        found = switch()
        motion.clear()
        _go(motion, n, -sign * pull_off, rate)
        while motion.moving:
            yield
        if switch() or not found:
            return NOT_CLEARED if found else NOT_FOUND
    place = list(motion.position)
    place[n] = round((-pull_off if sign > 0 else pull_off - travel) * steps)
    motion.place(place)
    return 0


def _go(motion: Motion, n: int, distance: float, rate: float) -> None:
    target = list(motion.position)
    target[n] += round(distance * motion.axes[n].steps)
    motion.add(target, rate)
