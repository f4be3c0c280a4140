"""Known arrays: their channels, and the spacing that follows from the pair that is used."""

from typing import get_args

import pytest

from doctor_bench import config, machine, said
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.config import Audio, Config
from ross_payload.config.array_presets import PRESETS, fitting
from ross_payload.config.parameter_store import Parameters
from ross_payload.doctor import examination
from ross_payload.doctor.findings import Verdict


def array(table=None, **audio):
    return config(**({"array": table} if table is not None else {}), audio=audio).array


def test_every_preset_can_be_configured():
    assert set(get_args(Audio.model_fields["preset"].annotation)) == {"", *PRESETS}


@pytest.mark.parametrize(
    ("preset", "channels", "spacing"),
    [
        ("respeaker-usb", None, 0.0453),
        ("respeaker-usb", (1, 3), 0.064),
        ("respeaker-usb", (4, 2), 0.064),
        ("respeaker-usb", (4, 1), 0.0453),
        ("respeaker-xvf3800", None, 0.066),
        ("respeaker-xvf3800", (2, 4), 0.0933),
        ("respeaker-xvf3800-2ch", None, 0.066),
        ("respeaker-4mic", (0, 2), 0.0813),
        ("respeaker-usb", (0, 1), 0.05),  # 0 is processed
        ("usb-stereo", None, 0.05),
        ("", None, 0.05),
    ],
)
def test_the_spacing_is_that_of_the_pair_where_it_is_known(preset, channels, spacing):
    assert array(preset=preset, channels=channels).spacing_m == pytest.approx(spacing, abs=5e-5)


def test_what_the_file_tells_counts():
    assert array({"spacing_m": 0.06}, preset="respeaker-usb").spacing_m == 0.06
    assert array({"offset_deg": 3.0}, preset="respeaker-usb").offset_deg == 3.0
    assert array({"offset_deg": 3.0}, preset="respeaker-usb").spacing_m == pytest.approx(0.0453, abs=5e-5)


def test_a_configuration_that_was_written_down_reads_the_same_again(tmp_path):
    first = config(audio={"preset": "respeaker-xvf3800", "channels": (2, 4)})
    assert Config.model_validate(first.model_dump(mode="json")) == first
    with Parameters(first, tmp_path / "params.toml") as parameters:
        assert parameters.config.array == first.array


@pytest.mark.parametrize("key", PRESETS)
def test_the_pair_of_a_preset_is_of_raw_microphones_that_are_opened(key):
    preset = PRESETS[key]
    wiring = ChannelMap.of(Audio(preset=key))
    assert wiring.channels == preset.channels
    assert max(preset.channels) < wiring.needed == preset.device_channels
    assert not preset.places or set(preset.channels) <= preset.places.keys()


@pytest.mark.parametrize(
    ("name", "channels", "preset"),
    [
        ("ReSpeaker 4 Mic Array (UAC1.0): USB Audio (hw:1,0)", 6, "respeaker-usb"),
        ("ReSpeaker 4 Mic Array (UAC1.0): USB Audio (hw:1,0)", 1, ""),  # the firmware of one channel has none raw
        ("reSpeaker XVF3800 4-Mic Array: USB Audio (hw:2,0)", 6, "respeaker-xvf3800"),
        ("reSpeaker XVF3800 4-Mic Array: USB Audio (hw:2,0)", 2, "respeaker-xvf3800-2ch"),
        ("snd_rpi_googlevoicehat_soundcar: Google voiceHAT SoundCard HiFi (hw:1,0)", 2, "i2s-stereo"),
        ("HDA Intel PCH: ALC257 Analog (hw:0,0)", 2, ""),
    ],
)
def test_a_device_is_known_by_its_name_and_channels(name, channels, preset):
    assert fitting(name, channels) == preset


def doctor(tmp_path, **tables):
    return said(examination.array(config(**tables), machine(tmp_path)))


def test_the_doctor_names_a_channel_that_is_no_raw_microphone(tmp_path):
    verdict, text = doctor(tmp_path, audio={"preset": "respeaker-xvf3800", "channels": (1, 2)})
    assert verdict is Verdict.FAIL
    assert "channel 1 of 'respeaker-xvf3800' is no raw microphone; these are: 2, 3, 4, 5" in text


def test_the_doctor_names_a_spacing_that_is_not_the_arrays(tmp_path):
    verdict, text = doctor(tmp_path, audio={"preset": "respeaker-usb"}, array={"spacing_m": 0.05})
    assert verdict is Verdict.WARN
    assert "spacing_m is 50.0 mm, but microphones 1 and 2 of 'respeaker-usb' are 45.3 mm apart" in text


def test_the_doctor_asks_for_a_spacing_that_nobody_told(tmp_path):
    verdict, text = doctor(tmp_path, audio={"preset": "usb-stereo"})
    assert verdict is Verdict.WARN
    assert "50 mm is assumed" in text


@pytest.mark.parametrize("spacing", [{}, {"spacing_m": 0.0453}, {"spacing_m": 0.046}])
def test_a_spacing_that_fits_is_well(tmp_path, spacing):
    verdict, text = doctor(tmp_path, audio={"preset": "respeaker-usb"}, array=spacing)
    assert verdict is Verdict.OK
    assert "channels 1 and 2 of 'respeaker-usb', 4" in text
