"""The settings of the simulated grbl, with the defaults of grbl 1.1, and the homing cycle that follows them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from ross_protocols.grbl.protocol import ACCELERATION, MAX_RATE, STEPS, TRAVEL
from ross_sim.devices.grbl_gcode import GcodeError
from ross_sim.devices.grbl_planner import Axis, Motion

DEVIATION, DIRECTION, LOCATE, SEEK, PULL_OFF = 11, 23, 24, 25, 27
DEFAULTS: dict[int, float] = {
    **{0: 10, 1: 25, 2: 0, 3: 0, 4: 0, 5: 0, 6: 0, 10: 1, 11: 0.01, 12: 0.002, 13: 0, 20: 0, 21: 0, 22: 0, 23: 0},
    **{24: 25.0, 25: 500.0, 26: 250, 27: 1.0, 30: 1000, 31: 0, 32: 0},
}
OF_AN_AXIS = {STEPS: 250.0, MAX_RATE: 500.0, ACCELERATION: 10.0, TRAVEL: 200.0}
WITH_POINT = frozenset({11, 12, 24, 25, 27})


class Settings:
    """What ``$$`` lists.

    >>> settings = Settings({100: 8.8889}, 1)
    >>> settings.assign("120=112.5")
    >>> [*settings.lines()][-4:]
    ['$100=8.889', '$110=500.000', '$120=112.500', '$130=200.000']
    """

    def __init__(self, values: dict[int, float], n_axes: int) -> None:
        self._n_axes = n_axes
        each = {first + n: value for first, value in OF_AN_AXIS.items() for n in range(n_axes)}
        self._values = DEFAULTS | each | values

    def __getitem__(self, number: int) -> float:
        return self._values[number]

    def assign(self, text: str) -> None:
        """Obey a line like ``120=50``.

        Raises
        ------
        Refused
            With grbl's error number.
        """
        name, equals, amount = text.partition("=")
        try:
            number, value = int(name), float(amount)
        except ValueError as error:
            raise GcodeError(2 if equals else 3) from error
        if number not in self._values:
            raise GcodeError(3)
        if value < 0:
            raise GcodeError(4)
        self._values[number] = value

    def lines(self) -> list[str]:
        """Return what ``$$`` prints."""
        shown = {number: f"{value:.3f}" for number, value in self._values.items()}
        whole = {number for number in shown if number < STEPS} - WITH_POINT
        return [f"${number}={int(self[number]) if number in whole else shown[number]}" for number in sorted(shown)]

    @property
    def axes(self) -> list[Axis]:
        """Return what the planner needs."""
        return [Axis(*(self[first + n] for first in (STEPS, MAX_RATE, ACCELERATION))) for n in range(self._n_axes)]

    @property
    def travels(self) -> list[float]:
        """How far every axis can go [mm]."""
        return [self[TRAVEL + n] for n in range(self._n_axes)]

    def beyond(self, target: Sequence[int]) -> bool:
        """Whether a target [steps] lies outside the travel, which ends at 0."""
        places = [steps / axis.steps for steps, axis in zip(target, self.axes, strict=True)]
        return any(not -travel - 1e-6 <= place <= 1e-6 for place, travel in zip(places, self.travels, strict=True))


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
