"""The study of headings: what a rule loses, and that a fit finds the constants that made the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ross_payload.alignment.plan import ENOUGH
from ross_payload.alignment.predicted_gain import BETWEEN, ECHOES, REACH, predicted_gain
from ross_sim.study.predicted_gain_study import RULES, Curve, curves, fit, row_of
from ross_sim.study.rows.heading_rows import headings
from ross_sim.study.runs.study_case import perform
from ross_sim.study.runs.study_design import Task, chosen
from ross_sim.study.runs.talker_placement import Source
from ross_sim.study.scenes.mixtures import PAPER_DEG, aligned_heading
from ross_sim.study.scenes.room_settings import SETTINGS

HEADINGS = np.deg2rad(np.arange(0.0, 180.0, 0.5))


def curve(azimuths_deg: list[float], target: int) -> Curve:
    """A world in which the prediction for reverberation is the truth."""
    azimuths = np.deg2rad(azimuths_deg)
    return Curve(azimuths, target, 0.0, HEADINGS, predicted_gain(azimuths, HEADINGS)[target])


def test_where_the_prediction_is_true_its_heading_loses_nothing() -> None:
    regret = curve([0.0, 20.0, -40.0], 0).regret_db
    assert regret["gain"] == pytest.approx(0, abs=1e-9)
    assert regret["paper"] > 1  # 1 - cos 30 = 0.13 d / v_p at the bisector
    assert regret["mean"] > 1


def test_a_row_has_what_every_rule_loses_against_the_best_heading() -> None:
    found = curve([0.0, 20.0, -40.0], 1)
    row = row_of(found, "S2", 4, 9)
    assert (row.setting, row.k, row.layout, row.target, row.seed) == ("S2", 3, 4, 1, 9)
    lost = row.gain_db, row.paper_db, row.isolation_db, row.mean_db
    assert lost == pytest.approx([found.regret_db[rule] for rule in (*RULES, "mean")], abs=1e-6)
    assert row.rank == pytest.approx(1.0)
    (line,) = headings([row, replace(row, best_db=row.best_db + 2, paper_db=row.paper_db + 1)]).rows
    assert line[0] == "S2, K = 3"
    assert line[1].startswith(f"{row.best_db + 1:.1f} ± ")
    assert line[3].startswith(f"{row.paper_db + 0.5:.2f} ± ")


def test_the_rules_agree_on_two_interferers_opposite_the_target() -> None:
    azimuths = np.deg2rad([0.0, 145.0, -145.0])
    for rule in RULES.values():
        assert abs(np.sin(rule(azimuths, 0, 0.0))) < np.sin(np.deg2rad(1))


def test_a_fit_finds_the_constants_that_made_the_data() -> None:
    rng = np.random.default_rng(0)
    found = fit([curve(rng.uniform(-180, 180, 4).tolist(), target) for target in range(4) for _ in range(3)])
    np.testing.assert_allclose(found, (REACH[1], ECHOES[1], BETWEEN[1]), rtol=1e-3)


@pytest.mark.soak
def test_two_noises_that_are_told_apart_gain_and_those_that_pose_as_one_do_not() -> None:
    """Synthetic talkers that take turns, so that a model of every bin can separate them."""
    rng = np.random.default_rng(0)
    voices = [rng.standard_normal(24000) * (np.arange(24000) // 2400 % 2 == turn) for turn in (0, 1)]
    (first, _) = curves(voices, 2, SETTINGS["S1"], 1, 0, step_deg=30.0)
    tau = np.cos(first.azimuths[:, None] - first.headings)
    apart = np.abs(tau[0] - tau[1])
    assert first.si_sdri_db[apart.argmax()] > 5
    assert first.si_sdri_db[apart.argmin()] < first.si_sdri_db[apart.argmax()] - 5


@pytest.mark.parametrize(("room", "directness"), [("S1", 1.0), ("S2", None)])
def test_a_study_points_at_the_best_heading_of_the_room_or_at_the_papers(room: str, directness: float | None) -> None:
    chosen_headings = {}
    for rules in ("best", "paper"):
        asked = {"settings": (room,), "separators": ("duet",), "rules": rules, "run_s": 1.0, "rate_hz": 8000}
        study, task = chosen("separation", asked, quick=False), Task(room, 3, 0, target=0)
        (row, *_) = perform(task, study, Source(None, (), 8000)).separations
        chosen_headings[rules] = np.deg2rad(row.heading_deg)
    azimuths = np.deg2rad(PAPER_DEG[:3])
    assert np.sin(chosen_headings["paper"] - aligned_heading(azimuths, 0)) == pytest.approx(0, abs=1e-6)
    gains = predicted_gain(azimuths, [chosen_headings["best"], *HEADINGS], directness=directness)[0]
    assert gains[0] >= gains.max() - ENOUGH  # for less the array stays where it is
