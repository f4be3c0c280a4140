"""Random commands to the stepper: no limit, speed or acceleration exceeded, no edge nearer to another than it may be.

Edges are looked at twice: as they are planned, and as whole microseconds on the pins.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from fake_lgpio import FakeLgpio
from ross_payload.actuators.guard import Guard
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.actuators.tb6600.pulse_segments import EDGE, PulseLine, Segment
from ross_payload.actuators.wires.gpio import GpioPulses, pins_of
from ross_payload.config import Config
from ross_payload.errors import ActuatorError
from ross_payload.interfaces import Services
from ross_sim.clock import QUANTUM, SimClock

pytestmark = pytest.mark.lockstep

MODULE_LOW = 2.5e-6  # [s] STEP low that the slowest module wants
LIMIT = math.radians(200)
NOISE = 1e-9  # of a time on the clock [s]


class Tapped(GpioPulses):
    """Pins that remember what they were sent."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.sent: list[Segment] = []

    def send(self, frame: Any) -> None:
        self.sent.append(frame)
        super().send(frame)

    def planned(self) -> np.ndarray:
        parts = [segment.edges.copy() for segment in self.sent]
        for part, segment in zip(parts, self.sent, strict=True):
            part["time"] += segment.start
        return np.concatenate(parts)


class Bench:
    """A driver with random options on pins, in simulated time."""

    def __init__(self, chance: np.random.Generator) -> None:
        options = random_options(chance)
        caps = {name: options[name] for name in ("max_speed_deg_s", "max_acceleration_deg_s2")}
        config = Config.model_validate({"actuator": {"kind": "tb6600", "options": options}, "guard": caps})
        self.options = checked_options(config)
        self.clock = SimClock()
        self.gpio = FakeLgpio(self.clock, phase=chance.uniform(0, 0.02))
        self.port = Tapped(self.gpio, pins_of(self.options.port), self.clock)
        self.guard: Guard = open_actuator(config, Services(self.clock, lambda url: self.port))
        self.guard.__enter__()
        self.clock.every(QUANTUM, lambda: self.guard.poll(self.clock.now()))
        self.speed, self.acceleration = (math.radians(cap) for cap in caps.values())

    def run(self, quanta: int) -> None:
        """Live, and see that nothing exceeds a cap or a limit."""
        before = self.guard.state().rate
        for _ in range(quanta):
            self.clock.sleep(QUANTUM)
            state = self.guard.state()
            assert -LIMIT - 1e-9 <= state.angle <= LIMIT + 1e-9
            assert abs(state.rate) <= self.speed * (1 + 1e-9)
            assert abs(state.rate - before) <= self.acceleration * QUANTUM * 1.001
            assert state.healthy, state.fault
            before = state.rate


def random_options(chance: np.random.Generator) -> dict[str, Any]:
    microsteps, gear = int(chance.choice([1, 2, 4, 8, 16, 32])), float(chance.choice([0.5, 1.0, 3.0]))
    rate = float(chance.choice([3000.0, 15_000.0]))
    fastest = 0.999 * 1e6 / math.ceil(1e6 / rate) * 360 / (200 * microsteps * gear)
    return {
        "port": "pulses:lgpio:0:17,27,22",
        "microsteps": microsteps,
        "gear_ratio": gear,
        "invert_direction": bool(chance.random() < 0.5),
        "pulse_us": float(chance.choice([2.5, 10.0, 25.5])),
        "direction_setup_us": float(chance.choice([5.0, 20.0, 300.5])),
        "direction_hold_us": float(chance.choice([5.0, 20.0, 150.25])),
        "enable_lead_ms": float(chance.choice([0.1, 5.0, 30.0])),
        "max_pulse_rate_hz": rate,
        "max_speed_deg_s": min(float(chance.choice([40.0, 225.0, 700.0])), fastest),
        "max_acceleration_deg_s2": float(chance.choice([60.0, 112.5, 6000.0])),
    }


def one_sequence(seed: int) -> Bench:
    """Goals, stops, releases and homes at random moments, then rest."""
    chance = np.random.default_rng(seed)
    bench = Bench(chance)
    bench.run(int(chance.integers(2, 10)))
    for _ in range(chance.integers(1, 7)):
        what = chance.choice(["go", "go", "go", "go", "stop", "release", "home"])
        if what == "go":
            goal, rate = chance.uniform(-200, 200), chance.uniform(1, 800)
            try:
                bench.guard.command(math.radians(goal), math.radians(rate))
            except ActuatorError:
                bench.guard.home()
        else:
            getattr(bench.guard, what)()
            bench.guard.rearm()
            bench.clock.sleep(0.1 if what == "release" else 0.0)  # without torque it slows down as it likes
        bench.run(int(chance.integers(1, 80)))
    bench.guard.stop()
    bench.run(math.ceil(bench.speed / bench.acceleration / QUANTUM) + 20)
    assert bench.guard.state().rate == 0.0
    bench.guard.__exit__(None, None, None)
    return bench


def margins(edges: np.ndarray, bench: Bench) -> Iterator[tuple[str, float]]:
    """By how much the nearest pair of each kind is farther apart than it must be [s]."""
    options, times = bench.options, edges["time"]
    assert np.all(np.diff(times) >= 0)
    rises = times[(edges["line"] == PulseLine.STEP) & edges["level"]]
    falls = times[(edges["line"] == PulseLine.STEP) & ~edges["level"]]
    turns = times[edges["line"] == PulseLine.DIRECTION]
    switches = times[(edges["line"] == PulseLine.ENABLE) & (edges["level"] != options.enable_means_off)]
    assert len(rises) == len(falls)
    yield from nearest("STEP high", falls - rises, options.pulse_us * 1e-6)
    yield from nearest("STEP low", rises[1:] - falls[:-1], MODULE_LOW)
    yield from nearest("cap of the rate", np.diff(rises), 1 / options.max_pulse_rate_hz)
    yield from nearest("DIRECTION set-up", _since(turns, rises), options.direction_setup_us * 1e-6)
    yield from nearest("DIRECTION hold", _since(falls, turns), options.direction_hold_us * 1e-6)
    others = np.sort(np.concatenate([rises, turns]))
    yield from nearest("ENABLE lead", _since(switches, others), options.enable_lead_ms * 1e-3)
    side = np.searchsorted(turns, rises)
    same = side[1:] == side[:-1]
    yield from nearest("speed", np.diff(rises)[same], options.resolution / bench.speed)


def nearest(name: str, found: np.ndarray, wanted: float) -> Iterator[tuple[str, float]]:
    if len(found):
        yield name, float(found.min()) - wanted


def _since(first: np.ndarray, then: np.ndarray) -> np.ndarray:
    """From the last of `first` to each of `then` that has one [s]."""
    index = np.searchsorted(first, then, side="right")
    return then[index > 0] - first[index[index > 0] - 1]


def pins(bench: Bench) -> np.ndarray:
    """What came out, with the levels at the beginning left away."""
    n_first = len(bench.gpio.claimed[0][1])
    found: np.ndarray = np.array([(time * 1e-6, *rest) for time, *rest in bench.gpio.edges[n_first:]], dtype=EDGE)
    return found


def worst_margins(seeds: range) -> dict[tuple[str, str], float]:
    """The smallest margins [s] over all sequences, planned and on pins."""
    worst: dict[tuple[str, str], float] = {}
    for seed in seeds:
        bench = one_sequence(seed)
        for where, edges in (("planned", bench.port.planned()), ("pins", pins(bench))):
            for name, margin in margins(edges, bench):
                worst[where, name] = min(worst.get((where, name), math.inf), margin)
    return worst


def judge(worst: dict[tuple[str, str], float]) -> None:
    """Nothing is nearer than its minimum; the interval of two steps may be rounded by a microsecond."""
    for (where, name), margin in worst.items():
        rounding = 1e-6 if (where, name) == ("pins", "speed") else 0.0
        assert margin >= -rounding - NOISE, f"{where}, {name}: {margin * 1e6:.4f} us"


def test_no_edge_comes_nearer_to_another_than_it_may() -> None:
    worst = worst_margins(range(10))
    assert len(worst) == 14
    judge(worst)


@pytest.mark.soak
def test_no_edge_comes_nearer_to_another_than_it_may_in_10000_sequences() -> None:
    judge(worst_margins(range(10_000)))
