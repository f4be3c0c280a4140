"""A simulated CAN node on a bus of python-can, in real time."""

from __future__ import annotations

import threading
import time
from types import TracebackType
from typing import Any, Self

from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock

TICK = 0.002  # [s]


class LiveCanNode:
    """Lets a node live on a thread of its own; what the bus brings it takes."""

    def __init__(self, channel: str, node: Any) -> None:
        self.node = node
        self._port = open_wire(f"can:virtual:{channel}", SystemClock())
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._live, name="node")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()
        self._thread.join()
        self._port.close()

    def _live(self) -> None:
        begin = time.monotonic()
        while not self._over.wait(TICK):
            for frame in self._port.receive():
                self.node.on_frame(frame)
            for frame in self.node.live(round(time.monotonic() - begin, 3)):
                self._port.send(frame)
