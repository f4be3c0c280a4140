"""Where the array points, and which joint angle gives a heading."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.pointing import BaseRate, Pointing, nearest_joint, nearest_limit

ANGLES = st.floats(-20.0, 20.0)


@given(ANGLES, ANGLES, ANGLES, ANGLES)
def test_the_heading_is_the_sum_of_base_joint_and_offset(joint, base, offset, other):
    here = Pointing(joint=joint, base=base, offset=offset)
    assert here.heading == base + joint + offset
    assert here.zero == pytest.approx(base + offset, abs=1e-9)
    assert here.at(other) == pytest.approx(base + other + offset, abs=1e-9)


@given(ANGLES, ANGLES, st.floats(0.0, 10.0), st.sampled_from([math.pi, 2 * math.pi]))
def test_the_nearest_joint_is_inside_the_limits_and_none_inside_is_nearer(angle, near, limit, period):
    inside = [angle + k * period for k in range(-30, 31) if abs(angle + k * period) <= limit]
    found = nearest_joint(angle, near, -limit, limit, period)
    if not inside:
        assert found is None or abs(abs(found) - limit) < 1e-6  # rounding at a limit
    else:
        assert found is not None
        assert abs(found) <= limit
        assert abs(found - near) <= min(abs(joint - near) for joint in inside) + 1e-6
        assert math.remainder(found - angle, period) == pytest.approx(0.0, abs=1e-6)


def test_a_joint_without_limits_takes_the_nearest_turn():
    assert nearest_joint(0.1, 100.0, -math.inf, math.inf) == pytest.approx(0.1 + 32 * math.pi)


@given(ANGLES)
def test_the_nearest_limit_is_the_one_with_less_to_go(angle):
    away = {limit: abs(math.remainder(angle - limit, 2 * math.pi)) for limit in (-1.0, 1.5)}
    assert away[nearest_limit(angle, -1.0, 1.5)] <= min(away.values()) + 1e-9


def test_the_rate_of_the_base_is_that_of_the_last_tenth_of_a_second():
    rate = BaseRate()
    before = [rate.update(0.01 * k, math.remainder(3.0 + 0.003 * k, 2 * math.pi), earth=True) for k in range(100)]
    after = [rate.update(1.0 + 0.01 * k, -3.0, earth=True) for k in range(20)]
    assert before == pytest.approx([0.0] + [0.3] * 99)  # past south, too
    assert after[-10:] == [0.0] * 10


@pytest.mark.parametrize(("yaw", "earth"), [(0.2, False), (0.9, True)], ids=["frame", "slip put right"])
def test_a_jump_is_no_rate(yaw, earth):
    rate = BaseRate()
    for k in range(20):
        rate.update(0.01 * k, 0.2, earth=True)
    assert [rate.update(0.2 + 0.01 * k, yaw, earth=earth) for k in range(20)] == [0.0] * 20
