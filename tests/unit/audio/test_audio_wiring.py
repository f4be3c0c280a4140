"""Which channels are the microphones, and what is done to them."""

import re

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from manual import ROOT
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.open_source import open_source
from ross_payload.config import Audio, Config, validated
from ross_payload.config.array_presets import PRESETS
from ross_payload.errors import ConfigError
from ross_payload.interfaces import AudioBlock, AudioFlag
from ross_sim.clock import SimClock

RULES = ROOT / "docs/how-to/add-your-own-audio-source.md"


def pair(*values):
    return np.array([values, values], np.float32)


def test_a_preset_gives_what_the_configuration_does_not_say():
    wiring = ChannelMap.of(Audio(preset="respeaker-usb"))
    assert (wiring.channels, wiring.needed) == (PRESETS["respeaker-usb"].channels, 6)
    assert ChannelMap.of(Audio(preset="respeaker-usb", channels=(4, 3))).channels == (4, 3)
    assert ChannelMap.of(Audio(channels=(3, 0))).needed == 4


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"channels": (1, 1)}, "expected two different channels, got \\[1, 1\\]"),
        ({"channels": (0, 4), "preset": "respeaker-4mic"}, r"expected 0 to 3, as 4 channels are opened, got \[0, 4\]"),
        ({"channels": (0, 2), "device_channels": 2}, "as 2 channels are opened"),
    ],
)
def test_channels_that_cannot_be_are_refused(keys, said):
    with pytest.raises(ConfigError, match=said):
        ChannelMap.of(Audio(**keys))


def test_gain_and_polarity_reach_the_samples_and_not_the_raw():
    wired = ChannelMap.of(Audio(gain_db=(20.0, 0.0), invert=(False, True))).correction(16000).apply(pair(0.01, -0.02))
    assert wired.samples == pytest.approx(np.array([[0.1, -0.2], [-0.01, 0.02]]), abs=2**-22)
    assert np.abs(wired.raw - pair(0.01, -0.02)).max() <= 2**-24  # on the 24-bit grid too


def test_a_difference_of_roll_off_is_taken_out_of_the_samples_block_after_block():
    sound = np.random.default_rng(0).normal(0, 0.1, 4800)
    device = np.stack([sound, lfilter(*butter(1, 40.0, "highpass", fs=16000), sound)]).astype(np.float32)
    correction = ChannelMap.of(Audio(roll_off_hz=(0.0, 40.0))).correction(16000)
    wired = [correction.apply(device[:, first : first + 160]) for first in range(0, 4800, 160)]
    first, second = np.concatenate([each.samples for each in wired], axis=1)
    assert first == pytest.approx(second, abs=1e-6)
    assert np.concatenate([each.raw for each in wired], axis=1) == pytest.approx(device, abs=2**-24)


def test_a_source_of_ones_own_makes_its_blocks_as_the_manual_says():
    wiring = ChannelMap.of(Audio(channels=(1, 0), gain_db=(0.0, -6.0)))
    (rule,) = re.findall(
        r"Make one `wiring\.(\w+)\(rate\)`.* its `(\w+)`, .* `wiring\.(\w+)`", RULES.read_text("utf-8")
    )
    make, apply, channels = rule
    frames = np.zeros((160, 2), np.float32)
    wired = getattr(getattr(wiring, make)(16000), apply)(frames[:, list(getattr(wiring, channels))].T)
    assert AudioBlock(wired.samples, 0, 0.0, flags=wired.flags, raw=wired.raw, carried=wired.carried).samples.shape == (
        2,
        160,
    )


def test_without_gain_there_is_no_second_copy():
    assert ChannelMap.of(Audio()).correction(16000).apply(pair(0.5)).raw is None


def test_samples_off_the_grid_are_rounded_to_it():
    counts = ChannelMap.of(Audio()).correction(16000).apply(pair(1 / 3)).samples.astype(np.float64) * 2**23
    assert np.array_equal(counts, np.rint(counts))


@pytest.mark.parametrize("full", [1.0, -1.0, 32767 / 32768, 1 - 2**-23])
def test_full_scale_of_16_and_24_bits_is_clipping(full):
    assert ChannelMap.of(Audio()).correction(16000).apply(pair(0.1, full)).flags == AudioFlag.CLIPPED


def test_a_gain_that_goes_over_full_scale_clips_and_says_so():
    wired = ChannelMap.of(Audio(gain_db=(40.0, 0.0))).correction(16000).apply(pair(0.5))
    assert wired.samples[0] == pytest.approx(1 - 2**-23)
    assert wired.flags == AudioFlag.CLIPPED


def test_what_is_not_a_number_becomes_zero_and_is_flagged():
    wired = ChannelMap.of(Audio()).correction(16000).apply(pair(0.25, np.nan, np.inf))
    assert np.array_equal(wired.samples, pair(0.25, 0, 0))
    assert wired.flags == AudioFlag.INVALID


@pytest.mark.parametrize("source", ["microphone", "device:", ":x", "a b:c"])
def test_a_source_that_is_no_name_and_address_is_refused(source):
    with pytest.raises(ConfigError, match=r"audio\.source: expected device:NAME, file:PATH"):
        validated(Config, {"audio": {"source": source}}, "test")


@pytest.mark.parametrize("address", ["localhost", "localhost:x", "localhost:0", ":5000", "localhost:70000"])
def test_an_address_without_host_or_port_is_refused(address):
    config = validated(Config, {"audio": {"source": f"tcp:{address}"}}, "test")
    with pytest.raises(ConfigError, match="expected tcp:HOST:PORT"):
        open_source(config, SimClock())
