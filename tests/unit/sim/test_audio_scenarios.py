"""Simulated missions have healthy microphones, and the health monitor says so; with one turned over it says that."""

from dataclasses import replace

import numpy as np
import pytest

from examples import in_soak
from ross_payload.audio.audio_health import HealthMonitor
from ross_payload.health import AudioTrouble
from ross_sim.clock import SimClock
from ross_sim.scenario import load
from ross_sim.sitl.world import World
from ross_sim.talkers.synthetic_voices import synthetic_voices

pytestmark = pytest.mark.lockstep

FLIPPED = np.array([[1], [-1]], np.float32)


class Swinging:
    """A far end that turns, with the noise of its motor, for two seconds of every five."""

    port = None

    def __init__(self):
        self._angle = 0.0

    def advance(self, now):
        self._angle = 1.2 * min(max(now % 5 - 2, 0), 2)

    def angle(self):
        return self._angle


# from above talkers walk or rest at any height, and rooms are alike to a monitor: one of each stays


@pytest.mark.parametrize(
    "name",
    ["demo", "silence", *in_soak("setting-5", "from-above", "from-above-20", "from-above-walking", "paper-setting-2")],
)
def test_a_scenario_raises_no_alarm_and_with_one_polarity_wrong_that_one(name):
    scenario = load(name)
    config = scenario.payload
    voices = scenario.cast(synthetic_voices(config.audio.rate_hz)).talkers
    world = World(scenario, voices, Swinging(), SimClock(), 1)
    well, wrong = HealthMonitor(config), HealthMonitor(config)
    with world.source as source:
        for _ in range(round(5 * config.audio.rate_hz / config.hop)):
            block = source.read(config.hop)
            well.listen(block)
            wrong.listen(replace(block, samples=block.samples * FLIPPED))
            assert not well.health().trouble
    assert wrong.health().trouble == AudioTrouble.INVERTED
