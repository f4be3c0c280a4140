"""Every MAVLink port of the payload, and our own components behind them."""

from ross_payload.links.hub import Component, Heard, Links
from ross_payload.links.link import LinkStatus
from ross_payload.links.opening import open_port
from ross_payload.links.ports import Counts, LinkPort

__all__ = ["Component", "Counts", "Heard", "LinkPort", "LinkStatus", "Links", "open_port"]
