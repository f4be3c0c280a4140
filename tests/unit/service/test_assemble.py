"""From a configuration to what a mission is made of: settings, explorer, separator, planner, given azimuths."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.alignment.plan import plan
from ross_payload.config import Config
from ross_payload.errors import ConfigError, PluginError
from ross_payload.interfaces import Capabilities, Feedback
from ross_payload.mount import FixedMount, fixed_mount
from ross_payload.separation.refiner_features import trained_for
from ross_payload.service.assemble import explorer_of, informed_of, settings_of, tools_of
from ross_payload.service.payload import maker

CONFIG = Config.model_validate({"actuator": {"kind": "ideal"}, "array": {"offset_deg": 10}})


def test_a_compass_yaw_turns_the_other_way():
    config = Config.model_validate({"mount": {"yaw_deg": 30}})
    assert fixed_mount(config).attitude(0.0).yaw == pytest.approx(-math.radians(30))
    assert fixed_mount(config).attitude(0.0).known
    assert not fixed_mount(Config()).attitude(0.0).known


def test_settings_are_in_radians_and_seconds():
    settings = settings_of(CONFIG, -1.0, 1.0)
    assert settings.rotation == pytest.approx(math.radians(15))
    assert (settings.unit, settings.lower, settings.upper) == (3.0, -1.0, 1.0)


@pytest.mark.parametrize(("park", "meant"), [(20, 20), (-170, -100), (170, 90)])
def test_it_parks_within_what_the_hardware_can(park, meant):
    config = Config.model_validate({"guard": {"park_deg": park}})
    assert math.degrees(settings_of(config, math.radians(-100), math.radians(90)).park) == pytest.approx(meant)


def test_limits_that_a_device_tells_late_hold_for_the_next_task():
    wide = Capabilities(-3.0, 3.0, 1.0, 1.0, 0.01, continuous=False, feedback=Feedback.MEASURED)
    actuator = SimpleNamespace(capabilities=wide)
    make = maker(actuator, None)
    assert make(Config()).settings.upper == 3.0
    actuator.capabilities = replace(wide, upper=0.5)
    assert make(Config()).settings.upper == 0.5


def test_an_unknown_separator_is_named():
    config = Config.model_validate({"exploit": {"separator": "magic"}})
    with pytest.raises(PluginError, match=r"'magic' is unknown; there are: .*gaussian"):
        tools_of(config, voiceprint=None)


def test_a_model_of_voices_is_looked_for_where_somebody_is_enrolled_and_not_before(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    tools = tools_of(Config.model_validate({"voice_print": {"model": "removed"}}), voiceprint=None)
    with pytest.raises(ConfigError, match="voice model 'removed' is unknown"):
        tools.voice_model()


def test_told_azimuths_are_turned_with_the_mount():
    """A base that points east, 90 deg on a compass, has everything 90 deg further clockwise."""
    config = Config.model_validate({"mount": {"yaw_deg": 90}, "informed": {"azimuths_deg": [90, -90, 0]}})
    told = informed_of(config, fixed_mount(config).attitude(0.0))
    np.testing.assert_allclose([source.azimuth for source in told.sources], [0, np.pi, -np.pi / 2], atol=1e-12)
    assert [source.elevation for source in told.sources] == [None] * 3


def test_told_elevations_are_told_on():
    config = Config.model_validate({"informed": {"azimuths_deg": [90], "elevations_deg": [-60], "sigma_deg": 3}})
    source = informed_of(config, FixedMount().attitude(0.0)).sources[0]
    assert (source.elevation, source.sigma) == (pytest.approx(-np.pi / 3), pytest.approx(np.pi / 60))


def test_nothing_told_is_nothing_known():
    assert informed_of(CONFIG, FixedMount().attitude(0.0)) is None


def test_the_paper_front_end_is_a_set_of_options():
    plain = markov_of({"method": "markov-plain"})
    options = {"every_bin": True, "bandwidth": 0.05, "prominence": 0.04, "power": 0, "both_ways": False}
    options |= {"spread_deg": 24, "share": 0.15}
    markov = markov_of({"method": "markov", "options": options})
    assert (markov.trusts, markov.rule) == (plain.trusts, plain.rule)
    assert markov_of({"method": "markov"}).rule != plain.rule


def markov_of(table):
    """The explorer of a table, without the checks around it."""
    return explorer_of(Config.model_validate({"explore": table}))._explorer


@pytest.mark.parametrize(("rules", "planner"), [("best", plan), ("paper", paper_plan)])
def test_rules_name_what_plans(rules, planner):
    assert tools_of(Config.model_validate({"exploit": {"rules": rules}}), voiceprint=None).plan is planner


@pytest.mark.parametrize(
    ("rate", "given", "frame"),
    [(16000, None, 2048), (24000, None, 2048), (44100, None, 4096), (48000, None, 4096), (48000, 2048, 2048)],
)
def test_frames_of_the_separation_last_as_long_at_every_rate(rate, given, frame):
    audio = {"rate_hz": rate} | ({} if given is None else {"frame": given})
    stft = tools_of(Config.model_validate({"audio": audio, "actuator": {"kind": "ideal"}}), None).stft
    assert (stft.frame, stft.hop) == (frame, frame // 4)
    assert trained_for(stft.frequencies) == (given is None)
