"""A simulated serial line for a payload in another process."""

from __future__ import annotations

from queue import SimpleQueue

from ross_payload.actuators.wires.serial import RawCodec
from ross_payload.interfaces import Port
from ross_sim.devices.wires import drained


class SerialSide:
    """Gives the line to a payload in another process: bytes take effect when they arrived.

    ``epoch`` is the world's time 0 on the Clock [s].
    """

    codec = RawCodec

    def __init__(self, port: Port, epoch: float) -> None:
        self._port = port
        self._epoch = epoch
        self._inbox: SimpleQueue[tuple[float, bytes]] = SimpleQueue()
        self._outbox: SimpleQueue[bytes] = SimpleQueue()
        self._waiting: list[tuple[float, bytes]] = []

    def arrived(self, frame: bytes, now: float) -> None:
        """Keep bytes with the world's time of their arrival."""
        self._inbox.put((now - self._epoch, frame))

    def due(self, now: float) -> list[bytes]:
        """Return what the device has said."""
        return drained(self._outbox)

    def exchange(self, begin: float) -> None:
        """Give the device what has arrived by then, and take what it says."""
        self._waiting += drained(self._inbox)
        while self._waiting and self._waiting[0][0] <= begin:
            self._port.send(self._waiting.pop(0)[1])
        for data in self._port.receive():
            self._outbox.put(data)
