"""The field of the elevation study."""

from __future__ import annotations

import numpy as np

from ross_sim.study.elevation_study import FIELDS, HOVER, MOUTH

AZIMUTHS = np.deg2rad([10.0, 120.0, -60.0])


def test_the_talkers_of_the_field_are_20_to_60_degrees_below() -> None:
    level, above = FIELDS
    degrees = np.rad2deg(above.elevations(AZIMUTHS))
    assert degrees.min() >= -60
    assert degrees.max() <= -20
    np.testing.assert_array_equal(level.elevations(AZIMUTHS), 0)


def test_they_stand_at_their_azimuths_on_the_floor_within_the_field() -> None:
    for field in FIELDS:
        away = field.places(AZIMUTHS, np.random.default_rng(1)) - field.centre
        np.testing.assert_allclose(np.arctan2(away[:, 1], away[:, 0]), AZIMUTHS)
        np.testing.assert_allclose(away[:, 2], -field.above)
        assert np.abs(away[:, :2]).max() < min(field.size[:2]) / 2
    assert FIELDS[1].centre[2] == MOUTH + HOVER
