"""What separators and explorers of others return: whether it fits, and the same in Python's own types.

Numbers of NumPy and lists are as good as Python's own and tuples, which is what everybody behind the checks gets.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ross_payload.errors import PluginError
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Groups, Observation, Quality, Scene

MOST_SOURCES = 16  # of an estimate; planning costs more with each
MOST_TEXT = 120  # characters of what a plug-in has raised or returned
LOUDEST = float(np.finfo(np.float32).max)
LISTS, WHOLE, TRUTH = (tuple, list, np.ndarray), (int, np.integer), (bool, np.bool_)


def groups_of(where: str, returned: Any, shape: tuple[int, ...], scene: Scene) -> Groups:
    """The groups that a separator has returned, their signals (n_groups, *shape).

    Raises
    ------
    PluginError
        When it is something else; ``where`` names the plug-in and its method.
    """
    _expect_none(where, _fault_of_groups(returned, shape, scene))
    return _plain_groups(returned)


def observation_of(where: str, returned: Any) -> Observation:
    """What an explorer has observed; errors as of `groups_of`."""
    _expect_none(where, _fault_of_observation(returned))
    return _plain_observation(returned)


def estimate_of(where: str, returned: Any) -> Estimate:
    """What an explorer believes; errors as of `groups_of`."""
    _expect_none(where, _fault_of_estimate(returned))
    return _plain_estimate(returned)


def short(value: Any) -> str:
    """A value in some words, on one line."""
    return " ".join(repr(value).split())[:MOST_TEXT]


def _expect_none(where: str, fault: str) -> None:
    if fault:
        raise PluginError(f"{where}: {fault}")


def _fault_of_groups(groups: Any, shape: tuple[int, ...], scene: Scene) -> str:
    """What is wrong with the result of a separator, in words; empty when nothing is."""
    if not isinstance(groups, Groups):
        return f"expected Groups, got {type(groups).__name__}"
    fault = _fault_of_array("signals", groups.signals, "c", (None, *shape))
    if fault:
        return fault
    if max(np.abs(groups.signals.real).max(initial=0), np.abs(groups.signals.imag).max(initial=0)) > LOUDEST:
        return "signals: expected numbers that single precision can hold, got larger ones"
    n, most = len(groups.signals), max(scene.n_sources, 2)
    if not min(scene.n_sources, 1) <= n <= most:
        return f"expected 1 to {most} groups, got {n}"
    if groups.masks is not None:
        fault = _fault_of_array("masks", groups.masks, "f", (n, *shape))
    return fault or _fault_of_members(groups.members, n, scene.n_sources) or _fault_of_words(groups, n)


def _fault_of_members(members: Any, n: int, n_sources: int) -> str:
    """What is wrong with the members of ``n`` groups."""
    if not isinstance(members, LISTS) or not all(isinstance(group, LISTS) for group in members):
        return f"members: expected a tuple of indices for every group, got {short(members)}"
    if len(members) != n:
        return f"expected members of {n} groups, got {len(members)}"
    if all(isinstance(source, WHOLE) and 0 <= source < n_sources for group in members for source in group):
        return ""
    return f"expected members from 0 to {n_sources - 1}, got {short(members)}"


def _fault_of_words(groups: Groups, n: int) -> str:
    """What is wrong with what a separator says about ``n`` groups."""
    for name, text in (("method", groups.method), ("why", groups.why)):
        if not isinstance(text, str):
            return f"{name}: expected a text, got {short(text)}"
    quality = groups.quality
    if not isinstance(quality, LISTS) or len(quality) not in (0, n):
        got = len(quality) if isinstance(quality, LISTS) else type(quality).__name__
        return f"expected the quality of {n} groups or of none, got {got}"
    for each in quality:
        if not isinstance(each, Quality) or not (_finite(each.si_sdr) and _finite(each.si_sdri)):
            return f"quality: expected finite numbers of type Quality, got {short(each)}"
    return ""


def _plain_groups(groups: Groups) -> Groups:
    members = tuple(tuple(int(source) for source in group) for group in groups.members)
    quality = tuple(Quality(float(each.si_sdr), float(each.si_sdri)) for each in groups.quality)
    return replace(groups, members=members, quality=quality)


def _fault_of_observation(seen: Any) -> str:
    if not isinstance(seen, Observation):
        return f"expected Observation, got {type(seen).__name__}"
    if not (_finite(seen.heading) and _finite(seen.weight) and seen.weight >= 0):
        return f"expected a finite heading and a weight of 0 or more, got {seen.heading!r} and {seen.weight!r}"
    if not isinstance(seen.peaks, LISTS) or not all(map(_finite, seen.peaks)):
        return f"peaks: expected a tuple of finite ITDs [s], got {short(seen.peaks)}"
    if not _finite_or_none(seen.height):
        return f"expected a finite height or None, got {short(seen.height)}"
    return _fault_of_array("grid", seen.grid, "f", (None,)) or _fault_of_array(
        "density", seen.density, "f", seen.grid.shape
    )


def _plain_observation(seen: Observation) -> Observation:
    return replace(
        seen,
        heading=float(seen.heading),
        weight=float(seen.weight),
        peaks=tuple(map(float, seen.peaks)),
        height=_float_or_none(seen.height),
    )


def _fault_of_estimate(believed: Any) -> str:
    if not isinstance(believed, Estimate):
        return f"expected Estimate, got {type(believed).__name__}"
    if not isinstance(believed.sources, LISTS):
        return f"sources: expected a tuple, got {type(believed.sources).__name__}"
    if believed.k > MOST_SOURCES:
        return f"expected at most {MOST_SOURCES} sources, got {believed.k}"
    fault = next(filter(None, map(_fault_of_source, believed.sources)), "")
    if not fault and not (isinstance(believed.certain, TRUTH) and _finite_or_none(believed.directness)):
        told = f"{short(believed.certain)} and {short(believed.directness)}"
        fault = f"expected certain true or false and a finite directness or None, got {told}"
    if not fault and believed.rival is not None:
        fault = _fault_of_estimate(believed.rival)
        fault = fault and f"rival: {fault}"
    return fault


def _fault_of_source(source: Any) -> str:
    if not isinstance(source, SourceEstimate):
        return f"expected sources of type SourceEstimate, got {type(source).__name__}"
    values = source.azimuth, source.sigma, source.confidence, source.weight
    if not all(map(_finite, values)) or source.sigma < 0 or not 0 <= source.confidence <= 1:
        return f"expected finite numbers, sigma >= 0 and confidence from 0 to 1, got {source}"
    if not (_finite_or_none(source.elevation) and _finite_or_none(source.elevation_sigma)):
        return f"expected a finite elevation and its sigma, or None, got {source}"
    if source.nominal_sigma is not None and not (_finite(source.nominal_sigma) and source.nominal_sigma >= 0):
        return f"expected nominal_sigma >= 0 or None, got {source}"
    if not isinstance(source.resolved, TRUTH):
        return f"expected resolved true or false, got {source}"
    return ""


def _plain_estimate(believed: Estimate) -> Estimate:
    return replace(
        believed,
        sources=tuple(map(_plain_source, believed.sources)),
        certain=bool(believed.certain),
        directness=_float_or_none(believed.directness),
        rival=None if believed.rival is None else _plain_estimate(believed.rival),
    )


def _plain_source(source: SourceEstimate) -> SourceEstimate:
    return replace(
        source,
        azimuth=float(source.azimuth),
        sigma=float(source.sigma),
        confidence=float(source.confidence),
        resolved=bool(source.resolved),
        weight=float(source.weight),
        elevation=_float_or_none(source.elevation),
        elevation_sigma=_float_or_none(source.elevation_sigma),
        nominal_sigma=_float_or_none(source.nominal_sigma),
    )


def _fault_of_array(what: str, values: Any, kind: str, shape: tuple[int | None, ...]) -> str:
    """What is wrong with an array; ``kind`` is that of its dtype, None in ``shape`` is any length."""
    if not isinstance(values, np.ndarray) or values.dtype.kind != kind:
        got = f"dtype {values.dtype}" if isinstance(values, np.ndarray) else type(values).__name__
        return f"{what}: expected an array of {'complex' if kind == 'c' else 'real'} numbers, got {got}"
    fits = values.ndim == len(shape) and all(m in (None, n) for m, n in zip(shape, values.shape, strict=True))
    if not fits:
        wanted = ", ".join("n" if length is None else str(length) for length in shape)
        return f"{what}: expected shape ({wanted}), got {values.shape}"
    return "" if np.isfinite(values).all() else f"{what}: expected finite numbers, got NaN or infinity"


def _finite(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and bool(np.isfinite(value))


def _finite_or_none(value: Any) -> bool:
    return value is None or _finite(value)


def _float_or_none(value: float | None) -> float | None:
    return None if value is None else float(value)
