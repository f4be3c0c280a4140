"""Scenes below a vehicle, on a truth that geometry gives, and the rows and the table of their study."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest
import soundfile

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real, Samples
from ross_sim.study.above_study import AboveDesign, conduct_above, rows
from ross_sim.study.command import command
from ross_sim.study.page_tables import tables_of
from ross_sim.study.rows.above_rows import AboveRow, above
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.runs.row_manifest import manifest_of
from ross_sim.study.scenes import above_scenes
from ross_sim.study.scenes.above_scenes import PIECE_S, STROLL_M, Walks, among, images_of, responses, walks_of
from ross_sim.study.scenes.mixtures import LEAD_IN, RATE
from ross_sim.study.scenes.noise_scenes import noise_of
from ross_sim.study.scenes.room_settings import SPACING, SPEED_OF_SOUND

VOICES = [np.random.default_rng(n).standard_normal(4 * RATE).astype(np.float32) for n in range(3)]


def level(samples: Real | Samples) -> float:
    return float(10 * np.log10(np.mean(np.square(samples, dtype=float))))


def test_a_delay_is_that_of_the_elevation() -> None:
    """3 m along the ground and 4 m below: the cosine of the elevation is 0.6."""
    place, heading = np.array([[3.0, 0.0, -4.0]]), 0.4
    spectra = np.fft.rfft(responses(place, heading, 0.0)[:, 0], 4096)
    omega = 2 * np.pi * np.fft.rfftfreq(4096, 1 / RATE)[50:800]
    delays = np.angle(spectra[1] * spectra[0].conj())[50:800] / omega
    assert np.median(delays) == pytest.approx(SPACING / SPEED_OF_SOUND * 0.6 * math.cos(heading), abs=1e-6)


def test_the_ground_adds_a_softer_sound_that_comes_later() -> None:
    place = np.array([[0.0, 0.0, -10.0]])
    bare, reflecting = (responses(place, 0.0, ground)[0, 0] for ground in (0.0, 0.5))
    later = reflecting - bare
    delay = int(np.abs(later).argmax()) - int(np.abs(bare).argmax())
    assert delay == pytest.approx(2 * 1.6 / SPEED_OF_SOUND * RATE, abs=1)
    assert np.abs(later).max() / np.abs(bare).max() == pytest.approx(0.5 * 10 / 13.2, rel=0.02)


def test_who_walks_goes_to_and_fro_at_that_speed_and_the_others_stay() -> None:
    walks = walks_of(3, 10.0, 1.0, np.random.default_rng(1))
    turning = 2 * STROLL_M  # there and back again, at 1 m/s
    np.testing.assert_allclose(walks.at(0.0), walks.at(turning), atol=1e-9)
    step = np.linalg.norm(walks.at(0.02) - walks.at(0.01), axis=1)
    np.testing.assert_allclose(step, 0.01, rtol=1e-6)
    standing = Walks(walks.places, walks.towards, walks.phases, 10.0, 0.0)
    np.testing.assert_array_equal(standing.at(0.0), standing.at(7.3))


def test_a_walk_that_hardly_moves_sounds_as_standing_does() -> None:
    """The pieces of which a walk is made add up to the whole."""
    voice = [VOICES[0][:RATE].astype(float)]
    still = Walks(np.array([[4.0, 2.0]]), np.array([[1.0, 0.0]]), np.array([0.25]), 10.0, 0.0)
    slow = Walks(still.places, still.towards, still.phases, 10.0, 1e-6)
    one, other = (images_of(voice, each, 0.3, 0.5) for each in (still, slow))
    settled = round(2 * PIECE_S * RATE)
    assert np.abs(one - other)[..., settled:].max() < 1e-3 * np.abs(one).max()


def test_the_ratio_is_that_of_all_talkers_to_the_rotors() -> None:
    noise = noise_of("synthetic", LEAD_IN + 1.0, (), np.random.default_rng(1))
    talk = np.random.default_rng(2).standard_normal((1, 2, RATE))
    loud, noisy = among(noise, talk, [0.0], -10.0, np.random.default_rng(3))
    quiet, calm = among(noise, talk, [0.0], None, np.random.default_rng(3))
    assert level(noisy[:, 0]) - level(talk[:, 0]) == pytest.approx(10 * math.log10(11), abs=0.5)
    assert level(loud[0]) - level(talk[:, 0]) == pytest.approx(10, abs=1.0)
    assert level(quiet) - level(talk) == pytest.approx(-25, abs=0.5)  # microphones alone
    assert level(calm) == pytest.approx(level(talk), abs=0.1)


def test_the_higher_the_steeper() -> None:
    low, high = (walks_of(3, height, 0.0, np.random.default_rng(1)) for height in (5.0, 20.0))
    np.testing.assert_array_equal(low.azimuths(0.0), high.azimuths(0.0))
    away = np.linalg.norm(high.places, axis=1)
    assert np.all((away >= 3) & (away <= 8))
    np.testing.assert_allclose(np.tan(-low.elevations(0.0)), 5.0 / away)
    np.testing.assert_allclose(np.tan(-high.elevations(0.0)), 20.0 / away)


def row(**changes: object) -> AboveRow:
    about = {"height_m": 10.0, "walk_m_s": 0.0, "ratio_db": 0.0, "rotors": "recorded", "ground": 0.5, "k": 2}
    return AboveRow(**{**about, "layout": 0, "seed": 1, "told": True, **changes})  # type: ignore[arg-type]


EXPLORED = [
    row(k_found=2, within=2, azimuth_errors_deg=(1.0, 3.0), elevation_errors_deg=(2.0, 4.0)),
    row(layout=1, k_found=3, within=2, azimuth_errors_deg=(2.0, 2.0), elevation_errors_deg=(6.0, 6.0)),
    row(told=False, k_found=1, within=1, azimuth_errors_deg=(9.0,), elevation_errors_deg=(50.0,)),
    row(target=0, si_sdr_in_db=-4.0, si_sdr_out_db=8.0),
    row(k=1, target=0, si_sdr_in_db=2.0, si_sdr_out_db=11.0),
]


def test_the_table_keeps_apart_who_is_told_the_height_and_who_is_not() -> None:
    ((name, right, found, azimuth, elevation, untold, before, after, alone),) = above(EXPLORED).rows
    assert name == "10 m, all stand, 0 dB"
    assert (right.split()[0], found.split()[0], untold.split()[0]) == ("1/2", "4/4", "0/1")
    assert (azimuth, elevation) == ("2.0", "5.0")
    assert [cell.split()[0] for cell in (before, after, alone)] == ["-4.0", "8.0", "11.0"]


def test_rows_come_back_from_their_file_and_make_the_same_table(tmp_path: Path) -> None:
    path = tmp_path / "from-above.csv"
    path.write_bytes(as_csv([*EXPLORED, row(ratio_db=None, walk_m_s=0.5, k_found=2, within=2)], AboveRow))
    assert read_rows(path, [AboveRow])[1][:-1] == EXPLORED
    assert "all walk at 0.5 m/s, rotors off" in tables_of(path)["above"]


def test_what_is_measured_already_is_not_measured_again(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[tuple[object, ...]] = []

    def counted(*about: object, **more: object) -> above_scenes.AboveScene:
        made.append(about)
        raise StopIteration

    monkeypatch.setattr("ross_sim.study.above_study.scene", counted)
    design = AboveDesign((10.0,), (0.0,), (0.0,), 1, 0, 0.5, "gaussian", 1)
    done = [row(k=k, rotors="synthetic") for k in (1, 2)]
    with pytest.raises(RuntimeError):
        list(rows(design, VOICES, (), done))
    assert [about[0] for about in made] == [3]
    assert list(rows(design, VOICES, (), [*done, row(k=3, rotors="synthetic")])) == []


def test_what_another_separator_has_measured_is_measured_again(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[object] = []

    def counted(*about: object, **more: object) -> above_scenes.AboveScene:
        made.append(about[0])
        raise StopIteration

    monkeypatch.setattr("ross_sim.study.above_study.scene", counted)
    told = [row(k=k, rotors="synthetic") for k in (1, 2, 3)]
    done = [*told, *(replace(each, target=each.k - 1, separator="gaussian") for each in told)]
    design = AboveDesign((10.0,), (0.0,), (0.0,), 1, 1, 0.5, "gaussian", 1)
    assert list(rows(design, VOICES, (), done)) == []
    with pytest.raises(RuntimeError):
        list(rows(replace(design, separator="mvdr"), VOICES, (), done))
    assert made == [1]


def test_rows_of_other_settings_are_never_averaged() -> None:
    other = [replace(each, ground=0.9, within=0, si_sdr_out_db=-9.0) for each in EXPLORED]
    parts = [replace(EXPLORED[3], separator=name, si_sdr_out_db=out) for name, out in (("duet", 1.0), ("mvdr", 5.0))]
    both = {line[0]: line[1:] for line in above([*EXPLORED, *other]).rows}
    assert both["10 m, all stand, 0 dB, ground 0.5"] == above(EXPLORED).rows[0][1:]
    assert both["10 m, all stand, 0 dB, ground 0.9"] == above(other).rows[0][1:]
    (first, second) = above([*EXPLORED[:3], *parts]).rows
    assert (first[0], second[0]) == ("10 m, all stand, 0 dB, duet", "10 m, all stand, 0 dB, mvdr")
    assert (first[7], second[7]) == ("1.0", "5.0")
    assert first[1:6] == second[1:6]


DESIGN = AboveDesign((10.0,), (0.0,), (0.0,), 1, 0, 0.5, "gaussian", 1)


@pytest.fixture
def measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[AboveRow]]:
    """Carry out a study of which nothing is computed, with talkers of noise; what the file holds then."""

    def rows_of(design: AboveDesign, voices: object, clips: object, done: Sequence[AboveRow]) -> list[list[AboveRow]]:
        wanted = [row(k=k, height_m=height, rotors="synthetic") for height in design.heights for k in (1, 2, 3)]
        return [[each] for each in wanted if each not in done]

    monkeypatch.setattr("ross_sim.study.above_study.rows", rows_of)

    def conducted(design: AboveDesign = DESIGN, *, loud: float = 0.1) -> list[AboveRow]:
        speech = tmp_path / "speech"
        speech.mkdir(exist_ok=True)
        for number in range(3):
            noise = loud * np.random.default_rng(number).standard_normal(6 * RATE)
            soundfile.write(speech / f"talker{number}.wav", noise, RATE)
        assert conduct_above(design, out=tmp_path / "rows.csv", speech=speech, noise=None) == 0
        return list(read_rows(tmp_path / "rows.csv", [AboveRow])[1])

    return conducted


def test_another_height_joins_the_rows_of_the_same_study(measured: Callable[..., list[AboveRow]]) -> None:
    first = measured()
    both = measured(replace(DESIGN, heights=(10.0, 20.0)))
    assert both[:3] == first
    assert [each.height_m for each in both] == [10.0] * 3 + [20.0] * 3


@pytest.mark.parametrize(
    ("changes", "loud", "said"),
    [
        ({"ground": 0.9}, 0.1, r"\(ground is 0.5, not 0.9\); choose another"),
        ({"seed": 2}, 0.1, r"\(seed is 1, not 2\)"),
        ({"separator": "duet"}, 0.1, r"\(separator is gaussian, not duet\)"),
        ({}, 0.2, r"\(talker0 is \w+, not \w+\)"),
    ],
)
def test_rows_of_other_voices_or_settings_are_refused_and_left_alone(
    changes: dict[str, object], loud: float, said: str, measured: Callable[..., list[AboveRow]], tmp_path: Path
) -> None:
    measured()
    before = (tmp_path / "rows.csv").read_bytes()
    with pytest.raises(ConfigError, match=said) as refused:
        measured(replace(DESIGN, **changes), loud=loud)  # type: ignore[arg-type]
    assert "\n" not in str(refused.value)
    assert (tmp_path / "rows.csv").read_bytes() == before


def test_rows_of_which_nobody_knows_the_voices_are_refused(
    measured: Callable[..., list[AboveRow]], tmp_path: Path
) -> None:
    measured()
    manifest_of(tmp_path / "rows.csv").unlink()
    with pytest.raises(ConfigError, match="beside it cannot be read; choose another"):
        measured()


def test_fewer_than_three_talkers_are_refused_in_one_line(tmp_path: Path) -> None:
    design = AboveDesign((10.0,), (0.0,), (0.0,), 1, 0, 0.5, "gaussian", 1)
    with pytest.raises(ConfigError) as refused:
        conduct_above(design, out=tmp_path / "rows.csv", speech=tmp_path, noise=None)
    assert "\n" not in str(refused.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--ratios", "nan"], "expected numbers from -100 to 100, or off, separated by commas, got 'nan'"),
        (["--ratios", "foo"], "expected numbers from -100 to 100, or off, separated by commas, got 'foo'"),
        (["--ratios", "off,off"], "expected every value once, got 'off' more than once"),
        (["--ground", "nan"], "expected a finite number, got nan"),
        (["--heights", "inf"], "expected finite numbers separated by commas, got 'inf'"),
        (["--walks", ""], "expected finite numbers separated by commas, got none"),
    ],
)
def test_odd_values_of_options_are_told_in_one_line(options: list[str], said: str, tmp_path: Path) -> None:
    arguments = ["above", "--out", str(tmp_path / "rows.csv"), "--speech", str(tmp_path), *options]
    with pytest.raises(click.UsageError) as refused:
        command.main(arguments, standalone_mode=False)
    assert said in refused.value.format_message()
    assert not list(tmp_path.iterdir())


def test_a_schedule_that_is_none_is_told_without_a_private_name(tmp_path: Path) -> None:
    with pytest.raises(click.UsageError, match="expected whole numbers or stop separated by commas, got 'foo'"):
        command.main(["--out", str(tmp_path / "out"), "--rotations", "foo"], standalone_mode=False)
