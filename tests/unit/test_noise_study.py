"""Scenes in the noise of a vehicle, and the table that is made of them."""

import numpy as np
import pytest
import soundfile

from ross_payload.errors import ConfigError
from ross_sim.study import noise_scenes
from ross_sim.study.mixtures import RATE
from ross_sim.study.noise_rows import NoiseRow, noises
from ross_sim.study.noise_scenes import HEADINGS, ROTORS, noise_of, recordings, scene
from ross_sim.study.noise_study import SHORT, Design, conduct_noise, tonal_of

VOICES = [np.random.default_rng(n).standard_normal(4 * RATE).astype(np.float32) for n in range(3)]


def level(samples):
    return 10 * np.log10(np.mean(np.square(samples, dtype=float)))


@pytest.mark.soak
def test_talkers_and_noise_have_the_ratio_that_is_asked_for(monkeypatch):
    monkeypatch.setattr(noise_scenes, "HEADINGS", HEADINGS[:3])
    made = scene(2, -10.0, "synthetic", VOICES, key=[1, 2])
    assert made.heard.shape == (3, 2, 3 * RATE)
    assert level(made.lead_in) - level(made.heard[:, 0]) == pytest.approx(-10 * np.log10(1 + 0.1), abs=1.0)
    assert level(made.heard) == pytest.approx(20 * np.log10(0.05), abs=0.1)  # one level for the converter


def test_the_same_seed_makes_the_same_noise_and_another_one_another():
    first, again, other = (noise_of("drifting", 1.0, (), np.random.default_rng(seed)).sounds for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_noise_goes_on_without_a_seam():
    noise = noise_of("synthetic", 1.0, (), np.random.default_rng(1))
    whole, rest = noise.at(0.3, 0, RATE), noise.at(0.3, RATE // 2, RATE)
    assert np.allclose(whole[:, RATE // 2 :], rest, atol=1e-5)


def test_one_rotor_is_heard_from_its_place():
    noise = noise_of("synthetic", 1.0, (), np.random.default_rng(1))
    noise.sounds[1:] = 0
    for heading in (0.0, 1.1):
        first, second = np.fft.rfft(noise.at(heading, 0, RATE))
        band = slice(500, 3000)  # [Hz]: one second has bins of 1 Hz
        omega, cross = 2 * np.pi * np.arange(RATE // 2 + 1)[band], (second * first.conj())[band]
        measured = (np.abs(cross) * omega * np.angle(cross)).sum() / (np.abs(cross) * omega**2).sum()
        assert measured == pytest.approx(ROTORS.delays(heading)[0], abs=1e-6)


def test_wind_is_the_same_whatever_the_heading():
    noise = noise_of("wind", 1.0, (), np.random.default_rng(1))
    assert np.array_equal(noise.at(0.0, 0, RATE), noise.at(1.0, 0, RATE))


def test_propellers_of_a_folder_are_read_and_bare_motors_are_not(tmp_path):
    with pytest.raises(ConfigError, match="expected recordings with 'prop' in their names, got none"):
        recordings(tmp_path)
    for name, size in (("m1_prop", 800), ("m1_no_prop", 1600)):
        soundfile.write(tmp_path / f"{name}.wav", np.sin(np.arange(size)), RATE)
    assert [clip.size for clip in recordings(tmp_path)] == [800]


def test_all_right_means_k_and_everybody_near():
    one = NoiseRow("synthetic", "learnt", 0.0, 2, 0, 1, k_found=2, within=2)
    assert one.right
    assert not NoiseRow("synthetic", "learnt", 0.0, 2, 0, 1, k_found=3, within=2).right
    assert not NoiseRow("synthetic", "learnt", 0.0, 2, 0, 1, k_found=2, within=1).right


def test_the_table_keeps_lone_talkers_apart():
    found = [
        NoiseRow("synthetic", "learnt", 0.0, 2, 0, 1, k_found=2, within=2),
        NoiseRow("synthetic", "learnt", 0.0, 1, 0, 1, k_found=2, within=1),
        NoiseRow("synthetic", "learnt", 0.0, 2, 0, 1, target=0, si_sdr_in_db=-6.0, si_sdr_out_db=5.0),
        NoiseRow("synthetic", "learnt", 0.0, 2, 0, 1, target=1, si_sdr_in_db=-4.0, si_sdr_out_db=7.0),
        NoiseRow("synthetic", "learnt", 0.0, 1, 0, 1, target=0, si_sdr_in_db=0.0, si_sdr_out_db=9.0),
    ]
    last = noises(found).body().splitlines()[-1]
    assert last == (
        "| synthetic | learnt | 0 dB | 1/2 (9-91 %) | 3/3 (44-100 %) | -5.0 ± 12.7 | 6.0 ± 12.7 | 0.0 | 9.0 |"
    )


def test_rows_that_are_there_are_not_written_over(tmp_path):
    (tmp_path / "rows.csv").write_text("hours of work")
    design = Design(("synthetic",), (0.0,), 1, (1,))
    with pytest.raises(ConfigError, match="holds the rows of a study already"):
        conduct_noise(design, out=tmp_path, speech=tmp_path, noise=None)
    assert (tmp_path / "rows.csv").read_text() == "hours of work"


def test_speeds_are_known_of_rotors_that_are_made_alone():
    rng = np.random.default_rng(1)
    made, blown = noise_of("drifting", 1.0, (), rng), noise_of("wind", 1.0, (), rng)
    tonal = tonal_of(made, SHORT, 0, RATE)
    first = SHORT.frequencies[tonal[:, 40]][0]
    assert first == pytest.approx(2 * made.speeds[:, RATE // 2].mean(), abs=2 * SHORT.frequencies[1])
    assert tonal_of(blown, SHORT, 0, RATE) is None
    assert noise_of("recorded", 1.0, [np.ones(RATE, np.float32)], rng).speeds is None
