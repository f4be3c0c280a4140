"""`ross device` that notes when a command is accepted: ``python far_end_probe.py KIND WIRE`` (WIRE may be empty).

Its status has the times [s, monotonic] at which its goal changed in place of the complaints.
"""

from __future__ import annotations

import json
import sys
from contextlib import ExitStack
from typing import Any

from ross_payload.config import Config
from ross_protocols.canopen import cia402
from ross_sim.devices.connections import Coupling, connected
from ross_sim.devices.device_command import KINDS
from ross_sim.devices.device_session import live
from ross_sim.devices.far_end import far_end_of

# What a driver's command changes at each far end.
GOALS = {
    "gimbal": lambda far_end: round(far_end.autopilot._aim, 6),
    "servo": lambda far_end: far_end.node._goal,
    "drive": lambda far_end: far_end.node.objects[cia402.TARGET],
    "grbl": lambda far_end: far_end.firmware.busy,
    "stepper": lambda far_end: len(far_end._edges) > 0,
}


class Noting:
    """A far end that looks at its goal after every tick."""

    def __init__(self, far_end: Any, kind: str) -> None:
        self._far_end = far_end
        self._goal, self._known = GOALS[kind], None
        self._accepted: list[float] = []
        self.epoch = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._far_end, name)

    def advance(self, now: float) -> None:
        self._far_end.advance(now)
        goal = self._goal(self._far_end)
        if goal != self._known:
            self._accepted.append(self.epoch + now)
            self._known = goal

    def complaints(self) -> list[str]:
        return [f"{time:.6f}" for time in self._accepted]


def main(kind: str, wire: str) -> None:
    config = Config.model_validate({"actuator": {"kind": KINDS[kind]}})
    far_end = far_end_of(config)
    noting = Noting(far_end, kind)

    def connect(epoch: float, stack: ExitStack) -> Coupling:
        noting.epoch = epoch
        connection = connected(config, wire or None, far_end, epoch=epoch, stack=stack)
        say(json.dumps({"kind": KINDS[kind], "wire": connection.address}))
        return connection.lead

    live(noting, connect, [], say)


def say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
