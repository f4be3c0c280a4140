"""The ground side: it knows payloads only through MAVLink, live or recorded, and imports `ross_protocols` alone.

Scripts begin with `connect`, see docs/how-to/script-the-ground.md.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ross_payload.ground.errors import (
    GroundError,
    LinkLost,
    NoPayload,
    RefusedByPayload,
    RequestError,
    TaskCancelled,
    TaskFailed,
    UnknownParameter,
)

if TYPE_CHECKING:
    from ross_payload.ground.client.connection import connect
    from ross_payload.ground.client.payload import Payload

__all__ = [
    "GroundError", "LinkLost", "NoPayload", "Payload", "RefusedByPayload", "RequestError", "TaskCancelled",
    "TaskFailed", "UnknownParameter", "connect",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import the client when it is first asked for: ``ross --help`` needs none of it."""
    if name not in ("Payload", "connect"):
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module("ross_payload.ground.client.connection"), name)
