"""Separators and explorers of others: checked when they are loaded and whenever they are used.

What a plug-in does wrong becomes one `PluginError` that names it; the mission ends with it as a fault. Numbers of NumPy
and lists are as good as Python's own and tuples, which is what everybody behind the checks gets.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from ross_payload import plugins
from ross_payload.errors import NotLive, PluginError, RossError
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import (
    Complex,
    Explorer,
    Groups,
    LiveSeparator,
    Observation,
    Quality,
    Real,
    ReconsideringExplorer,
    Scene,
    Separator,
    TurningExplorer,
)

MOST_SOURCES = 16  # of an estimate; planning costs more with each
MOST_TEXT = 120  # characters of what a plug-in has raised or returned
LOUDEST = float(np.finfo(np.float32).max)
LISTS, WHOLE, TRUTH = (tuple, list, np.ndarray), (int, np.integer), (bool, np.bool_)

T = TypeVar("T")


def load_separator(name: str) -> CheckedSeparator:
    """Load a separator by the name of its entry point.

    Raises
    ------
    PluginError
        When there is none of that name, it cannot be imported, or it is no separator; says what was expected.
    """
    plugin = plugins.load("ross_payload.separators", name)
    who = f"separator '{name}'"
    _expect_methods(who, plugin, {"batch": ("spectrogram", "scene")})
    return CheckedSeparator(who, plugin)


def checked_explorer(name: str, make: Callable[[], Any]) -> CheckedExplorer:
    """Make an explorer and check that it is one.

    Raises
    ------
    PluginError
        When it cannot be made or lacks a method; says what was expected.
    """
    who = f"explorer '{name}'"
    plugin = _called(who, "make", make)
    observed = ("spectrogram", "frequencies", "heading", "noise_psd")
    _expect_methods(who, plugin, {"observe": observed, "estimate": ("observations",)})
    return CheckedExplorer(who, plugin)


class CheckedSeparator:
    """A separator whose every result is checked: every method raises a PluginError when one does not fit.

    Parameters
    ----------
    who
        The plug-in in words, for messages.
    separator
        The plug-in.
    """

    def __init__(self, who: str, separator: Separator) -> None:
        self.name = separator.name
        self._who = who
        self._separator = separator

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        """Separate a whole recording; spectrogram (2, n_freqs, n_frames)."""
        groups = _called(self._who, "batch", lambda: self._separator.batch(spectrogram, scene))
        fault = _fault_of_groups(groups, spectrogram.shape[1:], scene)
        return _plain_groups(_faultless(self._who, "batch", groups, fault))

    def live(self, lookahead: int = 1) -> LiveSeparator:
        """Return the same separator frame by frame, checked as this one is.

        Raises
        ------
        NotLive
            When the plug-in has no method ``live``.
        PluginError
            When what that returns is no live separator.
        """
        make = getattr(self._separator, "live", None)
        if make is None:
            raise NotLive(f"{self._who}: it separates whole recordings only, and cannot be listened to live")
        plugin = _called(self._who, "live", lambda: make(lookahead))
        learnt = ("window", "scene", "before")
        methods = {"start": ("scene",), "step": ("state", "frame", "scene"), "learn": learnt}
        _expect_methods(self._who, plugin, {**methods, "renewed": ("state", "learnt")})
        if getattr(plugin, "lookahead", None) != lookahead:
            told = getattr(plugin, "lookahead", None)
            raise PluginError(f"{self._who}: live: expected a lookahead of {lookahead}, got {told!r}")
        return CheckedLiveSeparator(self._who, plugin)


class CheckedLiveSeparator:
    """A live separator whose every result is checked; parameters and errors are those of `CheckedSeparator`."""

    def __init__(self, who: str, separator: LiveSeparator) -> None:
        self.name = separator.name
        self.lookahead = separator.lookahead
        self._who = who
        self._separator = separator

    def start(self, scene: Scene) -> Any:
        """Return the state in which nothing was heard yet."""
        return _called(self._who, "start", lambda: self._separator.start(scene))

    def step(self, state: Any, frame: Complex, scene: Scene) -> tuple[Any, Groups]:
        """Hear one frame (2, n_freqs)."""
        returned = _called(self._who, "step", lambda: self._separator.step(state, frame, scene))
        if not isinstance(returned, tuple) or len(returned) != len(("state", "groups")):
            raise PluginError(f"{self._who}: step: expected a state and groups, got {type(returned).__name__}")
        state, groups = returned
        fault = _fault_of_groups(groups, (*frame.shape[1:], 1), scene)
        return state, _plain_groups(_faultless(self._who, "step", groups, fault))

    def learn(self, window: Complex, scene: Scene, before: Any = None) -> Any:
        """Return what the latest frames (2, n_freqs, n_frames) tell about the sources."""
        return _called(self._who, "learn", lambda: self._separator.learn(window, scene, before))

    def renewed(self, state: Any, learnt: Any) -> Any:
        """Return the state that goes on with what was learnt."""
        return _called(self._who, "renewed", lambda: self._separator.renewed(state, learnt))


class CheckedExplorer:
    """An explorer whose every result is checked: every method raises a PluginError when one does not fit.

    Parameters
    ----------
    who
        The plug-in in words, for messages.
    explorer
        The plug-in.
    """

    def __init__(self, who: str, explorer: Explorer) -> None:
        self.name = explorer.name
        self._who = who
        self._explorer = explorer

    def observe(
        self,
        spectrogram: Complex,
        frequencies: Real,
        heading: float,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
    ) -> Observation:
        """Condense one orientation; spectrogram (2, n_freqs, n_frames), frequencies [Hz], heading [rad]."""

        def call() -> Observation:
            return self._explorer.observe(spectrogram, frequencies, heading, noise_psd, frame_period=frame_period)

        seen = _called(self._who, "observe", call)
        return _plain_observation(_faultless(self._who, "observe", seen, _fault_of_observation(seen)))

    @property
    def hears_turning(self) -> bool:
        """Whether the plug-in has a method ``observe_turning``."""
        return callable(getattr(self._explorer, "observe_turning", None))

    def observe_turning(
        self,
        spectrogram: Complex,
        frequencies: Real,
        headings: Real,
        noise_psd: Real | None,
        *,
        frame_period: float | None = None,
        skip: int = 0,
    ) -> Observation:
        """Condense a period in which the array turned; headings [rad] of the frames, (n_frames,)."""
        plugin: TurningExplorer = self._explorer  # type: ignore[assignment]  # one that hears_turning

        def call() -> Observation:
            return plugin.observe_turning(
                spectrogram, frequencies, headings, noise_psd, frame_period=frame_period, skip=skip
            )

        seen = _called(self._who, "observe_turning", call)
        return _plain_observation(_faultless(self._who, "observe_turning", seen, _fault_of_observation(seen)))

    def estimate(self, observations: Sequence[Observation]) -> Estimate:
        """Estimate K and all azimuths from every orientation heard so far."""
        believed = _called(self._who, "estimate", lambda: self._explorer.estimate(observations))
        return _plain_estimate(_faultless(self._who, "estimate", believed, _fault_of_estimate(believed)))

    @property
    def reconsiders(self) -> bool:
        """Whether the plug-in has a method ``reconsider``."""
        return callable(getattr(self._explorer, "reconsider", None))

    def reconsider(self, observations: Sequence[Observation], believed: Estimate) -> Estimate | None:
        """Explain all observations by the sources that are believed in, if that can be."""
        plugin: ReconsideringExplorer = self._explorer  # type: ignore[assignment]  # one that reconsiders
        renewed = _called(self._who, "reconsider", lambda: plugin.reconsider(observations, believed))
        if renewed is None:
            return None
        return _plain_estimate(_faultless(self._who, "reconsider", renewed, _fault_of_estimate(renewed)))


def _expect_methods(who: str, plugin: Any, methods: dict[str, tuple[str, ...]]) -> None:
    """Refuse what is no object with a name and these methods."""
    if isinstance(plugin, type):
        raise PluginError(f"{who}: expected an object, got the class {plugin.__name__}: write {plugin.__name__}()")
    name = getattr(plugin, "name", None)
    if not isinstance(name, str) or not name:
        raise PluginError(f"{who}: expected a text `name`, got {name!r}")
    for method, parameters in methods.items():
        expected = f"{method}({', '.join(parameters)})"
        call = getattr(plugin, method, None)
        if not callable(call):
            raise PluginError(f"{who}: expected a method {expected}, got {call!r}")
        keywords = {"frame_period": None} if method == "observe" else {}
        try:
            inspect.signature(call).bind(*parameters, **keywords)
        except TypeError as error:
            raise PluginError(f"{who}: expected {expected}, got {method}{inspect.signature(call)}: {error}") from error


def _called(who: str, method: str, call: Callable[[], T]) -> T:
    """Call a plug-in; whatever it raises becomes one line."""
    try:
        return call()
    except RossError as error:  # one line already
        raise PluginError(f"{who}: {error}") from error
    except (Exception, SystemExit) as error:  # of others: it may raise anything
        text = " ".join(str(error).split())[:MOST_TEXT]
        raise PluginError(f"{who}: {method} raised {type(error).__name__}: {text}") from error


def _faultless(who: str, method: str, returned: T, fault: str) -> T:
    if fault:
        raise PluginError(f"{who}: {method}: {fault}")
    return returned


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
        return f"members: expected a tuple of indices for every group, got {_short(members)}"
    if len(members) != n:
        return f"expected members of {n} groups, got {len(members)}"
    if all(isinstance(source, WHOLE) and 0 <= source < n_sources for group in members for source in group):
        return ""
    return f"expected members from 0 to {n_sources - 1}, got {_short(members)}"


def _fault_of_words(groups: Groups, n: int) -> str:
    """What is wrong with what a separator says about ``n`` groups."""
    for name, text in (("method", groups.method), ("why", groups.why)):
        if not isinstance(text, str):
            return f"{name}: expected a text, got {_short(text)}"
    quality = groups.quality
    if not isinstance(quality, LISTS) or len(quality) not in (0, n):
        got = len(quality) if isinstance(quality, LISTS) else type(quality).__name__
        return f"expected the quality of {n} groups or of none, got {got}"
    for each in quality:
        if not isinstance(each, Quality) or not (_finite(each.si_sdr) and _finite(each.si_sdri)):
            return f"quality: expected finite numbers of type Quality, got {_short(each)}"
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
        return f"peaks: expected a tuple of finite ITDs [s], got {_short(seen.peaks)}"
    if not _finite_or_none(seen.height):
        return f"expected a finite height or None, got {_short(seen.height)}"
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
        told = f"{_short(believed.certain)} and {_short(believed.directness)}"
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


def _short(value: Any) -> str:
    return " ".join(repr(value).split())[:MOST_TEXT]
