"""Driver and device in two processes, in real time: how soon a command counts, is seen, and what the driver costs.

The normal run has limits for a computer that is busy with other things; the soak run has the true ones.
"""

from __future__ import annotations

import json
import math
import random
import resource
import statistics
import sys
import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from device_bench import PERIOD, SERIAL_OVER_TCP, driver, ross
from ports import free_port

pytest.importorskip("can")

PROBE = (sys.executable, str(Path(__file__).parents[1] / "support" / "far_end_probe.py"))
FRAME = 0.020  # between two set-points [s]
STEP = math.radians(3)  # of a move
PATIENT = {"stepper": {"ahead_ms": 100.0}}  # on a computer that is busy
QUICK = ("gimbal", "servo", "drive", "grbl", "stepper")
CASES = (*QUICK, "servo-hub", "drive-hub")


@dataclass
class Meter:
    """What the pump's calls cost."""

    cpu: float = 0.0  # [s]
    switches: int = 0
    calls: int = 0

    def around(self, call):
        """The same call, measured on the thread that makes it."""

        def measured():
            begin = time.thread_time()
            call()
            self.cpu += time.thread_time() - begin
            self.switches = resource.getrusage(resource.RUSAGE_THREAD).ru_nvcsw
            self.calls += 1

        return measured

    def over(self, do):
        """Share of a core and voluntary switches per second while something is done."""
        begin, cpu, switches = time.monotonic(), self.cpu, self.switches
        do()
        passed = time.monotonic() - begin
        return (self.cpu - cpu) / passed, (self.switches - switches) / passed


@contextmanager
def bench(case, folder, options):
    """A device that notes, a driver that is ready, and the meter of its pump."""
    kind, _, hub = case.partition("-")
    with ExitStack() as stack:
        wire = {"gimbal": f"udpout:127.0.0.1:{free_port()}", "grbl": SERIAL_OVER_TCP}.get(kind, "")
        if hub:
            there = stack.enter_context(ross(folder, "hub", "--listen", "tcp:127.0.0.1:0", "--json"))
            wire = f"{there.told['hub']}:can0"
        process = stack.enter_context(ross(folder, kind, wire, before=PROBE))
        one = stack.enter_context(driver(process.told, pump=False, **options))
        meter = Meter()
        stack.callback(one.clock.every(PERIOD, meter.around(one.poll)))
        one.ready()
        yield process, one, meter


def moved(process, one, chance):
    """Command a small move at any moment; how long until it was accepted, and until it was seen [s]."""
    time.sleep(chance.uniform(0.0, 0.05))
    rest, resolution = one.actuator.state().angle, one.actuator.capabilities.resolution
    begin = time.monotonic()
    one.actuator.command(rest + math.copysign(STEP, -rest))
    end = begin + 5.0
    while abs(one.actuator.state().angle - rest) < resolution * 0.999:
        assert time.monotonic() < end, one.actuator.state()
        time.sleep(0.001)
    seen = time.monotonic() - begin
    one.until(lambda: one.actuator.state().settled)
    accepted = [float(told) for told in process.ask("status")["complaints"]]
    return min(told for told in accepted if told > begin) - begin, seen


def to_and_fro(one, seconds):
    end = time.monotonic() + seconds
    goal = 0.4
    while time.monotonic() < end:
        one.turn(goal)
        goal = -goal


def measured(case, folder, moves, seconds, *, moving=True, **options):
    """All figures of one case, but what it costs while it moves if not ``moving``."""
    chance = random.Random(1)  # noqa: S311
    with bench(case, folder, options) as (process, one, meter):
        times = [moved(process, one, chance) for _ in range(moves)]
        rest, switches = meter.over(lambda: time.sleep(seconds))
        busy = meter.over(lambda: to_and_fro(one, seconds))[0] if moving else 0.0
        capabilities = one.actuator.capabilities
    allowed = 2 * FRAME + math.sqrt(2 * capabilities.resolution / capabilities.max_acceleration)
    return {
        "case": case,
        "accepted_ms": round(1e3 * statistics.median(accepted for accepted, _ in times), 1),
        "accepted_worst_ms": round(1e3 * max(accepted for accepted, _ in times), 1),
        "seen_ms": round(1e3 * statistics.median(seen for _, seen in times), 1),
        "seen_allowed_ms": round(1e3 * allowed, 1),
        "rest_percent": round(1e2 * rest, 2),
        "moving_percent": round(1e2 * busy, 2),
        "switches_hz": round(switches),
    }


@pytest.mark.parametrize("case", [*QUICK[:-1], pytest.param("stepper", marks=(pytest.mark.alone, pytest.mark.soak))])
def test_commands_count_soon_and_nobody_waits_busily(case, tmp_path):
    found = measured(case, tmp_path, moves=3, seconds=0.5, moving=False, **PATIENT.get(case, {}))
    assert found["accepted_ms"] < 150, found
    assert found["seen_ms"] < found["seen_allowed_ms"] + 300, found
    assert found["rest_percent"] < 25, found
    assert found["switches_hz"] < 400, found


@pytest.mark.soak
@pytest.mark.parametrize("case", CASES)
def test_a_command_counts_within_a_period_and_costs_little(case, tmp_path, capsys):
    found = measured(case, tmp_path, moves=30, seconds=10.0)
    with capsys.disabled():
        sys.stdout.write(json.dumps(found) + "\n")
    assert found["accepted_ms"] < 1e3 * FRAME
    assert found["seen_ms"] <= found["seen_allowed_ms"]
    assert found["rest_percent"] < 4
    assert found["moving_percent"] < 8
    assert found["switches_hz"] < 250
