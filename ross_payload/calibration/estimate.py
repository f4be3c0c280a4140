"""From a whole turn to what the array is like, each number with its uncertainty; or why it cannot be told."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ross_payload.angles import wrap
from ross_payload.calibration.cross_spectrum import HEARD, HeadingSpectrum
from ross_payload.calibration.turn_fit import Turn, TurnFit, fit, second_source
from ross_payload.errors import AudioError
from ross_payload.health import DEAD_DB
from ross_payload.interfaces import Real

FEWEST = 6  # headings
STEADY = 2 / 3  # share of the headings at which the sound must be heard
QUIETER_DB = 15.0  # than at the median heading: a pause
SMALLEST = math.radians(90.0)  # turn [rad]
DELAY_FROM = math.radians(150.0)  # turn after which delay and roll-off can be told [rad]
BROAD = 1000.0  # [Hz] that must be heard well
WELL = 0.25  # share of the power in common, in a bin that is heard well
OTHER = 0.15  # of the direct sound: a second source
OTHER_LEAST = 0.1  # of everything
DIRECT = 0.65  # least share of direct sound
VAGUE = 0.05  # largest uncertainty of the spacing, as a share of it
NARROWEST = 0.005  # spacing [m]
WIDEST = 0.3  # spacing that is looked for, or twice the configured one [m]
SWAPPED = math.radians(45.0)  # an offset so near to half a turn is that of microphones that are swapped [rad]
BIAS = 6e-6  # of delays, if nothing of the sound came straight: what reflections add however long one listens [s]
SPACING_FLOOR = 1e-3  # of the spacing: what remains however long one listens
ANGLE_FLOOR = math.radians(0.05)  # [rad]
DELAY_FLOOR = 1e-7  # [s]
ROLL_OFF_FLOOR = 0.5  # [Hz]
GAIN_FLOOR = 0.03  # [dB]


class NotCalibrated(AudioError):
    """What was heard during a turn does not tell what the array is like."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """What an array is like; every ``_sigma`` is one standard deviation."""

    spacing: float  # at the configured speed of sound [m]
    spacing_sigma: float
    azimuth: float  # of the sound in the frame of the headings as they are configured [rad]
    azimuth_sigma: float
    offset: float | None  # to be added to the heading offset [rad]; None: the azimuth of the sound was not told
    swapped: bool | None  # microphones 1 and 2; None: the azimuth of the sound was not told
    gain_db: float  # of microphone 2 over microphone 1
    gain_sigma_db: float
    inverted: bool  # the microphones have opposite polarity
    delay: float | None  # of microphone 2 before microphone 1, whatever the heading [s]; None: the turn was too small
    delay_sigma: float | None
    roll_off: float | None  # of microphone 2 above that of microphone 1 [Hz]; None: the turn was too small
    roll_off_sigma: float | None
    direct: float  # share of direct sound, 1 in the open
    headings: int
    turn: float  # [rad]


def calibrate(
    spectra: Sequence[HeadingSpectrum],
    speed_of_sound: float,
    *,
    azimuth: float | None = None,
    elevation: float = 0.0,
    configured: float = 0.05,
) -> Calibration:
    """Estimate spacing, heading offset, gain, polarity, roll-off and swap of two microphones from one sound and a turn.

    Only the ratio of spacing to speed of sound can be heard: 1 degree Celsius is 0.17 % of the spacing. Of a sound
    whose azimuth is not told the offset cannot be, nor whether the microphones are swapped, since an array that is
    mounted turned hears the same.

    Parameters
    ----------
    spectra
        What was heard at every heading.
    speed_of_sound
        v_p [m/s].
    azimuth
        True azimuth of the sound, in the frame of the headings [rad]; None: not known.
    elevation
        Of the sound as seen from the array [rad]: it shortens all delays by its cosine.
    configured
        Spacing as it is configured [m]; up to twice as much is looked for.

    Raises
    ------
    NotCalibrated
        When the sound, the turn or the room does not allow it; one line.
    """
    usable = _usable(spectra)
    turn, span = Turn.of(usable), span_of([each.heading for each in usable])
    if span < SMALLEST:
        raise NotCalibrated(f"expected a turn of at least {_deg(SMALLEST)} deg, got {_deg(span)}")
    widest = max(WIDEST, 2 * configured) / speed_of_sound
    found = fit(turn, widest, free=span >= DELAY_FROM)
    _check_room(turn, found, speed_of_sound)
    length = speed_of_sound / math.cos(elevation)
    variance = np.diag(found.covariance)
    bias = BIAS * (1 - found.direct)
    spacing, gain = found.amplitude * length, _gain(turn, found)
    spacing_sigma = math.hypot(math.sqrt(variance[0]) * length, bias * length, SPACING_FLOOR * spacing)
    if spacing_sigma > VAGUE * spacing:
        told = f"{1e3 * spacing:.1f} +- {1e3 * spacing_sigma:.1f} mm"
        raise NotCalibrated(f"the spacing is too uncertain ({told}): listen longer, turn further, or go nearer")
    offset, swapped = _offset(found.azimuth, azimuth)
    free = span >= DELAY_FROM
    return Calibration(
        spacing, spacing_sigma,
        found.azimuth, math.hypot(math.sqrt(variance[1]), bias / found.amplitude, ANGLE_FLOOR),
        offset, swapped,
        *gain,
        inverted=found.inverted,
        delay=found.delay if free else None,
        delay_sigma=math.hypot(math.sqrt(variance[2]), bias, DELAY_FLOOR) if free else None,
        roll_off=found.roll_off if free else None,
        roll_off_sigma=math.hypot(math.sqrt(variance[3]), ROLL_OFF_FLOOR) if free else None,
        direct=found.direct, headings=len(usable), turn=span,
    )  # fmt: skip


def span_of(headings: Sequence[float]) -> float:
    """Angle [rad] that headings cover, a whole turn at most: the circle without its largest gap, or with it.

    Headings at equal steps around the whole circle cover all of it:

    >>> round(math.degrees(span_of([math.radians(a) for a in (0, 120, 240)])))
    360
    >>> round(math.degrees(span_of([math.radians(a) for a in (350, 0, 20)])))
    30
    """
    ordered = np.sort(np.mod(headings, 2 * np.pi))
    if len(ordered) < 2:
        return 0.0
    gaps = np.append(np.diff(ordered), ordered[0] + 2 * np.pi - ordered[-1])
    others = np.delete(gaps, gaps.argmax())
    full = gaps.max() <= 1.5 * max(float(others.max(initial=0.0)), 1e-3)
    return float(2 * np.pi if full else 2 * np.pi - gaps.max())


def _usable(spectra: Sequence[HeadingSpectrum]) -> list[HeadingSpectrum]:
    """Return the headings at which the sound was heard."""
    if len(spectra) < FEWEST:
        raise NotCalibrated(
            f"expected to listen at {FEWEST} headings at rest or more, for 0.5 s or more, got {len(spectra)}"
        )
    if any(each.clipped for each in spectra):
        count = sum(each.clipped for each in spectra)
        raise NotCalibrated(
            f"samples at full scale at {count} of {len(spectra)} headings: turn the sound, or the gain, down"
        )
    median = float(np.median([each.power_db for each in spectra]))
    usable = [each for each in spectra if each.coherence >= HEARD and each.power_db >= median - QUIETER_DB]
    if len(usable) < max(FEWEST, STEADY * len(spectra)):
        louder = float(np.median([each.level_db for each in spectra]))
        if abs(louder) > DEAD_DB:
            dead = 1 if louder > 0 else 2
            raise NotCalibrated(f"microphone {dead} is dead: it gives nothing, or {DEAD_DB:.0f} dB less than the other")
        raise NotCalibrated(
            f"the sound is not steady or too soft: expected to hear it at {math.ceil(STEADY * len(spectra))} of "
            f"{len(spectra)} headings or more, got {len(usable)}"
        )
    well = np.mean([each.weight for each in usable], axis=0) > WELL
    width = float(np.count_nonzero(well) * (usable[0].frequencies[1] - usable[0].frequencies[0]))
    if width < BROAD:
        raise NotCalibrated(
            f"expected a sound of {BROAD:.0f} Hz of bandwidth or more (noise, a talker), got {width:.0f} Hz"
        )
    return usable


def _check_room(turn: Turn, found: TurnFit, speed_of_sound: float) -> None:
    if found.amplitude * speed_of_sound < NARROWEST:
        raise NotCalibrated(
            "the delay is the same at all headings: expected a sound at one place, not from all sides or on the "
            "turntable, and two channels"
        )
    share, where = second_source(turn, found)
    if share > max(OTHER * found.direct, OTHER_LEAST):
        apart = abs(_deg(wrap(where - found.azimuth)))
        raise NotCalibrated(f"two sounds were heard, {apart} deg apart: expected one alone")
    if found.direct < DIRECT:
        raise NotCalibrated(
            f"too reverberant, or the sound has moved: expected {DIRECT:.2f} of it or more to come straight, "
            f"got {found.direct:.2f}; put it nearer, at 1 m, away from walls"
        )


def _offset(measured: float, true: float | None) -> tuple[float | None, bool | None]:
    """Correction of the heading offset [rad] and whether the microphones are swapped; None when it cannot be told.

    >>> _offset(0.25, 0.5), _offset(0.5 + math.pi, 0.5), _offset(0.5, None)
    ((0.25, False), (0.0, True), (None, None))
    """
    if true is None:
        return None, None
    offset = wrap(true - measured)
    swapped = abs(abs(offset) - math.pi) < SWAPPED
    return (wrap(offset + math.pi) if swapped else offset), swapped


def _gain(turn: Turn, found: TurnFit) -> tuple[float, float]:
    """Level of microphone 2 over microphone 1, and one standard deviation [dB].

    A near source is louder at the nearer microphone, by as much in turn: that part follows the cosine and is left out.
    """
    cosine = np.cos(found.azimuth - turn.headings)
    weights = turn.weight.sum(axis=1)
    levels = (turn.weight * turn.level_db).sum(axis=1) / weights
    nearness = _nearness(levels, cosine, weights)
    left = levels - nearness * cosine
    mean = float(np.average(left, weights=weights))
    n = len(levels)
    spread = math.sqrt(float(np.average((left - mean) ** 2, weights=weights)) / max(n - 2, 1))
    share = abs(float(np.average(cosine, weights=weights)))  # of the uncertain nearness that looks like a gain
    return mean, math.hypot(spread, share * abs(nearness) / 2, GAIN_FLOOR)


def _nearness(levels: Real, cosine: Real, weights: Real) -> float:
    """Level difference of the microphones for a source on the axis [dB], from 0 in the distance on."""
    around = cosine - np.average(cosine, weights=weights)
    variance = float((weights * around**2).sum())
    slope = float((weights * around * levels).sum()) / variance if variance > 0 else 0.0
    return max(slope, 0.0)


def _deg(angle: float) -> int:
    return round(math.degrees(angle))
