"""How a vehicle yaws: what it does steadily, as it drifts and as it vibrates."""

import numpy as np
import pytest

from ross_sim.autopilot.yaw import Yaw

ALL = Yaw(mean=0.3, amplitude=0.5, speed=0.25, steady=0.1, drift=0.05, vibration=0.002, frequency=12.0)


def test_the_rate_is_the_slope_of_the_angle():
    for time in (0.7, 3.3, 5.1, 17.9):
        slope = (ALL.at(time + 1e-6) - ALL.at(time - 1e-6)) / 2e-6
        assert ALL.rate(time) == pytest.approx(slope, abs=1e-5)


def test_a_drift_has_the_standard_deviation_that_it_is_given():
    times = np.arange(0, 3600, 0.5)
    assert np.std([Yaw(drift=0.05).at(time) for time in times]) == pytest.approx(0.05, rel=0.05)


def test_a_vibration_stays_within_its_amplitude():
    angles = np.array([Yaw(vibration=0.002).at(time) for time in np.arange(0, 10, 0.003)])
    assert 0.0019 < np.abs(angles).max() <= 0.002
    assert abs(angles.mean()) < 1e-4


def test_all_motions_add_up():
    still = Yaw(mean=0.3)
    assert still.at(8.0) == 0.3
    assert Yaw(mean=0.3, steady=-0.1).at(8.0) == pytest.approx(-0.5)
