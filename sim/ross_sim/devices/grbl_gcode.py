"""The few words of G-code that a turntable needs, with the error numbers of grbl 1.1."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

_WORD = re.compile(r"([A-Z])([+-]?(?:\d+\.?\d*|\.\d+))")
_IGNORED = {"G17", "G40", "G49", "G54", "G80", "G94", "M0", "M2", "M3", "M5", "M8", "M9", "M30"}
_MOTION, _UNITS, _DISTANCE = {"G0", "G1"}, {"G20", "G21"}, {"G90", "G91"}
INCH = 25.4  # [mm]


class GcodeError(Exception):
    """A line that is not obeyed, with its error number."""

    def __init__(self, number: int) -> None:
        super().__init__(f"error:{number}")
        self.number = number


@dataclass(frozen=True, slots=True)
class Modes:
    """What stays from line to line."""

    motion: str = "G0"
    units: str = "G21"
    distance: str = "G90"
    feed: float = 0.0  # [mm/min]

    @property
    def scale(self) -> float:
        """A unit in [mm]."""
        return INCH if self.units == "G20" else 1.0


@dataclass(frozen=True, slots=True)
class GcodeLine:
    """One line, understood."""

    modes: Modes
    machine: bool = False  # G53
    axes: dict[str, float] = field(default_factory=dict)  # [mm]

    @property
    def feed(self) -> float:
        """How fast to go [mm/min]; rapids as fast as can be."""
        return float("inf") if self.modes.motion == "G0" else self.modes.feed


def understood(text: str, modes: Modes, axes: str, *, jog: bool = False) -> GcodeLine:
    """Read one line in the light of the modes.

    >>> understood("G91X1.5F100", Modes(), "XYZ", jog=True).axes
    {'X': 1.5}

    Raises
    ------
    Refused
        With grbl's error number.
    """
    words = _words(text)
    commands = [f"{letter}{value:g}" for letter, value in words if letter in "GM"]
    values = {letter: value for letter, value in words if letter not in "GM"}
    allowed = _UNITS | _DISTANCE | {"G53"} | (set() if jog else _MOTION | _IGNORED)
    if any(command not in allowed for command in commands):
        raise GcodeError(16 if jog else 20)
    modes = _changed(modes, commands, jog)
    feed = values.pop("F", None)
    if feed is not None:
        modes = replace(modes, feed=feed * modes.scale)
    elif jog:
        raise GcodeError(22)
    return _checked(GcodeLine(modes, "G53" in commands, _lengths(values, axes, modes.scale)), jog)


def _changed(modes: Modes, commands: list[str], jog: bool) -> Modes:
    return replace(
        modes,
        motion="G1" if jog else _last(commands, _MOTION, modes.motion),
        units=_last(commands, _UNITS, modes.units),
        distance=_last(commands, _DISTANCE, modes.distance),
    )


def _last(commands: list[str], group: set[str], before: str) -> str:
    return next((command for command in reversed(commands) if command in group), before)


def _words(text: str) -> list[tuple[str, float]]:
    found, end = [], 0
    while end < len(text):
        match = _WORD.match(text, end)
        if match is None:
            raise GcodeError(2 if text[end].isalpha() else 1)
        found.append((match[1], float(match[2])))
        end = match.end()
    letters = [letter for letter, _ in found if letter not in "GM"]
    if len(letters) != len(set(letters)):
        raise GcodeError(25)
    return found


def _lengths(values: dict[str, float], axes: str, scale: float) -> dict[str, float]:
    lengths = {letter: value * scale for letter, value in values.items() if letter in axes}
    if set(values) - set(lengths) - set("NST"):
        raise GcodeError(36)
    return lengths


def _checked(line: GcodeLine, jog: bool) -> GcodeLine:
    if jog and not line.axes:
        raise GcodeError(26)
    if line.axes and line.modes.motion == "G1" and line.modes.feed <= 0:
        raise GcodeError(22)
    return line
