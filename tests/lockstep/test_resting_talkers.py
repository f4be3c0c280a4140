"""Talkers at rest in a room with echoes: nobody is said to have moved."""

import pytest

from ross_sim.study.resting_talkers import RATE, scene_of, tracked
from ross_sim.talkers.synthetic_voices import voices_of


@pytest.fixture(scope="module")
def scene():
    return scene_of("A0.45", 3, 0, [voice.speech for voice in voices_of(None, RATE)], seconds=8)


def test_nobody_moves_while_everybody_rests_in_a_room_with_echoes(scene):
    assert tracked(scene, 0).moved_at_s is None


@pytest.mark.soak
def test_the_same_echoes_would_feign_a_move_in_the_open(scene):
    assert tracked(scene, 0, directness=1.0).moved_at_s is not None
