"""Separators and explorers of others: checked when they are loaded and whenever they are used.

What a plug-in does wrong becomes one `PluginError` that names it; the mission ends with it as a fault.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from ross_payload import plugins
from ross_payload.errors import PLUGIN_RAISES, NotLive, PluginError, RossError
from ross_payload.events import Estimate
from ross_payload.interfaces import (
    Complex,
    Explorer,
    Groups,
    LiveSeparator,
    Observation,
    Real,
    ReconsideringExplorer,
    Scene,
    Separator,
    TurningExplorer,
)
from ross_payload.plugin_calls import called
from ross_payload.plugin_results import MOST_TEXT, estimate_of, groups_of, observation_of

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
        return groups_of(f"{self._who}: batch", groups, spectrogram.shape[1:], scene)

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
        """Hear one frame (2, n_freqs), of which the plug-in gets a copy: others hear it, too."""
        returned = _called(self._who, "step", lambda: self._separator.step(state, frame.copy(), scene))
        if not isinstance(returned, tuple) or len(returned) != len(("state", "groups")):
            raise PluginError(f"{self._who}: step: expected a state and groups, got {type(returned).__name__}")
        state, groups = returned
        return state, groups_of(f"{self._who}: step", groups, (*frame.shape[1:], 1), scene)

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

        return observation_of(f"{self._who}: observe", _called(self._who, "observe", call))

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

        return observation_of(f"{self._who}: observe_turning", _called(self._who, "observe_turning", call))

    def estimate(self, observations: Sequence[Observation]) -> Estimate:
        """Estimate K and all azimuths from every orientation heard so far."""
        believed = _called(self._who, "estimate", lambda: self._explorer.estimate(observations))
        return estimate_of(f"{self._who}: estimate", believed)

    @property
    def reconsiders(self) -> bool:
        """Whether the plug-in has a method ``reconsider``."""
        return callable(getattr(self._explorer, "reconsider", None))

    def reconsider(self, observations: Sequence[Observation], believed: Estimate) -> Estimate | None:
        """Explain all observations by the sources that are believed in, if that can be."""
        plugin: ReconsideringExplorer = self._explorer  # type: ignore[assignment]  # one that reconsiders
        renewed = _called(self._who, "reconsider", lambda: plugin.reconsider(observations, believed))
        return None if renewed is None else estimate_of(f"{self._who}: reconsider", renewed)


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
        return called(who, method, call)
    except RossError as error:  # one line already
        raise PluginError(f"{who}: {error}") from error
    except PLUGIN_RAISES as error:  # of others: it may raise anything
        text = " ".join(str(error).split())[:MOST_TEXT]
        raise PluginError(f"{who}: {method} raised {type(error).__name__}: {text}") from error
