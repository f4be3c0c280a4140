"""Talkers at rest in a room with echoes: nobody is said to have moved."""

from dataclasses import replace

import pytest

from ross_sim.study.resting_talkers import RATE, scene_of, tracked
from ross_sim.study.rows.resting_rows import RestingRow, resting
from ross_sim.talkers.synthetic_voices import voices_of


@pytest.fixture(scope="module")
def scene():
    return scene_of("A0.45", 3, 0, [voice.speech for voice in voices_of(None, RATE)], seconds=8)


def test_nobody_moves_while_everybody_rests_in_a_room_with_echoes(scene):
    assert tracked(scene, 0).moved_at_s is None


@pytest.mark.soak
def test_the_same_echoes_would_feign_a_move_in_the_open(scene):
    assert tracked(scene, 0, directness=1.0).moved_at_s is not None


def test_the_table_counts_scenes_in_which_somebody_is_said_to_have_moved():
    rest = RestingRow("S1", 3, 0, True, None, 0.0, 0.0)
    moved = replace(rest, seed=1, moved_at_s=4.0, share=0.5, worst_deg=12.4)
    rows = [rest, moved, replace(rest, setting="A0.3"), replace(moved, explored=False)]
    assert [line[:2] for line in resting(rows).rows] == [
        ("explored, S1, K = 3", "1/2 (9-91 %)"),
        ("explored, A0.3, K = 3", "0/1 (0-79 %)"),
        ("explored, true rooms", "0/1 (0-79 %)"),
        ("explored, all", "1/3 (6-79 %)"),
        ("told, S1, K = 3", "1/1 (21-100 %)"),
        ("told, all", "1/1 (21-100 %)"),
    ]
    assert resting(rows).rows[0][2:] == ("0.25", "12")
