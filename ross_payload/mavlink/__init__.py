"""Every MAVLink port of the payload, and our own components behind them."""

from ross_payload.mavlink.component import Component, Received
from ross_payload.mavlink.link import LinkStatus
from ross_payload.mavlink.router import Router

__all__ = ["Component", "LinkStatus", "Received", "Router"]
