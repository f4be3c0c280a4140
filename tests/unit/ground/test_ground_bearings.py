"""Where bearings cross: against closed forms, Monte Carlo, an exact ellipsoid, and scenes with ghosts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.ground.model.bearing_geometry import BearingLine, Plane, cross_two
from ross_payload.ground.model.jpda import marginals
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.triangulation import Bearing, bearings_of, cross
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.field_converters import wrap
from ross_protocols.mavlink.values import Source

A, B, C = ComponentId(1, 191), ComponentId(2, 191), ComponentId(3, 191)
LATITUDE, LONGITUDE = math.radians(47.4), math.radians(8.5)
PLANE = Plane(LATITUDE, LONGITUDE)
SIGMA = math.radians(2)
PLACES = {A: (0.0, 0.0), B: (60.0, 0.0), C: (10.0, 80.0)}  # east, north [m]


def ecef(latitude, longitude):
    """A point of the ellipsoid in cartesian metres."""
    flat = 6.69437999014e-3
    curvature = 6378137.0 / math.sqrt(1 - flat * math.sin(latitude) ** 2)
    across = curvature * math.cos(latitude)
    up = curvature * (1 - flat) * math.sin(latitude)
    return np.array([across * math.cos(longitude), across * math.sin(longitude), up])


def axes(latitude, longitude):
    """East and north there."""
    east = [-math.sin(longitude), math.cos(longitude), 0.0]
    north = [-math.sin(latitude) * math.cos(longitude), -math.sin(latitude) * math.sin(longitude), math.cos(latitude)]
    return np.array([east, north])


def towards(who, point, source=0, sigma=SIGMA, places=PLACES, **how):
    """A payload's bearing of a point (east, north)."""
    east, north = places[who]
    latitude, longitude = PLANE.back(east, north)
    azimuth = math.atan2(-(point[0] - east), point[1] - north) - PLANE.turned(longitude)
    return Bearing(who, source, latitude, longitude, azimuth, sigma, **how)


def seen(*points, whos=(A, B), **how):
    """What every payload hears of sources at some points, each numbered in its own order."""
    return [
        towards(who, point, (source + place) % len(points), **how)
        for place, who in enumerate(whos)
        for source, point in enumerate(points)
    ]


def where(fixes):
    return [(fix.east, fix.north) for fix in fixes]


# ------------------------------------------------------------------------------------------- two lines


@given(st.floats(-200, 200), st.floats(-200, 200))
def test_two_exact_bearings_of_a_point_cross_there(east, north):
    fixes = cross(seen((east, north), sigma=1e-4))
    if math.hypot(east, north) > 5 and math.hypot(east - 60, north) > 5 and abs(north) > 1:
        ((x, y),) = where(fixes)
        assert (x, y) == pytest.approx((east, north), abs=1e-3)


@pytest.mark.soak
def test_the_covariance_is_that_of_a_monte_carlo():
    first, second = BearingLine(0, 0, -0.6, math.radians(1.0), 1.5), BearingLine(60, 0, 0.5, math.radians(1.5), 1.5)
    rng = np.random.default_rng(7)
    points = []
    for _ in range(8_000):
        lines = [
            BearingLine(
                *rng.normal((line.east, line.north), line.position_sigma), rng.normal(line.azimuth, line.sigma), 0, 0
            )
            for line in (first, second)
        ]
        at = cross_two(*lines)
        points.append((at.east, at.north))
    told = np.array(cross_two(first, second).covariance)
    assert np.cov(np.transpose(points)) == pytest.approx(told, rel=0.05, abs=0.05)


def test_the_farther_a_source_the_longer_its_ellipse():
    longest = []
    for north in (50, 100, 200, 400):
        (fix,) = cross(seen((30, north), sigma=math.radians(1)))
        longest.append(math.sqrt(np.linalg.eigvalsh(np.array(fix.covariance))[-1]))
    assert longest == sorted(longest)
    assert longest[-1] / longest[-2] == pytest.approx(4, rel=0.3), "it grows with the square of the range"


def test_the_less_is_known_of_the_places_the_larger_the_ellipse():
    sharp, vague = (cross(seen((30, 80), position_sigma=sigma))[0].covariance for sigma in (0.1, 10.0))
    assert np.trace(vague) > np.trace(sharp) + 100


@pytest.mark.parametrize("apart", [0.0, 0.5, 2.0])
def test_bearings_that_are_nearly_parallel_cross_nowhere(apart):
    first = towards(A, (0, 1000), sigma=math.radians(2))
    second = Bearing(B, 0, *PLANE.back(*PLACES[B]), first.azimuth + math.radians(apart), math.radians(2))
    assert cross([first, second]) == []


def test_what_is_behind_an_array_is_no_crossing():
    """The lines cross at (30, 80), behind the second payload."""
    first, second = seen((30, 80))
    back = Bearing(B, 0, second.latitude, second.longitude, second.azimuth + math.pi, second.sigma)
    assert cross([first, back]) == []


# ------------------------------------------------------------------------------------------- on the ellipsoid


@pytest.mark.parametrize(("latitude", "tolerated"), [(0, 0.05), (47, 0.3), (-33, 0.3), (70, 0.6)])
def test_within_a_kilometre_a_fix_is_as_good_as_promised_on_the_ellipsoid(latitude, tolerated):
    lat0, lon0 = math.radians(latitude), math.radians(179.999)
    plane, worst = Plane(lat0, lon0), 0.0
    for east, north in [(300, 900), (-700, 650), (900, -200), (-400, -850)]:
        place = plane.back(1000, 100)
        truth = plane.back(east, north)
        bearings = []
        for who, stand in ((A, (lat0, lon0)), (B, place)):
            x, y = axes(*stand) @ (ecef(*truth) - ecef(*stand))
            bearings.append(Bearing(who, 0, *stand, math.atan2(-x, y), 1e-4))
        (fix,) = cross(bearings)
        missed = ecef(fix.latitude, fix.longitude) - ecef(*truth)
        worst = max(worst, float(np.linalg.norm(missed)))
    assert worst < tolerated


def test_the_fix_has_its_place_in_degrees_and_the_payloads_in_words():
    (fix,) = cross(seen((30, 80)))
    told = fix.json()
    assert (told["payloads"], told["sources"], told["ghost"]) == (["1-191", "2-191"], [0, 0], False)
    assert PLANE.place(math.radians(told["lat"]), math.radians(told["lon"])) == pytest.approx((30, 80), abs=0.01)


# ------------------------------------------------------------------------------------------- ghosts


def right(fixes, points):
    """Which fixes are at a point, by their probability."""
    return [any(math.dist((fix.east, fix.north), point) < 1 for point in points) for fix in fixes]


THREE = [(20, 60), (40, 90), (70, 50)]


def test_when_nothing_tells_sources_from_ghosts_all_are_shown():
    fixes = cross(seen((20, 60), (40, 60)))
    assert len(fixes) == 4
    assert not any(fix.ghost for fix in fixes)


@pytest.mark.parametrize("weight", [-0.5, 0.0, math.nan])
def test_a_weight_that_is_none_tells_nothing(weight):
    told = [replace(bearing, weight=weight if bearing.who == A else 0.5) for bearing in seen((20, 60), (40, 60))]
    assert where(cross(told)) == where(cross(seen((20, 60), (40, 60))))


def test_a_source_that_can_only_be_one_thing_makes_ghosts_of_its_other_crossings():
    """The second payload's second bearing crosses one of the first payload's alone."""
    fixes = cross(seen((20, 60), (-50, -60)))
    assert [fix.ghost for fix in fixes] == [not at for at in right(fixes, [(20, 60), (-50, -60)])]


@pytest.mark.parametrize(("scores", "told"), [((5.0, -3.0), True), ((0.3, -0.2), False)])
def test_voice_prints_tell_ghosts_when_they_are_sure(scores, told):
    points = THREE[:2]
    bearings = [
        towards(who, point, number, score=score + drift)
        for who, drift in ((A, 0.0), (B, 0.5))
        for number, (point, score) in enumerate(zip(points, scores, strict=True))
    ]
    fixes = cross(bearings)
    assert len(fixes) == 4
    assert [fix.ghost for fix in fixes] == [told and not at for at in right(fixes, points)]


def test_the_target_of_one_is_the_target_of_the_other():
    bearings = [towards(who, point, target=point == THREE[1]) for who in (A, B) for point in THREE[:2]]
    bearings = [Bearing(**{**_fields(each), "source": number % 2}) for number, each in enumerate(bearings)]
    fixes = cross(bearings)
    assert [fix.ghost for fix in fixes] == [not at for at in right(fixes, THREE[:2])]


def _fields(bearing):
    return {name: getattr(bearing, name) for name in bearing.__slots__}


def test_a_third_payload_tells_ghosts():
    fixes = cross(seen(*THREE, whos=(A, B, C)))
    assert sum(right(fixes, THREE)) == 9, "three sources, three pairs of payloads"
    assert [fix.ghost for fix in fixes] == [not at for at in right(fixes, THREE)]


def test_no_source_is_used_twice():
    """The probabilities of all crossings of one source are no more than one."""
    for fix in (fixes := cross(seen(*THREE))):
        of_it = [other.probability for other in fixes if other.sources[0] == fix.sources[0]]
        assert sum(of_it) <= 1 + 1e-9


def test_of_two_hundred_sources_the_strongest_are_crossed():
    rng = np.random.default_rng(3)
    points = rng.uniform((-100, 20), (160, 200), (200, 2))
    bearings = [
        towards(who, point, number, weight=1.0 if number < 3 else 0.001)
        for who in (A, B)
        for number, point in enumerate(points)
    ]
    fixes = cross(bearings)
    assert len(fixes) <= 36
    assert {0, 1, 2} <= {fix.sources[0] for fix in fixes}


def test_one_payload_alone_fixes_nothing():
    assert cross([]) == []
    assert cross(seen(*THREE, whos=(A,))) == []


def test_two_payloads_of_one_vehicle_fix_nothing_at_its_place_though_it_is_rounded():
    vehicle = {B: (-60.3, 33.4), C: (-60.3, 33.4)}
    bearings = [towards(A, (0.0, 500.0))]
    for azimuth in range(-180, 180, 20):
        far = (-60.3 - 200 * math.sin(math.radians(azimuth)), 33.4 + 200 * math.cos(math.radians(azimuth)))
        bearings += [towards(who, far, azimuth // 20 + 9, places=vehicle) for who in vehicle]
    crossed = [fix.payloads for group in range(0, 18, 3) for fix in cross(_some(bearings, range(group, group + 3)))]
    assert (B, C) not in crossed


def _some(bearings, sources):
    """Those of payload A, and some sources of the others."""
    return [each for each in bearings if each.who == A or each.source in sources]


def test_two_payloads_at_one_place_fix_nothing():
    assert cross(seen((30, 80), (50, 20), whos=(A, B), places={A: (0, 0), B: (0, 0)})) == []


# ------------------------------------------------------------------------------------------- assignments


@given(st.lists(st.lists(st.floats(0, 1), min_size=3, max_size=3), min_size=1, max_size=3), st.floats(0.01, 0.5))
def test_the_shares_are_those_of_all_assignments_counted_one_by_one(weights, alone):
    rows, columns = len(weights), len(weights[0])
    total, shares = 0.0, np.zeros((rows, columns))
    for chosen in np.ndindex(*[columns + 1] * rows):  # the last: nobody
        used = [column for column in chosen if column < columns]
        if len(set(used)) == len(used):
            pairs = [(row, column) for row, column in enumerate(chosen) if column < columns]
            weight = math.prod(weights[row][column] for row, column in pairs)
            weight *= alone ** (rows + columns - 2 * len(pairs))
            total += weight
            for pair in pairs:
                shares[pair] += weight
    assert np.array(marginals(weights, alone)) == pytest.approx(shares / total)


# ------------------------------------------------------------------------------------------- from telemetry


def source(index, azimuth, **how):
    told = {"sigma": 0.02, "confidence": 1.0, "weight": 0.5, "earth": True, "resolved": True} | how
    return Source(0, 1, index, 2, azimuth, **told)


def test_azimuths_from_north_are_bearings_as_they_are():
    payload = PayloadState(A, 0.0, 0.0, sources=(source(0, 0.4),))
    (bearing,) = bearings_of(payload, LATITUDE, LONGITUDE, mount=1.0)
    assert (bearing.azimuth, bearing.sigma, bearing.source) == (0.4, 0.02, 0)


def test_azimuths_from_the_mount_turn_with_it_and_mean_nothing_without():
    """The mount points east: what is ahead of it is in the east, which is -90 deg counter-clockwise."""
    payload = PayloadState(A, 0.0, 0.0, sources=(source(0, 0.0, earth=False),))
    (bearing,) = bearings_of(payload, LATITUDE, LONGITUDE, mount=math.pi / 2)
    assert wrap(bearing.azimuth) == pytest.approx(-math.pi / 2)
    assert bearings_of(payload, LATITUDE, LONGITUDE, mount=None) == []


def test_a_source_with_a_mirror_image_may_be_at_either_and_the_other_payload_decides():
    """The first payload's axis points north: its source is at (30, 80) or at (-30, 80); the second is told apart."""
    true = towards(A, (30, 80))
    first = PayloadState(A, 0.0, 0.0, sources=(source(0, true.azimuth, mirror=-true.azimuth, resolved=False),))
    there = towards(B, (30, 80))
    bearings = [*bearings_of(first, LATITUDE, LONGITUDE, None), there]
    fixes = cross(bearings)
    assert pytest.approx(where(fixes)[0], abs=0.1) == (30, 80)
    assert {fix.sources for fix in fixes} == {(0, 0)}
