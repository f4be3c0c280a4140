"""Plug-ins are entry points, built-ins included: only the one asked for is imported. And what installs an extra."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ross_payload.errors import PLUGIN_RAISES, PluginError, unknown
from ross_payload.plugin_calls import called


def available(group: str) -> Mapping[str, EntryPoint]:
    """Return the entry points of a group by name, sorted; nothing is imported."""
    return {point.name: point for point in _along(group, tuple(sys.path))}


@cache
def _along(group: str, path: tuple[str, ...]) -> Sequence[EntryPoint]:
    """Ask every package along a path, which takes several milliseconds."""
    return sorted(entry_points(group=group), key=lambda point: point.name)


def load(group: str, name: str) -> Any:
    """Import one plug-in.

    Raises
    ------
    PluginError
        When the name is unknown (lists those that exist), two packages bring another plug-in of that name, a
        dependency is missing (names the extra) or the plug-in is broken (says how).
    """
    points = available(group)
    kind = group.rpartition(".")[2].removesuffix("s").replace("_", " ")
    if name not in points:
        raise PluginError(unknown(kind, name, points))
    named = {point.value: point for point in _along(group, tuple(sys.path)) if point.name == name}
    if len(named) > 1:
        found = " and ".join(f"{value} of {_package(point)}" for value, point in sorted(named.items()))
        raise PluginError(f"{kind} '{name}': expected one of that name, got {found}: rename or uninstall one")
    try:
        return called(f"plug-in '{name}'", "import", points[name].load)
    except ModuleNotFoundError as error:
        raise PluginError(_missing(name, error)) from error
    except PLUGIN_RAISES as error:  # a broken plug-in must not take the others with it
        raise PluginError(f"plug-in '{name}' ({points[name].value}) is broken: {error!r}") from error


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist else "no package"


def _missing(name: str, error: ModuleNotFoundError) -> str:
    module = (error.name or "").partition(".")[0]
    if module in EXTRA_OF:
        return f"'{name}' needs the package {module}: {install_line(EXTRA_OF[module])}"
    return f"plug-in '{name}' cannot be imported: {error}"


PACKAGE = "ross-payload"
REQUIREMENT = re.compile(r"(?P<package>[^;]+);.*extra == ['\"](?P<extra>\w+)['\"]")
EXTRA_OF = {  # by the module that an optional part imports
    "pyroomacoustics": "sim",
    "matplotlib": "sim",
    "espeakng_loader": "sim",
    "sounddevice": "capture",
    "can": "can",
    "serial": "serial",
    "lgpio": "gpio",
    "pyarrow": "study",
    "sklearn": "study",
    "aiohttp": "ground",
    "foxglove": "mcap",
    "mcap": "mcap",
    "aiortc": "stream",
    "av": "stream",
    "kaldi_native_fbank": "voice",
    "onnxruntime": "voice",
}


def install_line(extra: str) -> str:
    """Return the command that installs what an extra needs and is missing, for the Python that runs this.

    When nothing is missing all of it is named, since something of it does not work. The requirements are named rather
    than our own package, which may come from a clone or a wheel and be on no index.

    >>> install_line("serial").endswith("pip install 'pyserial>=3.5'")
    True
    """
    try:
        found = [match for text in requires(PACKAGE) or () if (match := REQUIREMENT.match(text))]
    except PackageNotFoundError:  # run from the sources without having been installed
        found = []
    packages = [match["package"].strip() for match in found if match["extra"] == extra]
    missing = [each for each in packages if not _is_installed(each)]
    named = [f"'{each}'" for each in missing or packages]
    return f"{pip()} install {' '.join(named or [f'.[{extra}]'])}"


def _is_installed(requirement: str) -> bool:
    name = re.match(r"[\w.-]+", requirement)
    try:
        return name is not None and bool(version(name[0]))
    except PackageNotFoundError:
        return False


def pip() -> str:
    """``pip`` where it is the one of the Python that runs this, else that Python's full path.

    An environment without pip, as a package carries, is written by that of the system.
    """
    ours = Path(sys.executable).with_name("pip")
    if shutil.which("pip") == str(ours):
        return "pip"
    return f"{sys.executable} -m pip" if find_spec("pip") else f"python3 -m pip --python {sys.executable}"
