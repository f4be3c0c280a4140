"""The page that a ground station opens in a browser: aiohttp in front of what is known of the payloads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ross_payload.ground.page.server import serve

__all__ = ["serve"]


def __getattr__(name: str) -> Any:
    """Import the server when somebody serves: ``ross --help`` needs no aiohttp."""
    if name != "serve":
        raise AttributeError(f"module {__name__} has no {name}")
    from ross_payload.ground.page.server import serve  # noqa: PLC0415

    return serve
