"""Values as JSON has them: what is no number is null, what has a name goes by it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from enum import Enum
from numbers import Integral, Real
from typing import Any


def finite(value: Any) -> Any:
    """Return plain values with null for every number that is none, at any depth.

    >>> finite({"gain": math.inf, "rows": (1, 2.5)})
    {'gain': None, 'rows': [1, 2.5]}
    """
    if isinstance(value, Mapping):
        return {key: finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def are_finite(*values: Any) -> bool:
    """Whether all are numbers that a float can hold.

    >>> are_finite(1, 2.5), are_finite(math.nan), are_finite(10**400), are_finite("1")
    (True, False, False, False)
    """
    return all(isinstance(value, int | float) and abs(value) <= sys.float_info.max for value in values)


def encodable(text: str) -> str:
    r"""Return a text as UTF-8 can hold it: bytes of a file's name that are none are written as escapes.

    >>> encodable("fl\udcffight.tlog")
    'fl\\udcffight.tlog'
    """
    return text.encode("utf-8", "backslashreplace").decode()


def named(value: Any, number: Callable[[float], float] = float) -> Any:
    """Return plain values of anything: entries of an enumeration by name, dataclasses by field.

    ``number`` rounds the numbers that are finite.
    """
    if isinstance(value, Enum):
        return value.name.lower()
    if isinstance(value, Real) and not isinstance(value, Integral):
        return number(float(value)) if math.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [named(each, number) for each in value]
    if hasattr(value, "__dataclass_fields__"):
        return {name: named(getattr(value, name), number) for name in value.__dataclass_fields__}
    return value if value is None or isinstance(value, bool | int | str) else str(value)
