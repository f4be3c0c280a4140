"""The extras of the package, and the command that installs what one of them needs."""

from __future__ import annotations

import re
import shutil
import sys
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

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
    "aiohttp": "ground",
    "foxglove": "mcap",
}


def install_line(extra: str) -> str:
    """Return the command that installs what an extra needs, for the Python that runs this.

    The requirements are named rather than our own package, which may come from a clone or a wheel and be on no index.

    >>> install_line("serial").endswith("pip install 'pyserial>=3.5'")
    True
    """
    try:
        found = [match for text in requires(PACKAGE) or () if (match := REQUIREMENT.match(text))]
    except PackageNotFoundError:  # run from the sources without having been installed
        found = []
    packages = [f"'{match['package'].strip()}'" for match in found if match["extra"] == extra]
    return f"{_pip()} install {' '.join(packages or [f'.[{extra}]'])}"


def _pip() -> str:
    """``pip`` where it is the one of the Python that runs this, else that Python's full path."""
    ours = Path(sys.executable).with_name("pip")
    return "pip" if shutil.which("pip") == str(ours) else f"{sys.executable} -m pip"
