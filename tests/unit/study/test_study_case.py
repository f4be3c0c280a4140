"""A task of a study is a pure function, and its numbers are those of the theory."""

import os
import pickle
from dataclasses import replace

import numpy as np
import pytest

from ross_payload import plugins
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Observation
from ross_payload.separation.refiner_features import trained_for
from ross_payload.service.assemble import tools_of
from ross_sim.study.rows.result_rows import ALIGNED, ESTIMATED, UNALIGNED
from ross_sim.study.runs.study_case import Failure, attempt, owners_of, perform
from ross_sim.study.runs.study_design import PRESETS, Task, chosen, mixed, tasks
from ross_sim.study.runs.talker_placement import Source, check_voices, heard_as, placed, voices_of
from ross_sim.study.scenes.exploration import render
from ross_sim.study.scenes.mixtures import record
from ross_sim.study.scenes.room_settings import SETTINGS
from voice_folders import voice_folder

pytestmark = pytest.mark.lockstep

TINY = {
    "settings": ("S1",), "k": (2,), "layouts": 0, "separators": ("gaussian", "tvmwf"), "rotations": (2, 4, "stop"),
    "unit_s": (0.5,), "run_s": 2.0, "rate_hz": 16000, "max_rotations": 6,
}  # fmt: skip
EXPLORED = Task("S1", 2, 0, start=0, explorer="joint", unit=0.5)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return Source(voice_folder(tmp_path_factory.mktemp("voices"), (0, 1, 3), 20), (), 16000)


def study(**changes):
    return chosen("quick", TINY | changes, False)


@pytest.fixture(scope="module")
def explored(source):
    """The rows of the task that explores."""
    return perform(EXPLORED, study(), source)


@pytest.mark.soak
def test_a_task_gives_the_same_rows_every_time(source):
    task, asked = replace(EXPLORED, unit=0.5), {"rotations": (2,), "unit_s": (0.5,), "run_s": 1.0}
    once, again = (perform(task, study(**asked), source) for _ in range(2))
    other = perform(task, study(**asked, seed=1, separators=()), source)
    assert again.separations == once.separations
    assert again.explorations == once.explorations
    assert other.explorations != once.explorations


@pytest.mark.soak
def test_two_voices_in_the_open_are_found_and_separated(explored):
    last = explored.explorations[-1]
    assert last.k_estimated == 2
    assert last.right
    assert max(last.errors_deg) < 3
    for row in explored.separations:
        assert row.all_found
        assert not row.missed
        assert row.si_sdri_db > 10  # two talkers at 15 dB: 14 to 18 dB of noise and interference can go
        assert row.si_sdri_db == pytest.approx(row.si_sdr_out_db - row.si_sdr_in_db, abs=1e-5)


@pytest.mark.soak
def test_an_explorer_that_is_told_k_finds_so_many(source):
    asked = study(k=(3,), tell_k=True, separators=(), unit_s=(0.5,), rotations=(3,))
    told = perform(replace(EXPLORED, k=3, unit=0.5), asked, source).explorations
    assert told[-1].k_estimated == 3


def test_every_target_schedule_and_separator_has_a_row(explored):
    found = {(row.target, row.schedule, row.separator) for row in explored.separations}
    assert found == {(target, schedule, "gaussian") for target in (0, 1) for schedule in ("2", "4", "stop")}
    assert len(explored.separations) == len(found)
    assert {row.how for row in explored.separations} == {ESTIMATED}
    assert [row.rotations for row in explored.explorations] == list(range(7))


def test_known_azimuths_give_a_row_per_separator_and_the_oracle_is_better(source):
    rows = perform(Task("S1", 2, 0, target=1), study(), source).separations
    gains = {row.separator: row.si_sdri_db for row in rows}
    assert {(row.how, row.target) for row in rows} == {(ALIGNED, 1)}
    assert gains["tvmwf"] > gains["gaussian"] > 10
    everywhere = perform(Task("S1", 2, 0, start=0), study(), source).separations
    assert {(row.how, row.target, row.start_heading_deg) for row in everywhere} == {(UNALIGNED, n, 0.0) for n in (0, 1)}


def test_unknown_noise_is_asked_of_those_alone_who_look_at_it(source):
    asked = study(separators=("duet", "mvdr", "irm"), noise=("known", "unknown"))
    rows = perform(Task("S1", 2, 0, target=0), asked, source).separations
    found = [(row.separator, row.noise) for row in rows]
    assert found == [("duet", "known"), ("duet", "unknown"), ("mvdr", "known"), ("irm", "known")]


def test_a_talker_is_found_within_ten_degrees_only():
    def at(degrees):
        return SourceEstimate(np.deg2rad(degrees), 0.01, 1.0, True)

    azimuths = np.deg2rad([10.0, -175.0, 90.0])
    assert owners_of(azimuths, Estimate((at(176), at(0.5), at(105)))) == [1, 0, None]
    assert owners_of(azimuths, Estimate(())) == [None, None, None]


class Deaf:
    name = "deaf"

    def make(self, spacing, speed_of_sound):
        return self

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return Observation(0.0, np.zeros(1), np.ones(1), 1.0)

    def estimate(self, observations):
        return Estimate(())


def test_a_missed_target_counts_as_no_gain(source, monkeypatch):
    load = plugins.load
    monkeypatch.setattr(plugins, "load", lambda group, name: Deaf() if name == "deaf" else load(group, name))
    rows = perform(replace(EXPLORED, explorer="deaf"), study(), source).separations
    assert {(row.si_sdri_db, row.missed, row.all_found, row.k_estimated) for row in rows} == {(0.0, True, False, 0)}
    assert len(rows) == 2 * 3


def test_what_goes_wrong_in_one_task_is_told_and_not_raised(source):
    found = attempt(replace(EXPLORED, setting="S9"), study(), source)
    assert isinstance(found, Failure)
    assert "S9" in found.reason


def test_what_is_explored_with_is_not_what_is_separated(source):
    here = placed(study(), source, EXPLORED)
    for clip, speech, name in zip(here.clips, here.speech, here.names, strict=True):
        (whole,) = (voice.speech for voice in voices_of(source) if voice.name == name)
        np.testing.assert_array_equal(np.concatenate([clip, speech]), whole)
        assert clip.size == 2 * 16000


def test_every_room_has_the_same_layouts_and_talkers(source):
    dry, wet = (placed(study(), source, Task(setting, 3, 2)) for setting in ("S1", "S3"))
    np.testing.assert_array_equal(dry.azimuths, wet.azimuths)
    assert dry.names == wet.names


def test_a_study_that_no_memory_holds_is_refused():
    assert len(tasks(study(layouts=20_000))) == 20_001 * (2 + 3 + 3)
    with pytest.raises(ConfigError, match="expected a study of at most 200000 tasks, got 800000008: fewer layouts"):
        study(layouts=100_000_000)


def test_too_few_or_too_short_voices_are_refused(source):
    voices = voices_of(source)
    with pytest.raises(ConfigError, match="expected 4 talkers for K = 4, got 3"):
        check_voices(voices, study(k=(2, 4)))
    with pytest.raises(ConfigError, match="expected at least 65 s of speech"):
        check_voices(voices, study(run_s=60.0))
    with pytest.raises(ConfigError, match="talker 'zoe' is unknown; there are"):
        voices_of(replace(source, talkers=("zoe",)))


def silenced(voices, part):
    """The voices, of which the second says nothing in a part of its recording."""
    speech = voices[1].speech.copy()
    speech[part] = 0
    return voices[0], replace(voices[1], speech=speech), *voices[2:]


def test_a_talker_who_is_silent_where_he_is_heard_is_named(source):
    voices, cut = voices_of(source), 2 * 16000
    name = voices[1].name
    first, rest = silenced(voices, slice(0, cut)), silenced(voices, slice(cut, None))
    with pytest.raises(ConfigError, match=f"talker '{name}': silent in the first 2 s"):
        check_voices(first, study())
    with pytest.raises(ConfigError, match=f"talker '{name}': silent after the first 2 s"):
        check_voices(rest, study())
    check_voices(first, study(separators=()))
    check_voices(rest, study(explorers=()))


def test_silence_is_said_to_be_that_of_a_talker_and_not_a_fault_of_a_separator():
    loud, silent = np.ones(16000), np.zeros(16000)
    azimuths = np.array([0.0, 1.0])
    words = "talker 2 of 2: expected speech, got silence in the 1 s in use"
    with pytest.raises(ConfigError, match=words):
        record([loud, silent], azimuths, 0, 0.0, SETTINGS["S1"], rng=np.random.default_rng(0), rate=16000)
    with pytest.raises(ConfigError, match="talker 2 of 2: expected speech, got silence"):
        render([loud, silent], azimuths, SETTINGS["S1"], np.array([0.0]), np.random.default_rng(0), rate=16000)


def test_the_same_voices_are_recognised_elsewhere(source, tmp_path):
    for path in source.folder.iterdir():
        os.link(path, tmp_path / path.name)
    assert heard_as(voices_of(replace(source, folder=tmp_path))) == heard_as(voices_of(source))


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_is_complete_and_its_tasks_have_their_own_names(name):
    made = tasks(chosen(name, {}, False))
    assert len({task.id for task in made}) == len(made)
    assert set(mixed(made)) == set(made)
    assert pickle.loads(pickle.dumps(made[-1])) == made[-1]  # noqa: S301
    small = tasks(chosen(name, {}, True))
    assert 0 < len(small) < len(made) or name == "quick"


@pytest.mark.parametrize("rate", [8000, 16000, 24000, 32000, 44100, 48000])
def test_a_study_separates_in_the_frames_of_a_payload_at_every_rate(rate):
    """In others the rows of `refined` would be those of `gaussian`."""
    payload = tools_of(
        Config.model_validate({"audio": {"rate_hz": max(rate, 16000)}, "actuator": {"kind": "ideal"}}), None
    )
    assert trained_for(study(rate_hz=rate).stft.frequencies)
    assert study(rate_hz=max(rate, 16000)).stft == payload.stft
    assert study(rate_hz=rate, frame=1000).stft.frame == 1000


def test_counts_of_tasks_are_products_of_the_axes():
    asked = study(
        settings=("S1", "S2"), k=(2, 3), layouts=4, starts=3, explorers=("joint", "markov"), unit_s=(1.0, 3.0)
    )
    scenes, starts = 2 * 5, 3
    assert len(tasks(asked)) == scenes * ((2 + 3) + 2 * starts * (1 + 2 * 2))
    assert len(tasks(study(explorers=()))) == 2 + 3
    assert len(tasks(study(separators=()))) == 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"settings": ("S1", "S9")}, "S9"),
        ({"separators": ("fancy",)}, "fancy"),
        ({"explorers": ("fancy",)}, "fancy"),
        ({"separators": (), "explorers": ()}, "neither"),
        ({"k": (6,)}, "expected at most 5"),
        ({"tell_k": True, "explorers": ("joint", "markov")}, "use a known K"),
        ({"paper_layout": False, "layouts": 0}, "layouts: expected at least one"),
        ({"k": (3, 3)}, "twice"),
        ({"rotations": ("sometimes",)}, "sometimes"),
        ({"colour": "red"}, "colour"),
        ({"seed": 2**62}, "seed: expected a number less than 4611686018427387904"),
    ],
)
def test_a_study_that_makes_no_sense_is_refused_in_one_line(changes, words):
    with pytest.raises(ConfigError, match=words) as error:
        study(**changes)
    assert "\n" not in str(error.value)
