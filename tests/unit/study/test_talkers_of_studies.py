"""Which talkers of a folder the studies with a fixed cast take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import soundfile
from click.testing import CliRunner

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples
from ross_sim.study import above_study, live_separation, noise_study
from ross_sim.study.above_study import AboveDesign, conduct_above
from ross_sim.study.noise_study import Design, conduct_noise
from ross_sim.study.runs.talker_placement import standard_voices
from ross_sim.study.scenes.mixtures import RATE, VOICES


def folder_of(folder: Path, names: Sequence[str]) -> Path:
    """Write six seconds of noise for every name."""
    folder.mkdir(exist_ok=True)
    for number, name in enumerate(names):
        noise = 0.1 * np.random.default_rng(number).standard_normal(6 * RATE)
        soundfile.write(folder / f"{name}.wav", noise, RATE)
    return folder


def test_the_standard_talkers_are_taken_where_all_are_there_and_else_everybody(tmp_path: Path) -> None:
    every = standard_voices(folder_of(tmp_path / "all", ["anna", *VOICES]), RATE, 3)
    some = standard_voices(folder_of(tmp_path / "some", ["anna", "ben", *VOICES[:2]]), RATE, 3)
    assert [voice.name for voice in every] == list(VOICES)
    assert [voice.name for voice in some] == sorted(["anna", "ben", *VOICES[:2]])


def heard_by(monkeypatch: pytest.MonkeyPatch, study: object) -> list[int]:
    """How many voices a study is given; it measures nothing."""
    counts: list[int] = []

    def counted(design: object, voices: Sequence[Samples], *rest: object) -> list[object]:
        counts.append(len(voices))
        return []

    monkeypatch.setattr(study, "rows", counted)
    return counts


def above(out: Path, speech: Path) -> int:
    design = AboveDesign((10.0,), (0.0,), (0.0,), 1, 0, 0.5, "gaussian", 1)
    return conduct_above(design, out=out / "rows.csv", speech=speech, noise=None)


def noise(out: Path, speech: Path) -> int:
    return conduct_noise(Design(("synthetic",), (0.0,), 1, (1,)), out=out, speech=speech, noise=None)


@pytest.mark.parametrize(("study", "conduct"), [(above_study, above), (noise_study, noise)])
def test_a_folder_with_one_standard_talker_gives_all_that_it_has(
    study: object, conduct: Callable[[Path, Path], int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts, out = heard_by(monkeypatch, study), tmp_path / "out"
    out.mkdir()
    assert conduct(out, folder_of(tmp_path / "speech", ["anna", "ben", "cleo", VOICES[0]])) == 0
    assert counts == [4]


@pytest.mark.parametrize("conduct", [above, noise])
def test_fewer_than_three_talkers_are_refused_before_anything_is_written(
    conduct: Callable[[Path, Path], int], tmp_path: Path
) -> None:
    speech, out = folder_of(tmp_path / "speech", ["anna", VOICES[0]]), tmp_path / "out"
    with pytest.raises(ConfigError, match="expected 3 talkers or more, got 2: anna, ls3005"):
        conduct(out, speech)
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--k", "4"], "expected 4 talkers or more, got 3"),
        (["--k", "3"], "talker 'anna': expected at least 13 s of speech, got 2.0 s"),
        (["--k", "6"], "expected whole numbers from 2 to 5 separated by commas, got '6'"),
        (["--k", "1"], "expected whole numbers from 2 to 5 separated by commas, got '1'"),
        (["--k", "2,3", "--targets", "3"], "--targets: expected at most 2"),
    ],
)
def test_live_separation_says_how_many_talkers_it_needs(options: list[str], said: str, tmp_path: Path) -> None:
    speech, out = folder_of(tmp_path / "speech", ["anna", "ben", VOICES[0]]), tmp_path / "rows.csv"
    done = CliRunner().invoke(live_separation.main, [str(out), "--speech", str(speech), *options])
    (line,) = [line for line in done.output.splitlines() if line.startswith("Error: ")]
    assert said in line
    assert done.exit_code == 2
    assert not out.exists()
