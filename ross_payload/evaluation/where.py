"""What the user knows about directions, as TDOAs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ross_payload.config import Config
from ross_payload.dsp.steering import tdoa
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real


def delays(
    config: Config,
    azimuths_deg: Sequence[float],
    heading_deg: float | None,
    tdoas_us: Sequence[float],
    sources: int | None,
) -> Real | None:
    """TDOAs [s] of every source, (n_sources,); None when nothing is known. Degrees are those of a compass, clockwise.

    Raises
    ------
    ConfigError
        When two ways of saying where the sources are contradict each other, or a number is impossible.

    Examples
    --------
    On the axis the sound takes 5 cm / 343 m/s = 145.8 us from one microphone to the other:

    >>> (1e6 * delays(Config(), [30.0, 120.0], 30.0, [], None)).round(1).tolist()
    [145.8, 0.0]
    """
    _consistent(azimuths_deg, heading_deg, tdoas_us, sources)
    array = config.array
    longest = array.spacing_m / array.speed_of_sound_m_s
    if azimuths_deg:
        heading = -math.radians(heading_deg or 0.0)
        return tdoa(-np.deg2rad(azimuths_deg), heading, array.spacing_m, array.speed_of_sound_m_s)
    for delay in tdoas_us:
        if not abs(delay) <= 1e6 * longest + 1:
            raise ConfigError(f"--tdoa-us: expected at most {1e6 * longest:.0f} us (d / v_p), got {delay:g}")
    return np.array(tdoas_us) * 1e-6 if tdoas_us else None


def _consistent(
    azimuths_deg: Sequence[float], heading_deg: float | None, tdoas_us: Sequence[float], sources: int | None
) -> None:
    if not np.isfinite([*azimuths_deg, heading_deg or 0.0, *tdoas_us]).all():
        raise ConfigError("--azimuth, --heading and --tdoa-us: expected finite numbers")
    if sum(map(bool, (azimuths_deg, tdoas_us, sources))) > 1:
        raise ConfigError("--azimuth, --tdoa-us, --sources: expected only one of them")
    if heading_deg is not None and not azimuths_deg:
        raise ConfigError("--heading: expected together with --azimuth")
