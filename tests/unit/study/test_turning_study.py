"""A study that explores without a pause: what is rendered, what is compared, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.dsp.steering import tdoa
from ross_payload.errors import ConfigError
from ross_sim.study.rows.motion_rows import MotionRow, as_soon, motion_rows, motions, paired, rising
from ross_sim.study.runs.exploration_course import course_of
from ross_sim.study.runs.study_case import perform
from ross_sim.study.runs.study_design import Task, chosen
from ross_sim.study.runs.talker_placement import Source, placed
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND
from ross_sim.study.scenes.turning_render import GRID, N_HALF, HalfTurn, Turning, render_turning
from voice_folders import voice_folder

RATE = 16000
TURNING = {
    "settings": ("S1",), "k": (1,), "layouts": 0, "separators": (), "rotations": (3,), "unit_s": (1.0,),
    "turning_deg_s": (0.0, 60.0), "turn_deg": 180.0, "rate_hz": RATE,
}  # fmt: skip
STEPPING = Task("S1", 1, 0, start=0, explorer="joint", unit=1.0)


def study(**changes):
    return chosen("quick", TURNING | changes, False)


# ------------------------------------------------------------------------------------------ what is rendered


def test_the_array_turns_half_a_turn_at_its_rate_and_back():
    degrees = np.rad2deg(Turning(np.deg2rad(30.0)).headings(12.7))
    assert degrees[0] == 0.0
    assert degrees.max() == pytest.approx(180.0)
    assert np.diff(degrees)[50:500] == pytest.approx(0.3)  # of 10 ms
    assert degrees[-1] == pytest.approx(0.0)  # 180 deg take 6.27 s, and it rests for 0.13 s


def test_half_a_turn_on_the_microphones_change_places():
    responses = np.random.default_rng(0).standard_normal((N_HALF, 2, 1, 8)).astype(np.float32)
    table = HalfTurn(responses)
    np.testing.assert_array_equal(table.at(GRID[5]), responses[5])
    np.testing.assert_array_equal(table.at(GRID[5] + np.pi), responses[5][::-1])
    np.testing.assert_array_equal(table.at(GRID[5] + 2 * np.pi), responses[5])


def test_what_is_heard_at_every_moment_has_the_delay_of_the_heading_then():
    """In the open, of one noise: d / v_p cos(theta - phi), seen in the phase of the cross-spectrum."""
    azimuth, rng = np.array([0.6]), np.random.default_rng(0)
    path = Turning(np.deg2rad(60.0)).headings(3.0)
    heard = render_turning([rng.standard_normal(4 * RATE)], azimuth, SETTINGS["S1"], path, rng, rate=RATE)
    frequencies = np.fft.rfftfreq(RATE // 10, 1 / RATE)
    band = (frequencies > 300) & (frequencies < 2500)
    for begin in np.arange(0.5, 2.8, 0.3):
        part = np.fft.rfft(heard[:, round(begin * RATE) : round(begin * RATE) + RATE // 10] * np.hanning(RATE // 10))
        cross = (part[1] * part[0].conj())[band]
        lags = np.linspace(-1.2, 1.2, 241) * SPACING / SPEED_OF_SOUND
        found = lags[(cross * np.exp(-2j * np.pi * lags[:, None] * frequencies[band])).real.sum(axis=1).argmax()]
        heading = float(path[round((begin + 0.05) * 100)])
        assert found == pytest.approx(float(tdoa(azimuth, heading, SPACING, SPEED_OF_SOUND)[0]), abs=1e-5)


# ------------------------------------------------------------------------------------------ how it goes


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return Source(voice_folder(tmp_path_factory.mktemp("voices"), (0, 1, 3), 20), (), RATE)


def test_steps_take_the_time_of_the_turns_and_a_turn_only_that_of_listening(source):
    stage = placed(study(), source, STEPPING)
    steps, turn = (course_of(study(), replace(STEPPING, rate=rate), stage) for rate in (0.0, 60.0))
    assert np.rad2deg(steps.headings) == pytest.approx([0, 15, 30, 45])
    assert np.diff(steps.times) == pytest.approx(1.0 + 2 * np.sqrt(15 / 112.5) + 0.13, abs=1e-3)
    assert turn.times == pytest.approx([1, 2, 3])
    assert np.rad2deg(turn.headings[0]) == pytest.approx(60 - 60 * 60 / (2 * 112.5))  # it begins from rest


@pytest.mark.soak
def test_a_talker_is_found_while_the_array_turns_and_the_row_says_when(source):
    rows = perform(replace(STEPPING, rate=60.0), study(), source).explorations
    assert [row.time_s for row in rows] == [1.0, 2.0, 3.0]
    assert {row.turning_deg_s for row in rows} == {60.0}
    assert rows[-1].k_estimated == 1
    assert rows[-1].errors_deg[0] < 2
    (compared,) = motion_rows(rows)
    assert compared.times_s == (1.0, 2.0, 3.0)
    assert compared.right[-1]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"turning_deg_s": (3.0,)}, "expected 0, or at least 5 deg/s, got 3"),
        ({"explorers": ("markov",)}, "expected explorers that hear while turning, got markov"),
    ],
)
def test_what_cannot_turn_is_refused(changes, words):
    with pytest.raises(ConfigError, match=words):
        study(**changes)


# ------------------------------------------------------------------------------------------ what is compared


def row(layout, rate, times, right, certain):
    letters = [tuple(letter == "x" for letter in word) for word in (right, certain)]
    return MotionRow("S1", 2, layout, 0, "1", 0, "joint", 3.0, rate, times, *letters)


STEPS = [row(i, 0.0, (10.0, 20.0, 30.0), "..x", "..x") for i in range(3)]
TURNS = [
    row(0, 20.0, (3.0, 6.0, 9.0), ".xx", "..x"),
    row(1, 20.0, (3.0, 6.0, 9.0), "..x", "..x"),
    row(2, 20.0, (3.0, 6.0, 9.0), "xxx", ".x."),
]


def test_an_exploration_ends_where_it_is_certain_first_else_in_the_end():
    assert [each.end_s for each in TURNS] == [9.0, 9.0, 6.0]
    assert row(0, 0.0, (1.0, 2.0), "x.", "..").end_s == 2.0
    assert not row(0, 0.0, (1.0, 2.0), "x.", "..").right_at_end
    assert not TURNS[0].right_after(2.9)


def test_as_soon_is_the_first_time_at_which_as_many_are_right():
    assert as_soon(STEPS, TURNS) == 9.0
    assert as_soon([STEPS[0], replace(STEPS[1], right=(False,) * 3), STEPS[2]], TURNS) == 6.0
    assert as_soon(STEPS, [replace(each, right=(False,) * 3) for each in TURNS]) is None


def test_one_lucky_moment_does_not_count():
    lucky = [row(i, 20.0, (3.0, 6.0, 9.0), "x..", "..x") for i in range(3)]
    assert as_soon(STEPS, lucky) is None
    assert rising(np.array([1.0, 0.0, 0.0])) == pytest.approx(1 / 3)


def test_only_scenes_that_were_explored_both_ways_are_compared():
    assert paired([*STEPS[:2], *TURNS], 20.0) == list(zip(STEPS[:2], TURNS[:2], strict=True))
    (room, every) = motions([*STEPS, *TURNS]).rows
    assert room[0] == "S1, 20 deg/s"
    assert every[2:5] == ("3/3 (44-100 %)", "8.0 ± 4.3", "3/3 (44-100 %)")
    assert every[5].startswith("0.27 (")  # 8 s of 30
    assert every[6] == "9"
    assert every[7].startswith("0.30 (")


def test_one_explorer_with_one_listening_time_is_never_compared_with_another_one():
    """The second T_unit takes a third of the time in both ways, the other explorer ten times as long."""
    short = [replace(each, unit_s=1.0, times_s=tuple(t / 3 for t in each.times_s)) for each in (*STEPS, *TURNS)]
    other = [replace(each, explorer="other", times_s=tuple(10 * t for t in each.times_s)) for each in (*STEPS, *TURNS)]
    (_, alone) = motions([*STEPS, *TURNS]).rows
    mixed = {line[0]: line[1:] for line in motions([*STEPS, *TURNS, *short, *other]).rows}
    every = [f"all, {method}, 20 deg/s" for method in ("joint, 3 s", "joint, 1 s", "other, 3 s")]
    assert [name for name in mixed if name.startswith("all")] == every
    assert mixed[every[0]] == alone[1:]
    assert [mixed[name][0] for name in every] == ["30.0 ± 0.0", "10.0 ± 0.0", "300.0 ± 0.0"]
    assert {mixed[name][4] for name in every} == {alone[5]}


def test_without_an_exploration_step_by_step_there_is_nothing_to_compare():
    assert motions(TURNS).rows == ()
