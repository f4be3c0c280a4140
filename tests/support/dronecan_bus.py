"""Nodes of the package `dronecan` on a bus of python-can, in real time: peers that we did not write."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import can
from dronecan.driver.common import AbstractDriver, CANFrame

import dronecan


class BusDriver(AbstractDriver):  # type: ignore[misc]
    """A bus of python-can for the package's `Node`; its own driver waits a thousand times too long."""

    def __init__(self, bus: can.BusABC) -> None:
        super().__init__()
        self._bus = bus

    def send(self, can_id: int, data: bytes, extended: bool = True, canfd: bool = False) -> None:
        assert not canfd
        self._bus.send(can.Message(arbitration_id=can_id, data=bytes(data), is_extended_id=extended))

    def receive(self, timeout: float | None = None) -> CANFrame | None:
        message = self._bus.recv(timeout)
        return message and CANFrame(message.arbitration_id, bytes(message.data), message.is_extended_id)

    def close(self) -> None:
        self._bus.shutdown()


def peer(channel: str, node_id: int, name: str = "org.example.peer") -> Any:
    """A node of the package on python-can's virtual bus of that channel; close it."""
    info = dronecan.uavcan.protocol.GetNodeInfo.Response(name=name)
    bus = can.Bus(channel, "virtual", ignore_config=True)
    mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
    return dronecan.node.Node(BusDriver(bus), node_id, node_info=info, mode=mode, catch_handler_exceptions=False)


def spin_until(node: Any, true: Callable[[], Any], within: float = 60.0) -> float:
    """Let the node live until something is true; how long that took [s]."""
    begin = time.monotonic()
    while not true():
        assert time.monotonic() - begin < within, f"not within {within} s"
        node.spin(0.005)
    return time.monotonic() - begin
