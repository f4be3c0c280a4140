"""Scenes in the noise of a vehicle, and the table that is made of them."""

from dataclasses import replace

import click
import numpy as np
import pytest
import soundfile

from ross_payload.errors import ConfigError, OutputError
from ross_sim.study import noise_study
from ross_sim.study.command import command
from ross_sim.study.noise_study import SHORT, Design, conduct_noise, tonal_of
from ross_sim.study.rows.noise_rows import NoiseRow, noises
from ross_sim.study.rows.row_files import read_rows
from ross_sim.study.runs.row_manifest import RECORDED, alone_with, claim
from ross_sim.study.scenes import noise_scenes
from ross_sim.study.scenes.mixtures import RATE
from ross_sim.study.scenes.noise_scenes import HEADINGS, ROTORS, noise_of, recordings, scene

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


DESIGN = Design(("synthetic",), (0.0,), 1, (1,), separator="gaussian")


@pytest.fixture
def speech(tmp_path):
    folder = tmp_path / "speech"
    folder.mkdir()
    for number in range(3):
        soundfile.write(
            folder / f"talker{number}.wav", 0.1 * np.random.default_rng(number).standard_normal(144000), RATE
        )
    return folder


@pytest.fixture
def cases(monkeypatch):
    """Carry out a study of which nothing is computed; the scenes and models that are asked for."""
    asked = []

    def explored(row, made):
        asked.append((row.k, row.model))
        if len(asked) == asked_until[0]:
            raise KeyboardInterrupt
        return replace(row, k_found=row.k, within=row.k)

    asked_until = [0]
    monkeypatch.setattr(noise_study, "scene", lambda *about, **more: None)
    monkeypatch.setattr(noise_study, "separated", lambda row, *_: [replace(row, target=each) for each in range(row.k)])
    monkeypatch.setattr(noise_study, "explored", explored)
    return asked, asked_until


def test_rows_that_are_there_are_not_written_over(tmp_path, speech):
    (tmp_path / "rows.csv").write_text("hours of work")
    with pytest.raises(ConfigError, match="holds rows, but"):
        conduct_noise(DESIGN, out=tmp_path, speech=speech, noise=None)
    assert (tmp_path / "rows.csv").read_text() == "hours of work"


def test_a_study_that_was_stopped_goes_on_and_has_the_rows_of_one_done_at_once(tmp_path, speech, cases):
    asked, until = cases
    assert conduct_noise(DESIGN, out=tmp_path / "whole", speech=speech, noise=None) == 0
    every = list(asked)
    until[0] = len(asked) + 4
    with pytest.raises(KeyboardInterrupt):
        conduct_noise(DESIGN, out=tmp_path / "out", speech=speech, noise=None)
    assert len(read_rows(tmp_path / "out" / "rows.csv", [NoiseRow])[1]) == 2 + 2 + 3  # explored, and every target
    asked.clear()
    assert conduct_noise(DESIGN, out=tmp_path / "out", speech=speech, noise=None) == 0
    assert asked == every[3:]
    for name in ("rows.csv", "table.md"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_rows_of_other_noise_ratios_and_parts_are_added_and_none_is_measured_twice(tmp_path, speech, cases):
    asked, _ = cases
    only = replace(DESIGN, separate=False)
    conduct_noise(only, out=tmp_path / "out", speech=speech, noise=None)
    explored = read_rows(tmp_path / "out" / "rows.csv", [NoiseRow])[1]
    conduct_noise(replace(only, snrs=(*DESIGN.snrs, -5.0), kinds=(*DESIGN.kinds, "wind")), out=tmp_path / "out",
                  speech=speech, noise=None)  # fmt: skip
    assert len(asked) == 4 * len(explored)
    conduct_noise(DESIGN, out=tmp_path / "out", speech=speech, noise=None)
    assert len(asked) == 4 * len(explored)  # what was explored is only separated now
    every = read_rows(tmp_path / "out" / "rows.csv", [NoiseRow])[1]
    assert every[: len(explored)] == explored
    assert len(set(every)) == len(every) == 4 * len(explored) + 2 * (1 + 2 + 3)


def test_rows_of_another_separator_are_refused_and_those_there_stay(tmp_path, speech, cases):
    conduct_noise(DESIGN, out=tmp_path / "out", speech=speech, noise=None)
    before = (tmp_path / "out" / "rows.csv").read_bytes()
    with pytest.raises(ConfigError, match="holds rows of another study"):
        conduct_noise(replace(DESIGN, separator="duet"), out=tmp_path / "out", speech=speech, noise=None)
    assert (tmp_path / "out" / "rows.csv").read_bytes() == before


@pytest.mark.parametrize("study", ["noise", "above", "calibration"])
def test_two_commands_that_add_to_one_file_are_refused_in_one_line(tmp_path, speech, run, study):
    out = tmp_path / "out"
    rows = out / "rows.csv"
    with alone_with(rows):
        refusal = run("study", study, "--out", out if study == "noise" else rows, "--speech", speech)
    told = f"ross: --out {rows}: another command is adding rows to it\n"
    assert refusal == (2, "", told)
    assert not list(out.iterdir())
    with alone_with(rows):  # as after a kill
        pass


def test_what_went_wrong_with_the_rows_is_told_where_the_lock_cannot_be_taken_away(tmp_path):
    rows, lock = tmp_path / "rows.csv", tmp_path / ".rows.csv.lock"
    with pytest.raises(OutputError, match="the disk is read-only"), alone_with(rows):
        lock.unlink()
        lock.mkdir()  # which, as all of a disk that has become read-only, cannot be unlinked
        raise OutputError("the disk is read-only")


def test_recordings_of_noise_may_come_later_but_not_others(tmp_path):
    rows, wanted = tmp_path / "rows.csv", {"voices": "a"}
    claim(rows, wanted, later=(RECORDED,))
    rows.write_text("rows")
    claim(rows, wanted | {RECORDED: "one"}, later=(RECORDED,))
    claim(rows, wanted, later=(RECORDED,))  # of made noise again
    claim(rows, wanted | {RECORDED: "one"}, later=(RECORDED,))
    with pytest.raises(ConfigError, match="holds rows of another study"):
        claim(rows, wanted | {RECORDED: "other"}, later=(RECORDED,))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--separator", "nobody"], "separator 'nobody' is unknown"),
        (["--snr", "nan"], "expected finite numbers from -100 to 100 separated by commas, got 'nan'"),
        (["--snr", "1e308"], "expected finite numbers from -100 to 100 separated by commas, got '1e308'"),
        (["--snr", ""], "expected finite numbers from -100 to 100 separated by commas, got none"),
        (["--seed", "-1"], "expected whole numbers of at least 0 separated by commas, got '-1'"),
        (["--seed", f"-{'9' * 401}"], "expected whole numbers of at least 0 separated by commas"),
        (["--seed", "1,2,1"], "expected every value once, got '1' more than once"),
        (["--kinds", "recorded"], "--kinds: expected --noise DIR with recorded, got none"),
        (["--kinds", ""], "expected names separated by commas, got none"),
        (["--kinds", "wind,storm"], "noise 'storm' is unknown"),
        (["--models", ""], "expected names separated by commas, got none"),
    ],
)
def test_bad_input_is_told_before_there_is_a_folder(tmp_path, speech, options, said):
    arguments = ["noise", "--out", str(tmp_path / "out"), "--speech", str(speech), *options]
    with pytest.raises((ConfigError, click.UsageError)) as refused:
        command.main(arguments, standalone_mode=False)
    words = refused.value.format_message() if isinstance(refused.value, click.UsageError) else str(refused.value)
    assert said in words
    assert "\n" not in words
    assert not (tmp_path / "out").exists()


def test_speeds_are_known_of_rotors_that_are_made_alone():
    rng = np.random.default_rng(1)
    made, blown = noise_of("drifting", 1.0, (), rng), noise_of("wind", 1.0, (), rng)
    tonal = tonal_of(made, SHORT, 0, RATE)
    first = SHORT.frequencies[tonal[:, 40]][0]
    assert first == pytest.approx(2 * made.speeds[:, RATE // 2].mean(), abs=2 * SHORT.frequencies[1])
    assert tonal_of(blown, SHORT, 0, RATE) is None
    assert noise_of("recorded", 1.0, [np.ones(RATE, np.float32)], rng).speeds is None
