"""Rotors in the plan: a heading that gives one of them the delay of the target is no good."""

import math

import numpy as np
import pytest

from ross_payload.alignment.plan import Turn, plan
from ross_payload.alignment.predicted_gain import gain_of, phasors
from ross_payload.config import Config, validated
from ross_payload.dsp.rotors import Rotors
from ross_payload.errors import ConfigError
from ross_payload.events import SourceEstimate
from ross_payload.service.assemble import in_noise_of, rotors_of, settings_of

UNIT = 0.05 / 343
FREE = Turn(base=0.0, joint=0.0, lower=-math.inf, upper=math.inf)


def talkers(*azimuths_deg):
    return [SourceEstimate(math.radians(azimuth), 0.01, 1.0, True) for azimuth in azimuths_deg]


def apart(azimuth, beside, heading):
    """Least difference of the delay of a talker from that of a rotor [d / v_p]."""
    rotors = (beside * np.exp(-1j * heading)).real
    return np.abs(math.cos(azimuth - heading) - rotors).min()


def test_a_lone_talker_is_turned_away_from_a_rotor():
    beside = phasors([math.radians(50)])
    (chosen,) = plan(talkers(40), FREE, UNIT, 1.0, beside=beside, share=1.0).candidates
    assert apart(math.radians(40), beside, chosen.heading) > 0.15
    (stays,) = plan(talkers(40), FREE, UNIT, 1.0).candidates
    assert stays.rule == "stay"


def test_rotors_leak_the_more_the_nearer_their_delay_and_the_louder_they_are():
    source, beside = phasors([0.0, 2.0]), phasors([math.radians(60)])
    headings = np.radians([30.0, 120.0])
    posing, clear = gain_of(source, headings, 1.0, beside, 1.0)[0]
    without = gain_of(source, headings, 1.0)[0]
    assert without[0] - posing > without[1] - clear > 0
    assert gain_of(source, headings, 1.0, beside, 0.2)[0, 0] > posing


def test_nothing_beside_changes_nothing():
    source, headings = phasors([0.0, 2.0, -1.0]), np.radians([0.0, 40.0, 80.0])
    assert np.array_equal(gain_of(source, headings, 1.0), gain_of(source, headings, 1.0, np.zeros(0, complex), 1.0))


def test_rotors_turn_with_the_vehicle():
    rotors = Rotors(((0.25, 0.25, 0.0),), 0.05, 343.0)
    assert np.angle(rotors.phasors(math.radians(30)))[0] == pytest.approx(math.radians(75))


def test_without_a_table_nothing_is_learnt():
    config = Config()
    assert rotors_of(config) is None
    assert in_noise_of(config) is None
    assert not settings_of(config, -1.0, 1.0).ego_noise
    assert "ego_noise" not in config.model_dump()


def test_the_table_says_where_the_rotors_are():
    config = validated(Config, {"ego_noise": {"learn": True, "rotors_m": [[0.2, 0.1, 0.05]]}}, "test.toml")
    assert rotors_of(config).places == ((0.2, 0.1, 0.05),)
    assert settings_of(config, -1.0, 1.0).ego_noise
    assert in_noise_of(config) is not None
    markov = validated(Config, {"ego_noise": {"learn": True}, "explore": {"method": "markov"}}, "test.toml")
    assert in_noise_of(markov) is None


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"learn": True, "rotors_m": [[0.01, 0.0, 0.0]]}, "expected places at least 0.1 m from the array"),
        ({"rotors_m": [[0.2, 0.0, 0.0]]}, "expected learn = true beside them, got false"),
    ],
)
def test_a_table_that_makes_no_sense_is_told(table, said):
    with pytest.raises(ConfigError, match=said):
        validated(Config, {"ego_noise": table}, "test.toml")
