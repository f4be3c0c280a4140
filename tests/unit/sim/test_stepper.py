"""The simulated motor against the physics that it claims."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ross_sim.devices.stepper import Motor, Rotor

FREE = Motor(viscous=0.0, coulomb=0.0)
NOTHING = np.empty(0)


def test_a_frictionless_rotor_swings_at_its_natural_frequency() -> None:
    rotor = Rotor(FREE)
    rotor.angle = 1e-4
    signs = []
    for _ in range(20000):
        rotor.live(1e-4, NOTHING, np.zeros(1), True)
        signs.append(rotor.angle > 0)
    crossings = np.flatnonzero(np.diff(signs))
    period = 2 * np.diff(crossings).mean() * 1e-4
    assert 2 * math.pi / period == pytest.approx(FREE.natural, rel=2e-3)


@pytest.mark.parametrize(("lag_steps", "lost"), [(1.9, 0), (-1.9, 0), (2.1, -4), (-2.1, 4), (5.9, -4), (6.1, -8)])
def test_beyond_two_full_steps_the_rotor_falls_into_the_next_period(lag_steps: float, lost: int) -> None:
    rotor = Rotor(Motor())
    target = math.radians(1.8 * lag_steps)
    rotor.live(5.0, NOTHING, np.array([target]), True)
    assert 4 * rotor.periods_lost == lost
    assert rotor.angle - target == pytest.approx(math.radians(1.8) * lost, abs=1e-12)


def test_at_rest_it_stands_exactly_on_its_windings() -> None:
    rotor = Rotor(Motor())
    target = math.radians(0.1125) * 3
    rotor.live(1.0, NOTHING, np.array([target]), True)
    assert rotor.still
    assert rotor.angle == target


def test_without_current_it_falls_into_the_nearest_detent() -> None:
    rotor = Rotor(Motor())
    rotor.angle = math.radians(1.8 * 7.3)
    rotor.live(5.0, NOTHING, np.zeros(1), False)
    assert rotor.angle == pytest.approx(math.radians(1.8 * 7), abs=1e-9)


def test_energy_is_never_made() -> None:
    motor = replace(Motor(), corner_speed=1e9)
    rotor = Rotor(motor)
    rotor.angle = math.radians(1.8 * 1.9)
    energy = [_energy(rotor, motor)]
    for _ in range(3000):
        rotor.live(1e-4, NOTHING, np.zeros(1), True)
        energy.append(_energy(rotor, motor))
    assert np.diff(energy).max() < 1e-3 * energy[0]
    assert energy[-1] < 0.05 * energy[0]


def _energy(rotor: Rotor, motor: Motor) -> float:
    spring = motor.holding_torque / motor.teeth * (1 - math.cos(motor.teeth * rotor.angle))
    return motor.inertia * rotor.speed**2 / 2 + spring
