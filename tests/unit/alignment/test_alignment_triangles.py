"""The paper's acute-triangle rule for more than three sources (Sec. III-B): when it holds, and when it does not.

The array is in the middle of a circle; sources are points on it. The rule reads: where the triangle of the target and
its nearest neighbour on either side is acute, no heading isolates the target better than the bisector of the two.
"""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples
from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.alignment.plan import Turn, isolation
from ross_payload.angles import wrap_axis
from ross_payload.events import SourceEstimate
from ross_payload.interfaces import Real

SPACING, SPEED = 343.0, 343.0  # d / v_p = 1 s
HEADINGS = np.pi * np.arange(720) / 720


def acute(a: float, b: float, c: float) -> bool:
    """A triangle in a circle is acute when its corners do not fit on half of the circle."""
    corners = np.sort(np.mod([a, b, c], 2 * np.pi))
    return bool(np.diff(corners, append=corners[0] + 2 * np.pi).max() < np.pi)


def neighbours(azimuths: Real) -> tuple[float, float]:
    """Nearest source on either side of the first one."""
    ahead = np.mod(azimuths[1:] - azimuths[0], 2 * np.pi)
    return float(azimuths[0] + ahead.min()), float(azimuths[0] + ahead.max())


def isolations(azimuths: Real) -> tuple[float, float]:
    """Isolation of the first source at the bisector of its neighbours, and the best at any heading."""
    headings = np.append(HEADINGS, np.mean(neighbours(azimuths)))
    curve = isolation(azimuths, headings, SPACING, SPEED)[0]
    return float(curve[-1]), float(curve[:-1].max())


@st.composite
def acute_layouts(draw: st.DrawFn, fewest: int = 0) -> Real:
    """A target, its neighbours at most half a circle apart from each other and from it, others in their back."""
    ahead = draw(st.floats(2, 178))
    behind = draw(st.floats(181 - ahead, 179))
    shares = draw(st.lists(st.floats(0.01, 0.99), min_size=fewest, max_size=3))
    others = [ahead + share * (360 - ahead - behind) for share in shares]
    return np.deg2rad(draw(st.floats(-180, 180)) + np.array([0.0, ahead, -behind, *others]))


@settings(max_examples=examples(200))
@given(acute_layouts())
def test_where_the_triangle_with_both_neighbours_is_acute_no_heading_beats_their_bisector(azimuths: Real) -> None:
    assert acute(float(azimuths[0]), *neighbours(azimuths))
    bisector, best = isolations(azimuths)
    assert bisector >= best - 1e-9


@settings(max_examples=examples(50))
@given(acute_layouts(fewest=1))
def test_the_paper_plans_for_such_a_target_is_the_bisector(azimuths: Real) -> None:
    sources = [SourceEstimate(float(azimuth), 0.01, 1.0, True) for azimuth in azimuths]
    planned = paper_plan(sources, Turn(0, 0, -4, 4), SPACING / SPEED)
    (chosen,) = [candidate for candidate in planned.candidates if candidate.source == 0]
    bisector, _ = isolations(azimuths)
    assert chosen.isolation >= bisector - 1e-9
    if bisector > 0.05:  # a flat top has many headings
        assert abs(wrap_axis(chosen.heading - float(np.mean(neighbours(azimuths))))) < 1e-6


def test_one_acute_triangle_of_other_sources_is_not_enough() -> None:
    """Target 0, neighbours 20 and -20 deg: that triangle is obtuse, the one of 0, 130 and -120 deg is acute.

    Heading 90 deg tells the target from its neighbours by sin 20 = 0.34; their bisector, heading 0, by 0.06 only.
    """
    azimuths = np.deg2rad([0.0, 20.0, -20.0, 130.0, -120.0])
    assert acute(azimuths[0], azimuths[3], azimuths[4])
    assert not acute(float(azimuths[0]), *neighbours(azimuths))
    bisector, best = isolations(azimuths)
    assert bisector < 0.07
    assert best > 0.34


@st.composite
def exceptions(draw: st.DrawFn) -> tuple[Real, float]:
    """A layout of the footnote, and half the angle between the target and its neighbour.

    The array lies along the chord of the two, so that they are heard at 90 deg - half and 90 deg + half. Half is less
    than arcsin(1 / 3) = 38.94 / 2 deg, and all others are heard within arccos(3 cos(90 deg - half)).
    """
    half = draw(st.floats(0.02, np.arcsin(1 / 3) - 0.02))
    reach = np.arccos(3 * np.sin(half))
    others = draw(st.lists(st.floats(-1, 1), min_size=2, max_size=3))
    return np.array([np.pi / 2 - half, np.pi / 2 + half, *(reach * np.array(others))]), half


@settings(max_examples=examples(100))
@given(exceptions(), st.floats(-np.pi, np.pi))
def test_in_the_exception_of_the_footnote_the_target_is_best_heard_along_the_chord(
    exception: tuple[Real, float], turned: float
) -> None:
    """Nobody poses as anybody there; the isolation is 2 sin(half), the most that the neighbour allows anywhere."""
    azimuths, half = exception
    assert not acute(float(azimuths[0]), *neighbours(azimuths))
    curve = isolation(azimuths + turned, [turned, *HEADINGS], SPACING, SPEED)[0]
    assert abs(curve[0] - 2 * np.sin(half)) < 1e-9
    assert curve[1:].max() <= curve[0] + 1e-9


def test_with_the_sign_that_is_printed_the_footnote_does_not_say_so() -> None:
    """Target and neighbour at 75 and 105 deg, half = 15 deg; the bound is arccos(3 cos 75) = 39 deg.

    An interferer beyond it, at 50 deg, is nearer to the target than the neighbour: cos 50 - cos 75 = 0.38 < 0.52.
    """
    inside, beyond = (isolation(np.deg2rad([75, 105, other]), [0.0], SPACING, SPEED)[0, 0] for other in (30, 50))
    assert abs(inside - 2 * np.sin(np.deg2rad(15))) < 1e-9
    assert beyond < 0.4
