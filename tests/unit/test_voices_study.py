"""The study of the voice print: which rooms it tells apart, and what its errors count."""

import numpy as np
import pytest

from ross_sim.study.room_settings import SETTINGS
from ross_sim.study.voiceprint_study import Trial, separated_voice, summary

RATE = 24000


def trial(room, talker, print_of, value, present=True):
    return Trial(room, 0, 3.0, True, talker, print_of, present, value)


def test_every_room_has_a_line_of_its_own_errors():
    found = [trial("S1", "a", "a", 1.0), trial("S1", "b", "a", -1.0), trial("S1", "b", "c", -1.0, present=False)]
    found += [trial("S2", "a", "a", -1.0), trial("S2", "b", "a", 1.0), trial("S2", "b", "c", 1.0, present=False)]
    rows = [line.split() for line in summary(found)[1:]]
    assert [row[0] for row in rows] == ["S1", "S2"]
    assert [row[4:6] for row in rows] == [["0.0", "0.0"], ["100.0", "100.0"]]  # false rejects, false accepts


@pytest.mark.parametrize(("room", "least"), [("S1", 0.8), ("S2", 0.5)])
def test_the_separated_voice_is_most_of_all_like_its_talker(room, least):
    rng = np.random.default_rng(0)
    t = np.arange(2 * RATE) / RATE
    envelopes = [np.sin(2 * np.pi * rate * t) > 0 for rate in (1.0, 1.7, 2.3)]
    voices = [envelope * rng.standard_normal(t.size) for envelope in envelopes]
    voice = separated_voice(voices, np.deg2rad([170.0, 70.0, -50.0]), 0, SETTINGS[room], rng)
    loudness = voice.reshape(-1, 1200).std(axis=1)
    alike = [np.corrcoef(loudness, other.reshape(-1, 1200).std(axis=1))[0, 1] for other in voices]
    assert alike[0] > least
    assert alike[0] > max(alike[1:])
