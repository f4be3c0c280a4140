"""How one number, angle or text is written on the wire and read back: the only place where angles turn around."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

FLOAT32_MAX = (2 - 2**-23) * 2.0**127
INT8_MIN, INT8_MAX, UINT8_MAX, UINT16_MAX = -128, 127, 255, 65535


class Pair(NamedTuple):
    """From a value to the wire and back."""

    there: Callable[[Any], Any]
    back: Callable[[Any], Any]


def wrap(angle: float) -> float:
    """Wrap an angle [rad] into (-pi, pi].

    >>> wrap(-math.pi) == math.pi
    True
    """
    return math.pi - (math.pi - angle) % (2 * math.pi)


def float32(number: float) -> float:
    """Return what fits into a float on the wire; beyond its range that is infinity, as IEEE 754 rounds."""
    return math.copysign(math.inf, number) if abs(number) > FLOAT32_MAX else float(number)


def clockwise(angle: float) -> float:
    """Turn a direction [rad] around, from counter-clockwise to clockwise or back, into (-pi, pi].

    >>> clockwise(math.pi / 2) == -math.pi / 2
    True
    """
    return wrap(-angle) if math.isfinite(angle) else angle


def bits(indices: tuple[int, ...]) -> int:
    """Return the bitmask of some indices.

    >>> bits((0, 2))
    5
    """
    return sum(1 << index for index in set(indices))


def indices(mask: int) -> tuple[int, ...]:
    """Return the indices in a bitmask, ascending.

    >>> indices(5)
    (0, 2)
    """
    return tuple(index for index in range(32) if mask >> index & 1)


def known(pair: Pair, invalid: float) -> Pair:
    """Write None as ``invalid`` (NaN is one), and read it as None."""

    def is_invalid(wire: float) -> bool:
        return math.isnan(wire) if math.isnan(invalid) else wire == invalid

    return Pair(
        lambda value: invalid if value is None else pair.there(value),
        lambda wire: None if is_invalid(wire) else pair.back(wire),
    )


def text(size: int) -> Pair:
    """Write ASCII, cut to ``size`` characters; what is not ASCII becomes a question mark."""
    return Pair(lambda value: value.encode("ascii", "replace")[:size], str)


def limited(lower: int, upper: int, scale: float = 1.0) -> Pair:
    """Write a number times ``scale`` as a whole one, at its limit when it is beyond.

    >>> pair = limited(0, 254, scale=1e3)
    >>> pair.there(0.1), pair.there(1.0), pair.back(100)
    (100, 254, 0.1)
    """
    return Pair(lambda number: round(min(max(scale * number, lower), upper)), lambda wire: wire / scale)


def member(kind: type) -> Pair:
    """Write an enumeration as its number; a number that it does not have stays a number."""
    numbers = {int(entry): entry for entry in kind}  # type: ignore[attr-defined]
    return Pair(int, lambda wire: numbers.get(wire, wire))


def padded(numbers: tuple[float, ...], size: int = 58) -> list[float]:
    """Fill an array up with zeros.

    >>> padded((1.0, 2.0), size=3)
    [1.0, 2.0, 0.0]
    """
    return [float32(number) for number in numbers] + [0.0] * (size - len(numbers))


def unpadded(wire: list[float]) -> tuple[float, ...]:
    """Return an array without the zeros at its end.

    >>> unpadded([0.0, 2.0, 0.0])
    (0.0, 2.0)
    """
    size = max((place + 1 for place, number in enumerate(wire) if number != 0.0), default=0)
    return tuple(wire[:size])


def compass(angle: float) -> float:
    """Return an angle [rad], counter-clockwise, as a compass shows it: degrees, clockwise, in [0, 360).

    >>> compass(math.pi / 2), compass(0.0)
    (270.0, 0.0)
    """
    return math.degrees(-angle) % 360.0


INTEGER = Pair(int, int)
FEW = Pair(lambda count: min(count, UINT8_MAX), int)  # the most stands for as many and more
NUMBER = Pair(float32, float)
DIRECTION = Pair(clockwise, clockwise)
TURNED = Pair(lambda angle: float32(0.0 - angle), lambda wire: 0.0 - wire)  # not wrapped, and never -0.0
MICRO = Pair(lambda seconds: float32(seconds * 1e6), lambda wire: wire / 1e6)
MILLI = Pair(lambda seconds: round(seconds * 1e3) % 2**32, lambda wire: wire / 1e3)  # wraps after 49 days
WRAPPED16 = Pair(lambda number: number % 65536, int)
WRAPPED32 = Pair(lambda number: number % 2**32, int)
MAYBE_COUNT = known(WRAPPED32, 2**32 - 1)
FRAME = Pair(lambda earth: 1 if earth else 2, lambda wire: wire == 1)
MEMBERS = Pair(bits, indices)
MAYBE_NUMBER, MAYBE_DIRECTION, MAYBE_TURNED = (known(pair, math.nan) for pair in (NUMBER, DIRECTION, TURNED))
ADDED_NUMBER = known(NUMBER, 0.0)  # of an extension: who does not know it yet sends nothing, which is 0
ADDED_TURNED = known(TURNED, 0.0)
MAYBE_INDEX = known(INTEGER, UINT8_MAX)
MAYBE_FEW = known(Pair(lambda count: min(count, UINT8_MAX - 1), int), UINT8_MAX)
MAYBE_DECIBEL = known(limited(INT8_MIN, INT8_MAX - 1), INT8_MAX)
MAYBE_MILLI16 = known(limited(0, UINT16_MAX - 1, scale=1e3), UINT16_MAX)
MAYBE_MEBI = known(Pair(lambda size: float32(size / 2**20), lambda wire: wire * 2**20), math.nan)
NUMBERS = Pair(lambda numbers: [float32(number) for number in numbers], tuple)
SHARES = Pair(lambda shares: [round(255 * share) for share in shares], lambda wire: tuple(x / 255 for x in wire))
PADDED = Pair(padded, unpadded)
