"""Two lines in a plane, and the plane that touches the earth: where bearings cross, and with which covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_protocols.mavlink.field_converters import wrap

EQUATOR, FLATNESS = 6378137.0, 0.00669437999014  # WGS84: semi-major axis [m], first eccentricity squared
MIN_RANGE_M = 0.1  # [m] at which bearings cross: two payloads of one vehicle have one place, but for rounding
MIN_SIGMAS_APART = 2.0  # sigmas by which two bearings must differ to cross anywhere

Matrix = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, slots=True)
class BearingLine:
    """A bearing in the plane."""

    east: float  # of where it begins [m]
    north: float  # [m]
    azimuth: float  # counter-clockwise from north [rad]
    sigma: float  # of the azimuth [rad]
    position_sigma: float  # of where it begins, in each direction [m]


@dataclass(frozen=True, slots=True)
class Crossing:
    """Where two lines cross."""

    east: float  # [m]
    north: float  # [m]
    covariance: Matrix  # east, north [m^2]


def cross_two(one: BearingLine, other: BearingLine) -> Crossing | None:
    """Return where two lines cross; None: behind or at the place of one of them, or so parallel that nobody can tell.

    With u a line's direction, n its normal and r the range, an error of azimuth and of place moves the line by r times
    the one plus the other; the covariance is the inverse of N = (n1, n2) applied to both sides of these variances.

    >>> at = cross_two(BearingLine(0, 0, 0.0, 0.01, 0.0), BearingLine(100, 0, math.pi / 4, 0.01, 0.0))
    >>> round(at.east, 9), round(at.north, 9), [round(variance, 6) for row in at.covariance for variance in row]
    (0.0, 100.0, [1.0, -1.0, -1.0, 5.0])
    """
    apart = math.sin(other.azimuth - one.azimuth)
    if abs(apart) <= MIN_SIGMAS_APART * math.hypot(one.sigma, other.sigma):
        return None
    (n1e, n1n), (n2e, n2n) = _normal(one), _normal(other)
    c1, c2 = n1e * one.east + n1n * one.north, n2e * other.east + n2n * other.north
    east, north = (c1 * n2n - c2 * n1n) / apart, (c2 * n1e - c1 * n2e) / apart
    r1, r2 = _ahead(one, east, north), _ahead(other, east, north)
    if min(r1, r2) < MIN_RANGE_M:
        return None
    v1, v2 = _variance(one, r1) / apart**2, _variance(other, r2) / apart**2
    ee, nn = v1 * n2n**2 + v2 * n1n**2, v1 * n2e**2 + v2 * n1e**2
    en = -(v1 * n2n * n2e + v2 * n1n * n1e)
    return Crossing(east, north, ((ee, en), (en, nn)))


def misses(line: BearingLine, at: Crossing) -> float:
    """Return by how many squared sigmas a line misses a crossing; infinite: the crossing is behind it."""
    ahead = _ahead(line, at.east, at.north)
    if ahead <= 0:
        return math.inf
    (ee, en), (_, nn) = at.covariance
    e, n = _normal(line)
    offset = e * (at.east - line.east) + n * (at.north - line.north)
    return offset**2 / (_variance(line, ahead) + e * e * ee + 2 * e * n * en + n * n * nn)


class Plane:
    """The plane that touches the ellipsoid at a place [rad]; good for some kilometres.

    >>> plane = Plane(0.0, 0.0)
    >>> [round(metres, 3) for metres in plane.place(1e-5, 1e-5)]
    [63.781, 63.354]
    """

    def __init__(self, latitude: float, longitude: float) -> None:
        self._latitude, self._longitude = latitude, longitude
        flat = 1 - FLATNESS * math.sin(latitude) ** 2
        self._per_latitude = EQUATOR * (1 - FLATNESS) / flat**1.5
        self._per_longitude = EQUATOR / math.sqrt(flat) * max(math.cos(latitude), 1e-6)

    def place(self, latitude: float, longitude: float) -> tuple[float, float]:
        """Return east and north [m] of a place [rad]."""
        east = wrap(longitude - self._longitude) * self._per_longitude
        return east, (latitude - self._latitude) * self._per_latitude

    def back(self, east: float, north: float) -> tuple[float, float]:
        """Return latitude and longitude [rad] of a point [m]."""
        return self._latitude + north / self._per_latitude, wrap(self._longitude + east / self._per_longitude)

    def turned(self, longitude: float) -> float:
        """Return by how much north at a longitude [rad] is turned in the plane [rad], because meridians meet."""
        return wrap(longitude - self._longitude) * math.sin(self._latitude)


def _normal(line: BearingLine) -> tuple[float, float]:
    return math.cos(line.azimuth), math.sin(line.azimuth)


def _ahead(line: BearingLine, east: float, north: float) -> float:
    """Return how far a point is along a line [m]."""
    return math.cos(line.azimuth) * (north - line.north) - math.sin(line.azimuth) * (east - line.east)


def _variance(line: BearingLine, ahead: float) -> float:
    """Return the variance across a line, so far along it [m^2]."""
    return (ahead * line.sigma) ** 2 + line.position_sigma**2
