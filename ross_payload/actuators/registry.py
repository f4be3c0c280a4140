"""Opens what the configuration names, always inside the guard; lists what there is.

Options named ``max_speed_deg_s`` and ``max_acceleration_deg_s2`` mean the same in every back end that has them; they
are lowered to the guard's caps before the back end sees them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from ross_payload import config, plugins
from ross_payload.actuators.guard import Guard
from ross_payload.errors import PLUGIN_RAISES, ConfigError, PluginError, RossError
from ross_payload.interfaces import Actuator, Backend, Capabilities, Services
from ross_payload.plugin_calls import called

GROUP = "ross_payload.actuators"
ROUNDING_DEG = 1e-6  # of a travel that is told in radians
METHODS = ("command", "state", "stop", "home", "release", "poll", "__enter__", "__exit__")  # of an `Actuator`
CAPS = ("max_speed_deg_s", "max_acceleration_deg_s2")


@dataclass(frozen=True, slots=True)
class Description:
    """One back end in a list."""

    name: str
    origin: str  # module and object of the entry point
    usable: bool
    about: str  # one line: what it is, or why it cannot be used


def open_actuator(settings: config.Config, services: Services) -> Guard:
    """Make the actuator that the configuration names, inside its guard; enter it to open its wire.

    Raises
    ------
    ConfigError
        When the back end is unknown or broken, an option is wrong, the limits exclude all of its travel, or too little
        is left to explore without a pause.
    """
    kind = settings.actuator.kind
    backend, options = _backend(kind), checked_options(settings)
    try:
        opened = called(f"actuator '{kind}'", "open", lambda: backend.open(options, services))
        guard = Guard(_whole(kind, opened), settings.guard, services.clock, f"actuator '{kind}'")
    except RossError:
        raise
    except PLUGIN_RAISES as error:  # of a plug-in: it may raise anything
        raise PluginError(f"actuator '{kind}': open raised {error!r}") from error
    travel = math.degrees(guard.capabilities.upper - guard.capabilities.lower)
    if settings.explore.continuous and travel < config.LEAST_TRAVEL_DEG - ROUNDING_DEG:
        least = config.LEAST_TRAVEL_DEG
        raise ConfigError(f"explore.continuous: expected {kind} to turn at least {least:g} deg, got {travel:g}")
    return guard


def _whole(kind: str, actuator: Any) -> Actuator:
    """Return what a back end has opened; one that cannot be stopped shall not move.

    Raises
    ------
    PluginError
        When it lacks something that an `Actuator` has.
    """
    missing = [name for name in METHODS if not callable(getattr(actuator, name, None))]
    if not isinstance(getattr(actuator, "capabilities", None), Capabilities):
        missing.append("capabilities")
    if missing:
        lacks = f"{type(actuator).__name__} without {', '.join(missing)}"
        raise PluginError(f"actuator '{kind}': open: expected an Actuator, got {lacks}")
    return actuator  # type: ignore[no-any-return]


def checked_options(settings: config.Config) -> Any:
    """Return the back end's own ``Config`` from [actuator.options], its caps lowered to the guard's.

    Raises
    ------
    ConfigError
        When the back end is unknown or broken, an option is wrong, or it cannot turn as fast as it is to explore.
    """
    model = _backend(settings.actuator.kind).Config
    options = config.validated(model, settings.actuator.options, f"actuator.options of '{settings.actuator.kind}'")
    caps = {name: getattr(settings.guard, name) for name in CAPS if hasattr(options, name)}
    capped = options.model_copy(update={name: min(cap, getattr(options, name)) for name, cap in caps.items()})
    _check_turning(settings, getattr(capped, "max_speed_deg_s", settings.guard.max_speed_deg_s))
    return capped


def _check_turning(settings: config.Config, speed: float) -> None:
    """Refuse to explore without a pause faster than the actuator turns [deg/s]."""
    explore = settings.explore
    if explore.continuous and explore.rate_deg_s > speed:
        kind = settings.actuator.kind
        raise ConfigError(
            f"explore.rate_deg_s: expected at most {speed:g}, as fast as {kind} turns, got {explore.rate_deg_s:g}"
        )


def describe() -> list[Description]:
    """List every back end, sorted by name; one that is broken or lacks an extra says so and hurts no other."""
    return [_describe(name, point.value) for name, point in plugins.available(GROUP).items()]


def _describe(name: str, origin: str) -> Description:
    try:
        backend = _backend(name)
    except PluginError as error:
        return Description(name, origin, False, str(error))
    package = _missing_package(backend)
    if package:
        line = plugins.install_line(plugins.EXTRA_OF[package])
        return Description(name, origin, False, f"needs the package {package} (not in the simulator): {line}")
    lines = (getattr(backend, "about", None) or type(backend).__doc__ or "").strip().splitlines()
    return Description(name, origin, True, lines[0] if lines else "")


def _missing_package(backend: Backend) -> str:
    """Return the package that the usual wire of a back end needs and that is not installed; '' when none is."""
    port = getattr(backend.Config, "model_fields", {}).get("port")
    scheme = str(getattr(port, "default", "")).partition(":")[0]  # which is what the package is called
    return scheme if scheme in plugins.EXTRA_OF and find_spec(scheme) is None else ""


def _backend(name: str) -> Backend:
    backend = plugins.load(GROUP, name)
    if not (hasattr(backend, "Config") and callable(getattr(backend, "open", None))):
        raise PluginError(f"plug-in '{name}' is broken: expected an object with Config and open(config, services)")
    if not hasattr(backend.Config, "model_validate"):
        raise PluginError(f"plug-in '{name}' is broken: expected a pydantic model as Config, got {backend.Config!r}")
    return backend  # type: ignore[no-any-return]
