import re

import numpy as np
import pytest

from ross_payload.config import Config, load, validated
from ross_payload.dsp.stft import aliasing_limit
from ross_payload.errors import ConfigError
from ross_payload.localization.model_order import MAX_SOURCES


def write(path, text):
    path.write_text(text)
    return path


def test_an_empty_file_is_the_default(tmp_path):
    assert load(write(tmp_path / "a.toml", "")) == Config()


def test_the_hop_is_counted_in_samples(tmp_path):
    assert load(write(tmp_path / "a.toml", "[audio]\nrate_hz = 24000\nhop_ms = 20\n")).hop == 480


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[array]\nspacng_m = 0.05", "unknown key 'array.spacng_m'"),
        ("[array]\nspacing_m = 0", "array.spacing_m"),
        ("[array]\nspacing_m = nan", "array.spacing_m: expected a number, got nan"),
        ("[guard]\nlower_deg = 10\nupper_deg = -10", "expected lower_deg below upper_deg, got 10 and -10"),
        ("[guard]\npark_deg = 300", "park_deg"),
        ("[guard]\nmax_speed_deg_s = inf", "max_speed_deg_s"),
        ("[audio]\nhop_ms = 40", "hop_ms"),
        ("[telemetry]\nsystem_id = 256", "system_id"),
        ("[audio]\nframe = 129", "audio.frame"),
        ("[explore]\nframe = 1023", "explore.frame"),
        ("[audio]\nrate_hz = 8000", "audio.rate_hz"),
        ("[explore]\nmin_rotations = 5\nmax_rotations = 4", "expected min_rotations <= max_rotations, got 5 and 4"),
        (f"[exploit]\nruns = 1{'0' * 400}", "exploit.runs: expected a number less than or equal to 1000000"),
        ("[exploit]\ncriterion = 1e300", "exploit.criterion: expected a number less than or equal to 1000000"),
        ("[exploit]\nmax_restarts = 99999999999", "exploit.max_restarts"),
        ("[[links]]\nurl = 'udpout:127.0.0.1:14550'\nmax_bytes_s = 99999999999", "links.0.max_bytes_s"),
        ("not toml at all", "not TOML"),
        ("colour = 'red'", "unknown key 'colour'"),
    ],
)
def test_bad_values_are_named_in_one_line(tmp_path, text, words):
    with pytest.raises(ConfigError) as caught:
        load(write(tmp_path / "a.toml", text))
    assert words in str(caught.value)
    assert "a.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_byte_order_mark_in_front_is_no_part_of_a_file(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"\xef\xbb\xbf[array]\r\nspacing_m = 0.06\r\n")
    assert load(tmp_path / "a.toml").array.spacing_m == 0.06


def test_a_missing_file_and_a_binary_one_are_config_errors(tmp_path):
    with pytest.raises(ConfigError, match="cannot be read"):
        load(tmp_path / "nothing.toml")
    (tmp_path / "b.toml").write_bytes(bytes(range(128, 256)))
    with pytest.raises(ConfigError, match="expected UTF-8 text"):
        load(tmp_path / "b.toml")


def test_offset_is_in_radians(tmp_path):
    config = load(write(tmp_path / "a.toml", "[array]\noffset_deg = 90"))
    assert config.offset == pytest.approx(np.pi / 2)


def test_as_many_sources_can_be_told_as_can_be_found():
    degrees = [30 * k for k in range(MAX_SOURCES + 1)]
    assert len(Config.model_validate({"informed": {"azimuths_deg": degrees[1:]}}).informed.azimuths_deg) == MAX_SOURCES
    with pytest.raises(ValueError, match="at most"):
        Config.model_validate({"informed": {"azimuths_deg": degrees}})


def test_one_azimuth_at_two_heights_is_two_sources():
    assert Config.model_validate({"informed": {"azimuths_deg": [10, 10], "elevations_deg": [0, -60]}}).informed


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[array]\nspacng_m = 0.05", "unknown key 'array.spacng_m'; did you mean 'spacing_m'?"),
        ("[aray]\n", "unknown key 'aray'; did you mean 'array'?"),
        ("[[links]]\nurl = 'udpin:1'\nrole_ = 'ground'", "unknown key 'links.0.role_'; did you mean 'role'?"),
        ("[informed]\nazimuths_deg = [1.0]\ntaget = 0", "unknown key 'informed.taget'; did you mean 'target'?"),
        ("[array]\nqqq = 0.05", "unknown key 'array.qqq'"),
        ("[exploit]\nrules = 'bset'", "exploit.rules: expected 'best' or 'paper', got 'bset'; did you mean 'best'?"),
        ("[audio]\nrate_hz = 3", "audio.rate_hz: expected a number greater than or equal to 16000, got 3"),
        (
            "[audio]\nsource = 'tape'",
            "audio.source: expected device:NAME, file:PATH, tcp:HOST:PORT or NAME:ADDRESS of a plug-in, got 'tape'",
        ),
        ("[informed]\nazimuths_deg = []", "informed.azimuths_deg: expected at least 1 item, got []"),
        ("[[links]]\nrole = 'ground'", "links.0.url: expected a value, got none"),
        (f"[audio]\nsource = '{'x' * 5000}'", f"got '{'x' * 77}...'"),
    ],
)
def test_a_mistake_is_told_with_what_was_expected_and_what_may_be_meant(tmp_path, text, line):
    with pytest.raises(ConfigError) as caught:
        load(write(tmp_path / "a.toml", text))
    assert str(caught.value).endswith(line)


def test_a_frame_of_the_explorer_that_holds_no_frequency_below_the_aliasing_limit_is_refused():
    def config(frame, spacing):
        values = {"array": {"spacing_m": spacing}, "audio": {"rate_hz": 48000}, "explore": {"frame": frame}}
        return validated(Config, values, "a.toml")

    with pytest.raises(ConfigError, match=r"explore.frame: expected at least 140 samples .* 0.5 m .*, got 138"):
        config(138, 0.5)
    held = config(140, 0.5)
    first = held.audio.rate_hz / 140
    assert first <= aliasing_limit(0.5, held.array.speed_of_sound_m_s)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("seed = true", "seed: expected a number, got true"),
        ("[mount]\nyaw_deg = false", "mount.yaw_deg: expected a number, got false"),
        ("[mount]\nheight_m = true", "mount.height_m: expected a number, got true"),
        ("[guard]\nlower_deg = false", "guard.lower_deg: expected a number, got false"),
        ("[explore]\nframe = true", "explore.frame: expected a number, got true"),
        (
            "[[links]]\nurl = 'udpin:127.0.0.1:1'\nmax_bytes_s = false",
            "links.0.max_bytes_s: expected a number, got false",
        ),
        ("[audio]\nchannels = [true, 3]", "audio.channels: expected numbers, got [true, 3]"),
        ("[mount]\nyaw_deg = [true]", "mount.yaw_deg: expected numbers, got [true]"),
        ("[ego_noise]\nrotors_m = [[1, 2, false]]", "ego_noise.rotors_m: expected numbers, got [[1, 2, false]]"),
        ('"a[0]" = 1', "unknown key 'a[0]'"),
        ("[audio]\nint = 1", "unknown key 'audio.int'"),
        ("[recording]\nmax_gb = 1e300", "recording.max_gb: expected a number less than or equal to 10000, got 1e+300"),
        ("[audio]\nhop_ms = 1e300", "audio.hop_ms: expected a valid integer, got 1e+300"),
        ("audio = 3", "audio: expected a table, got 3"),
        ("[audio]\nchannels = 3", "audio.channels: expected a list, got 3"),
        ("[explore]\noptions = 'x'", "explore.options: expected a table, got 'x'"),
    ],
)
def test_a_value_of_another_type_is_refused(tmp_path, text, line):
    with pytest.raises(ConfigError, match=re.escape(line)):
        load(write(tmp_path / "a.toml", text))


def test_a_switch_is_a_switch(tmp_path):
    config = load(write(tmp_path / "a.toml", "[audio]\ninvert = [true, false]\n[exploit]\ntrack = false"))
    assert (config.audio.invert, config.exploit.track) == ((True, False), False)
