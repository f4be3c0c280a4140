"""Compile what a payload imports, beside its source, for an environment in which nothing can be written later.

TARGET/bin/python compile_used.py SITE PLACE: site-packages as it lies here, and where it will lie. The compiled files
are not compared with their source: installing may change its time. Without them a start takes three times as long.
"""

from __future__ import annotations

import importlib
import py_compile
import sys
from contextlib import suppress
from pathlib import Path

USED = ("service.check", "service.live", "service.health_command", "doctor.examination", "ground.web.app")
BEHIND_EXTRAS = ("ross_payload.audio.sound_card", "can.interfaces.socketcan", "serial", "aiortc")
OWN = ("ross_payload", "ross_protocols")


def main(site: str, place: str) -> None:
    """Import what is used, and compile all of it and all of our own."""
    for name in (*(f"ross_payload.{each}" for each in USED), *BEHIND_EXTRAS):
        with suppress(ImportError, OSError):  # an extra that is not there, a library of the system that comes later
            importlib.import_module(name)
    loaded = {getattr(module, "__file__", None) or "" for module in list(sys.modules.values())}
    own = {str(path) for name in OWN for path in Path(site, name).rglob("*.py")}
    for path in sorted(own | loaded):
        if path.startswith(site) and path.endswith(".py"):
            mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
            py_compile.compile(path, dfile=place + path.removeprefix(site), doraise=True, invalidation_mode=mode)


if __name__ == "__main__":
    main(*sys.argv[1:])
