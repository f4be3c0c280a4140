"""Turn by 90 degrees on pins with the real lgpio, run with a preloaded chip; prints what was planned, as JSON."""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from itertools import pairwise

import numpy as np

from ross_payload.actuators.motion import Trapezoid
from ross_payload.actuators.tb6600.pulse_segments import EDGE, Level, Played, PulseLine, Segment
from ross_payload.actuators.tb6600.step_edges import LineState, PulseTiming, train
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock

PIECE = 0.1  # [s]


class Stalls:
    """How much later than it wanted a thread has woken at most [s]: so long the computer did something else."""

    def __init__(self, clock: SystemClock) -> None:
        self.longest = 0.0
        self._clock = clock
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while True:
            begin = self._clock.now()
            time.sleep(0.005)
            self.longest = max(self.longest, self._clock.now() - begin - 0.005)


def main() -> None:
    clock = SystemClock()
    stalls = Stalls(clock)
    port = open_wire("pulses:lgpio:0:17,27,22,23", clock)
    start = clock.now()
    interface = PulseTiming(width=10e-6, setup=20e-6, hold=20e-6, period=67e-6)
    laid = train(
        Trapezoid(0.0, math.pi / 2, math.radians(225), 6.0), start, LineState(), interface, math.radians(0.1125)
    )
    enable = np.array([(start, PulseLine.ENABLE, True)], dtype=EDGE)
    edges = np.concatenate([enable, laid.edges])
    handed = start
    cuts = np.append(np.arange(start, laid.end, PIECE), laid.end)
    for begin, end in pairwise(cuts):
        piece = edges[(edges["time"] >= begin) & ((edges["time"] < end) | (end == laid.end))].copy()
        piece["time"] -= begin
        port.send(Segment(begin, end - begin, piece))
        handed = clock.now() if begin == cuts[0] else handed
    reports = []
    while len(reports) < len(cuts) - 1 and clock.now() < laid.end + 20:
        clock.sleep(0.01)
        arrived = port.receive()
        assert Level(PulseLine.HOME, True, arrived[-1].time) == arrived[-1]
        reports += [(report.end, clock.now()) for report in arrived if isinstance(report, Played)]
    port.close()
    planned = [(float(at), int(line), bool(level)) for at, line, level in edges]
    told = {"planned": planned, "reports": reports, "cuts": cuts.tolist()}
    json.dump(told | {"handed": handed - start, "stalled": stalls.longest}, sys.stdout)


if __name__ == "__main__":
    main()
