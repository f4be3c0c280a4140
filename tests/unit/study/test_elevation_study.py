"""The field of the elevation study."""

from __future__ import annotations

import numpy as np

from ross_payload.events import Estimate, SourceEstimate
from ross_sim.study.elevation_study import FIELDS, HOVER, MOUTH, ExploredField, row_of
from ross_sim.study.rows.elevation_rows import ElevationRow, below

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


def explored(*azimuths_deg: float) -> ExploredField:
    """Two talkers of the field and what is believed of them, the first elevation not told."""
    azimuths = np.deg2rad([10.0, 120.0])
    elevations = [None, *FIELDS[1].elevations(azimuths)[1:].tolist(), 0.0]
    sources = [
        SourceEstimate(azimuth, 0.01, 1.0, True, elevation=elevation)
        for azimuth, elevation in zip(np.deg2rad(azimuths_deg).tolist(), elevations, strict=False)
    ]
    return ExploredField(FIELDS[1], azimuths, (), Estimate(tuple(sources), certain=True))


def test_a_row_has_the_errors_of_every_talker_where_all_are_found_and_else_none() -> None:
    found = row_of(explored(11.0, 118.0), 2, 0, 7, 12, separate=False)
    assert found.azimuth_errors_deg == (1.0, 2.0)
    assert found.elevation_errors_deg[0] >= 20
    assert found.elevation_errors_deg[1] == 0
    assert (found.k_estimated, found.true_db) == (2, ())
    for azimuths in ((11.0,), (11.0, 140.0), (11.0, 118.0, 0.0)):
        assert row_of(explored(*azimuths), 2, 0, 7, 12, separate=True).azimuth_errors_deg == ()


def test_the_table_has_a_line_for_every_field() -> None:
    level = ElevationRow("level", 3, 0, 7, 12, 3, (0.5, 1.5), (0.0, 0.0), (), (), ())
    above = ElevationRow("above", 3, 0, 7, 12, 3, (1.0, 2.0), (1.0, 11.0), (14.0,), (13.0,), (10.0,))
    missed = ElevationRow("above", 3, 1, 7, 12, 2, (), (), (), (), ())
    assert below([level, above, missed]).rows == (
        ("as high as the array", "1/1 (21-100 %)", "1/1 (21-100 %)", "1.00", "2/2 (34-100 %)", "0.00", "-", "-", "-"),
        ("below", "1/2 (9-91 %)", "1/2 (9-91 %)", "1.50", "1/2 (9-91 %)", "6.00", "14.00", "13.00", "10.00"),
    )
