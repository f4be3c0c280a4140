"""Our own messages for the package `dronecan`, whose standard types stay the objects that others hold already."""

from __future__ import annotations

from pathlib import Path
from typing import Any

DSDL = Path(__file__).parents[2] / "protocols" / "dronecan" / "ross"
STATUS, SOURCES = 20854, 20855
SPACES = ("uavcan", "dronecan", "ardupilot", "com", "cuav", "thirdparty")


def load_ours(package: Any) -> None:
    """Load our DSDL; by itself that would empty the package's namespaces, or double its standard types."""
    before = {name: getattr(package, name) for name in SPACES}
    package.load_dsdl(str(DSDL), exclude_dist=True)
    for name, space in before.items():
        setattr(package, name, space)


def broadcast(package: Any, number: int) -> Any:
    """A type of broadcast by its number."""
    return package.DATATYPES[number, package.dsdl.CompoundType.KIND_MESSAGE]
