"""Whatever a scenario asks for: a mission ends, is sound, keeps its limits, and leaves nothing turning."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from any_scenario import any_scenario
from examples import in_soak
from ross_sim.sitl import mission_session
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.talker_selection import talkers_of
from ross_sim.sitl.world import World

BEYOND = math.radians(2.0)  # a limit, as a servo overshoots [rad]
MOVING = math.radians(0.05)  # in 10 ms [rad]


@pytest.mark.parametrize("seed", [17, 108, *in_soak(*range(109, 160))])
def test_a_mission_of_any_scenario_ends_soundly(monkeypatch, seed):
    worlds = []
    monkeypatch.setattr(
        mission_session, "World", lambda *told, **more: worlds.append(World(*told, **more)) or worlds[0]
    )
    scenario = any_scenario(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # of numpy: a division by 0 that nobody has thought of
        finished = mission_session.perform(scenario, talkers_of(scenario, None, None), MissionView(), None, None)
    assert finished.result.reason
    assert not list(_infinite(finished.report))
    (world,) = worlds
    assert np.isfinite(world.mixture()).all()
    turned = world.headings() - scenario.offset
    if scenario.vehicle is None and not scenario.troubles:  # of a device in trouble nobody may know where it is
        guard = scenario.payload.guard
        low, high = (math.radians(limit) for limit in (guard.lower_deg, guard.upper_deg))
        assert turned.min() >= min(low, turned[0]) - BEYOND
        assert turned.max() <= max(high, turned[0]) + BEYOND
        assert abs(turned[-1] - turned[-2]) <= MOVING


def _infinite(value, place="report"):
    """Where a report holds a number that is none."""
    if isinstance(value, float) and not math.isfinite(value):
        yield place
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, part in parts:
        yield from _infinite(part, f"{place}.{key}")
