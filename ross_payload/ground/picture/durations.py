"""How long a mission has taken, and takes, about."""

from __future__ import annotations

from collections.abc import Mapping

from ross_payload.ground.picture.known import Payload

TURNING = 1.0  # [s] that one rotation takes
CHECKS = 2  # candidates that are visited
NAMES = "EXP_LEAD_IN", "EXP_UNIT", "EXP_MIN_ROT", "EXP_MAX_ROT", "XPL_CHECK", "XPL_RUN"


def elapsed(known: Payload) -> float | None:
    """Return the audio that the latest mission heard [s]; None: there was none, or its beginning was not heard."""
    if known.status is None or known.began is None:
        return None
    return (known.status.mission_time if known.ended is None else known.ended) - known.began


def expected(settings: Mapping[str, float]) -> float | None:
    """Return about how long a mission takes [s], when the explorer is certain half-way; None: not all is known.

    >>> expected(dict(zip(NAMES, (2.0, 3.0, 4.0, 12.0, 3.0, 30.0))))
    74.0
    >>> expected({"EXP_UNIT": 3.0}) is None
    True
    """
    if not all(name in settings for name in NAMES):
        return None
    lead_in, unit, least, most, check, run = (settings[name] for name in NAMES)
    return lead_in + (least + most) / 2 * (unit + TURNING) + CHECKS * (check + 2 * TURNING) + run
