"""The settings of the simulated grbl, with the defaults of grbl 1.1."""

from __future__ import annotations

from collections.abc import Sequence

from ross_protocols.grbl import ACCELERATION, MAX_RATE, STEPS, TRAVEL
from ross_sim.devices.grbl_gcode import Refused
from ross_sim.devices.grbl_planner import Axis

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
            raise Refused(2 if equals else 3) from error
        if number not in self._values:
            raise Refused(3)
        if value < 0:
            raise Refused(4)
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
