"""The public benchmark: its list, the recordings it asks for, the audio it builds, and how estimates are scored."""

import csv
import errno
import json
import os
import runpy
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import soundfile
from click.testing import CliRunner

from command_line import called, called_once
from manual import block
from ross_payload.dsp.metrics import si_sdr
from ross_payload.errors import ConfigError, OutputError
from ross_sim.study.benchmark import scene_list, score_estimates
from ross_sim.study.benchmark.benchmark_rows import BenchmarkLocalization, BenchmarkSeparation
from ross_sim.study.benchmark.build_audio import write_wav
from ross_sim.study.benchmark.recordings import RATE, Recording, described, found, sha256
from ross_sim.study.benchmark.scene_list import FILES, ROOMS, RoomLine, drawn, read_list, write_list
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.runs.row_manifest import held
from ross_sim.talkers.synthetic_voices import synthetic_voice

TALKERS = Path(os.environ.get("ROSS_TALKERS", Path(__file__).parents[4] / "shared" / "talkers"))
PAGE = "docs/how-to/enter-your-method.md"
K3 = ("S1-k3-00-aligned", "S1-k3-00-random")
TURN = "S1-k3-00-turning"
VOICE = f"{K3[0]}.wav"


@pytest.fixture(scope="module")
def lists(tmp_path_factory):
    """A list of three scenes, and the three synthetic voices that speak in it, laid out as LibriSpeech is."""
    folder, of_the_corpus = (
        tmp_path_factory.mktemp("list"),
        {"corpus": "LibriSpeech", "subset": "tiny", "licence": "CC0"},
    )
    recordings = []
    for index in range(3):
        samples = np.round(32767 * synthetic_voice(index, RATE).speech[: 11 * RATE]).astype(np.int64) + index
        utterance = f"{index + 7}-1-0000"
        recordings.append(described(utterance, samples, sex="F", **of_the_corpus))
        path = folder / "speech" / "LibriSpeech" / "tiny" / str(index + 7) / "1" / f"{utterance}.flac"
        path.parent.mkdir(parents=True)
        soundfile.write(path, samples.astype(np.int16), RATE)
    (folder / FILES[2]).write_bytes(as_csv(recordings, Recording))
    write_list(folder, (RoomLine("S1", 1, 1),))
    return folder


@pytest.fixture(scope="module")
def audio(lists, tmp_path_factory):
    """The audio of the three scenes."""
    folder = tmp_path_factory.mktemp("built") / "audio"
    code, _, errors = called_once("study", "benchmark", "build", "--list", lists, *of(lists / "speech", folder))
    assert (code, errors) == (0, "")
    return folder


def of(recordings, out):
    return "--recordings", recordings, "--out", out


@pytest.fixture
def ross(monkeypatch, capsys):
    """``ross study benchmark`` with more arguments: exit code, output, errors."""
    return partial(called, monkeypatch, capsys, "study", "benchmark")


def scored(ross, audio, estimates, out):
    return ross("score", "--audio", audio, "--estimates", estimates, "--out", out)


def rows_of(path, kind):
    return {row.scene: row for row in read_rows(path, [kind])[1]}


def json_file(path):
    return json.loads(path.read_text(encoding="utf-8"))


def sound(path):
    return soundfile.read(path, always_2d=True)[0].T


# ------------------------------------------------------------------------------------------------ the list


def test_the_list_is_what_its_command_makes():
    shipped = read_list()
    assert shipped.rooms == ROOMS
    assert shipped.layouts == drawn(shipped.recordings)


def test_every_true_room_has_forty_scenes_in_every_row():
    counts = {}
    for scene in read_list().scenes():
        key = scene.room, scene.layout.k, scene.orientation
        counts[key] = counts.get(key, 0) + 1
    assert {key[0] for key in counts} == {"S1", "S2", "S3", "A0.45", "B0.45", "A0.7"}
    assert min(n for (room, _, _), n in counts.items() if not room.startswith("S")) == 40
    assert len(read_list().scenes()) == 1500
    assert len(read_list().scenes(quick=True)) == 34


def test_a_list_that_names_nobody_is_refused(lists, tmp_path, ross):
    for name in FILES:
        shutil.copy(lists / name, tmp_path)
    text = (tmp_path / FILES[1]).read_text()
    (tmp_path / FILES[1]).write_text(text.replace("9-1-0000", "9-1-0001"))
    more = ("--list", tmp_path, *of(lists / "speech", tmp_path / "audio"))
    code, _, errors = ross("build", *more)
    assert (code, errors.count("\n")) == (2, 1)
    assert "utterance '9-1-0001' is unknown" in errors


# ------------------------------------------------------------------------------------------------ the recordings


@pytest.mark.soak
@pytest.mark.skipif(not TALKERS.is_dir(), reason="needs the recordings in ../shared/talkers (or ROSS_TALKERS)")
def test_all_recordings_are_found_by_their_hash_in_copies_with_another_gain():
    recordings = read_list().recordings
    assert {len(samples) for samples in found(TALKERS, recordings).values()} == {each.samples for each in recordings}


@pytest.mark.soak
def test_a_copy_in_a_flat_folder_and_an_amplified_one_of_the_reader_give_the_same_bytes(lists, audio, tmp_path):
    first, second, third = sorted((lists / "speech").rglob("*.flac"))
    speech = tmp_path / "speech"
    (speech / "ls8").mkdir(parents=True)
    samples = soundfile.read(first, dtype="int16")[0]
    soundfile.write(speech / f"{first.stem}.wav", samples, RATE)
    louder = soundfile.read(second, dtype="int16")[0].astype(float)
    soundfile.write(speech / "ls8" / "a.flac", np.round(1.21 * (louder - louder.mean())).astype(np.int16), RATE)
    shutil.copy(third, speech)
    code, _, errors = called_once("study", "benchmark", "build", "--list", lists, *of(speech, tmp_path / "audio"))
    assert (code, errors) == (0, "")
    assert (tmp_path / "audio" / "SHA256SUMS").read_bytes() == (audio / "SHA256SUMS").read_bytes()


def cut(path):
    soundfile.write(path, soundfile.read(path)[0][:-1], RATE)


def changed(path):
    samples = soundfile.read(path, dtype="int16")[0]
    samples[1000] += 1
    soundfile.write(path, samples, RATE)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (Path.unlink, "8-1-0000 of LibriSpeech is missing; it is in tiny.tar.gz at https://www.openslr.org/12"),
        (cut, "8-1-0000 of LibriSpeech is not in LibriSpeech/tiny/8/1/8-1-0000.flac, which has 1 x 175999 samples"),
        (changed, "whose samples have the SHA-256"),
        (lambda path: path.write_text("no sound"), "which cannot be read; it is in tiny.tar.gz"),
    ],
    ids=["missing", "short", "changed", "no audio"],
)
def test_a_recording_that_is_missing_or_differs_is_named_in_one_line(lists, tmp_path, ross, damage, words):
    shutil.copytree(lists / "speech", tmp_path / "speech")
    damage(next((tmp_path / "speech").rglob("8-1-0000.flac")))
    more = ("--list", lists, *of(tmp_path / "speech", tmp_path / "audio"))
    code, _, errors = ross("build", *more)
    assert (code, errors.count("\n")) == (2, 1)
    assert words in errors
    assert not (tmp_path / "audio").exists()


def test_a_hash_does_not_depend_on_a_constant_and_on_nothing_else():
    samples = np.random.default_rng(0).integers(-9000, 9000, 500)
    line = described("1-1-0", samples, corpus="", subset="", licence="", sex="")
    assert replace(line, sha256="") == replace(
        described("1-1-0", samples + 40, corpus="", subset="", licence="", sex=""), sha256=""
    )
    assert line == described("1-1-0", samples + 40, corpus="", subset="", licence="", sex="")
    assert sha256(samples) != sha256(samples[::-1])


# ------------------------------------------------------------------------------------------------ the audio


@pytest.mark.parametrize("scene", K3)
def test_a_mixture_is_the_sum_of_its_references_and_of_noise_15_db_below_it(audio, scene):
    folder, told = audio / scene, json_file(audio / scene / "scene.json")
    references = np.stack([sound(folder / f"reference-{k}.wav")[0] for k in range(3)])
    mixture, noise = sound(folder / "mixture.wav"), sound(folder / "noise.wav")
    assert mixture.shape == (2, 10 * RATE)
    assert noise.shape == (2, told["noise_lead_in_s"] * RATE)
    powers = (references**2).mean(axis=1)
    assert powers == pytest.approx(np.full(3, powers.mean()), rel=1e-3)
    left = mixture[0] - references.sum(axis=0)
    assert 10 * np.log10((references.sum(axis=0) ** 2).mean() / (left**2).mean()) == pytest.approx(15.0, abs=0.1)
    assert noise.std() == pytest.approx(left.std(), rel=0.02)


def test_a_talker_arrives_at_microphone_2_earlier_as_the_page_says(audio):
    folder, told = audio / TURN, json_file(audio / TURN / "scene.json")
    mixture, truth = sound(folder / "mixture.wav"), np.deg2rad(json_file(folder / "truth.json")["azimuths_deg"])
    assert "azimuths_deg" not in told
    parts = np.split(mixture, len(told["headings_deg"]), axis=1)
    assert {part.shape[1] for part in parts} == {told["seconds_each"] * RATE}
    for part, heading in zip(parts, told["headings_deg"], strict=True):
        first, second = np.fft.rfft(part, axis=1)
        lags = np.arange(-3, 4)
        found = np.fft.irfft(second.conj() * first, part.shape[1])[lags]  # positive where microphone 2 leads
        lead = told["spacing_m"] * np.cos(truth - np.deg2rad(heading)) / told["speed_of_sound_m_s"] * RATE
        assert min(abs(lags[found.argmax()] - lead)) < 0.75


def test_a_build_goes_on_and_other_scenes_are_not_mixed_with_it(lists, audio, tmp_path, ross):
    begun = tmp_path / "audio"
    shutil.copytree(audio, begun)
    sums = (begun / "SHA256SUMS").read_bytes()
    (begun / "SHA256SUMS").unlink()
    shutil.rmtree(begun / TURN)
    code, _, errors = ross("run", "--audio", begun, "--method", "duet", "--out", begun)
    assert code == 2
    assert "is not complete" in errors
    arguments = ("--list", lists, *of(lists / "speech", begun))
    assert ross("build", *arguments)[0] == 0
    assert (begun / "SHA256SUMS").read_bytes() == sums
    code, _, errors = ross("build", "--quick", *arguments)
    assert code == 2
    assert "holds other scenes" in errors
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "something").touch()
    arguments = ("--list", lists, *of(lists / "speech", tmp_path / "full"))
    code, _, errors = ross("build", *arguments)
    assert (code, errors.count("\n")) == (2, 1)
    assert "expected an empty folder" in errors


def test_a_scene_that_is_no_longer_as_it_was_built_is_built_anew_and_named(lists, audio, tmp_path, ross):
    begun = tmp_path / "audio"
    shutil.copytree(audio, begun)
    (begun / K3[0] / "truth.json").write_text("")
    (begun / K3[1] / "mixture.wav").unlink()
    (begun / K3[1] / "notes.txt").touch()
    build = ("build", "--list", lists, *of(lists / "speech", begun))
    code, printed, _ = ross(*build)
    told = f"{begun}: 2 scenes were not as they had been built, and were built anew: {K3[0]}, {K3[1]}\n"
    assert (code, told in printed) == (0, True)
    for path in audio.rglob("*"):
        assert path.is_dir() or (begun / path.relative_to(audio)).read_bytes() == path.read_bytes()
    assert (begun / K3[1] / "notes.txt").exists()
    assert "anew" not in ross(*build)[1]


def test_two_builds_in_one_folder_are_refused_in_one_line(lists, audio, tmp_path, ross):
    begun = tmp_path / "audio"
    shutil.copytree(audio, begun)
    with held(begun, waits=False):
        refusal = ross("build", "--list", lists, *of(lists / "speech", begun))
    assert refusal == (2, "", f"ross: {begun}: another command is writing there\n")


# ------------------------------------------------------------------------------------------------ scores


def test_scores_of_other_methods_are_read_and_written_while_nobody_else_writes(audio, tmp_path, ross, monkeypatch):
    rows, read = tmp_path / "rows", []

    def reading(path, kinds):
        with pytest.raises(ConfigError, match="another command is writing there"), held(rows, waits=False):
            pass
        read.append(path)
        return read_rows(path, kinds)

    monkeypatch.setattr(score_estimates, "read_rows", reading)
    for name in ("mine", "yours"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "azimuths.json").write_text(json.dumps({TURN: []}))
        assert scored(ross, audio, tmp_path / name, rows)[0] == 0
    assert read == [rows / "localization.csv"]


@pytest.mark.parametrize("gain", [1e-200, 1e200])
def test_the_gain_of_an_estimate_does_not_matter(audio, tmp_path, ross, gain):
    mixture = sound(audio / K3[0] / "mixture.wav")[0]
    (tmp_path / "mine").mkdir()
    soundfile.write(tmp_path / "mine" / f"{K3[0]}.wav", gain * mixture, RATE, subtype="DOUBLE")
    assert scored(ross, audio, tmp_path / "mine", tmp_path / "rows")[0] == 0
    row = rows_of(tmp_path / "rows" / "separation.csv", BenchmarkSeparation)[K3[0]]
    assert (row.si_sdri_db, row.missing) == (0.0, False)


def test_estimates_are_scored_as_si_sdr_says_and_a_missing_one_is_0_db(audio, tmp_path, ross):
    target = json_file(audio / K3[0] / "scene.json")["target"]
    reference, mixture = sound(audio / K3[0] / f"reference-{target}.wav")[0], sound(audio / K3[0] / "mixture.wav")[0]
    estimate = 0.25 * (reference + 0.1 * mixture)
    (tmp_path / "mine").mkdir()
    soundfile.write(tmp_path / "mine" / f"{K3[0]}.wav", estimate, RATE, subtype="FLOAT")
    code, printed, _ = scored(ross, audio, tmp_path / "mine", tmp_path / "rows")
    rows = rows_of(tmp_path / "rows" / "separation.csv", BenchmarkSeparation)
    assert code == 0
    assert rows[K3[0]].method == "mine"
    assert rows[K3[0]].si_sdri_db == pytest.approx(si_sdr(estimate, reference) - si_sdr(mixture, reference), abs=2e-3)
    assert (rows[K3[1]].si_sdri_db, rows[K3[1]].missing) == (0.0, True)
    assert "No estimate of 1 scenes by mine" in printed
    assert not (tmp_path / "rows" / "localization.csv").exists()


def test_azimuths_are_right_in_any_order_and_wrong_with_one_too_many(audio, tmp_path, ross):
    truth = json_file(audio / TURN / "truth.json")["azimuths_deg"]
    for name, told, right in (
        ("right", [azimuth + 360.0 for azimuth in reversed(truth)], True),
        ("many", [*truth, truth[0] + 180.0], False),
        ("few", truth[1:], False),
        ("off", [truth[0] + 11.0, *truth[1:]], False),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "azimuths.json").write_text(json.dumps({TURN: told}))
        assert scored(ross, audio, tmp_path / name, tmp_path / "rows")[0] == 0
        every = read_rows(tmp_path / "rows" / "localization.csv", [BenchmarkLocalization])[1]
        assert [row.right for row in every if row.method == name] == [right], name
    assert [row.method for row in every] == ["right", "many", "few", "off"]


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ((VOICE, lambda p: soundfile.write(p, np.ones(10), RATE)), "expected 160000 samples of one channel"),
        ((VOICE, lambda p: soundfile.write(p, np.ones((160000, 2)), RATE)), "got 160000 of 2 at 16000 Hz"),
        ((VOICE, lambda p: soundfile.write(p, np.ones(160000), 8000)), "at 16000 Hz, as the mixture has"),
        ((VOICE, lambda p: soundfile.write(p, np.full(160000, np.nan), RATE, subtype="FLOAT")), "finite samples"),
        ((VOICE, lambda p: p.write_text("no sound")), "not a recording that can be read"),
        (("other.wav", lambda p: soundfile.write(p, np.ones(10), RATE)), "expected estimates"),
        (("azimuths.json", lambda p: p.write_text("[1]")), "expected an object, got list"),
        (("azimuths.json", lambda p: p.write_text('{"S1": [1]}')), "that end with '-turning', got 'S1'"),
        (("azimuths.json", lambda p: p.write_text(f'{{"{TURN}": 1}}')), "expected a list of at most 20 azimuths"),
        (("azimuths.json", lambda p: p.write_text(f'{{"{TURN}": ["1"]}}')), "expected a list of at most 20 azimuths"),
        (("azimuths.json", lambda p: p.write_text(f'{{"{TURN}": [{"9" * 401}]}}')), "expected a list of at most 20"),
    ],
)
def test_estimates_that_do_not_fit_are_refused_in_one_line(audio, tmp_path, ross, written, words):
    (tmp_path / "mine").mkdir()
    name, write = written
    write(tmp_path / "mine" / name)
    code, printed, errors = scored(ross, audio, tmp_path / "mine", tmp_path / "rows")
    assert (code, printed, errors.count("\n")) == (2, "", 1)
    assert words in errors
    assert not (tmp_path / "rows").exists()


def test_scores_of_other_scenes_are_not_mixed(audio, tmp_path, ross):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "azimuths.json").write_text(json.dumps({TURN: []}))
    assert scored(ross, audio, tmp_path / "mine", tmp_path / "rows")[0] == 0
    before = {path.name: path.read_bytes() for path in (tmp_path / "rows").iterdir()}
    other = tmp_path / "audio"
    shutil.copytree(audio, other)
    for change, words in (({"quick": True}, "quick is False, not True"), ({"list": "abc"}, "not abc")):
        (other / "benchmark.json").write_text(json.dumps(json_file(audio / "benchmark.json") | change))
        code, printed, errors = scored(ross, other, tmp_path / "mine", tmp_path / "rows")
        assert (code, printed, errors.count("\n")) == (2, "", 1)
        assert "holds scores of other scenes" in errors
        assert words in errors
        assert {path.name: path.read_bytes() for path in (tmp_path / "rows").iterdir()} == before
    (tmp_path / "rows" / "scenes.json").unlink()
    code, _, errors = scored(ross, audio, tmp_path / "mine", tmp_path / "rows")
    assert (code, errors.count("\n")) == (2, 1)
    assert "holds scores, and no scenes.json that says of what" in errors


@pytest.mark.parametrize(
    "damage",
    [
        ("benchmark.json", {"scenes": 5}, "benchmark.json: scenes: expected a list of names, got 5"),
        ("benchmark.json", {"scenes": [5]}, "benchmark.json: scenes: expected a list of names, got [5]"),
        (f"{K3[0]}/scene.json", {"target": None}, "scene.json: target: expected"),
        (f"{K3[0]}/scene.json", {"target": 7}, "target: expected one of 3 talkers, got 7"),
        (f"{K3[0]}/scene.json", {"rate_hz": "fast"}, "scene.json: rate_hz: expected"),
        (f"{TURN}/truth.json", {"azimuths_deg": 3}, "truth.json: azimuths_deg: expected"),
    ],
)
def test_audio_that_somebody_changed_is_refused_in_one_line(audio, tmp_path, ross, damage):
    file, change, words = damage
    shutil.copytree(audio, tmp_path / "audio")
    (tmp_path / "audio" / file).write_text(json.dumps(json_file(audio / file) | change))
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "azimuths.json").write_text(json.dumps({TURN: []}))
    code, printed, errors = scored(ross, tmp_path / "audio", tmp_path / "mine", tmp_path / "rows")
    assert (code, printed, errors.count("\n")) == (2, "", 1)
    assert words in errors
    assert not (tmp_path / "rows").exists()


def test_a_list_is_not_drawn_for_a_folder_that_is_not_there(tmp_path):
    done = CliRunner().invoke(scene_list.main, [str(tmp_path / "none")])
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert "expected the rows of a study" in done.output


def listed(*arguments):
    return CliRunner().invoke(scene_list.main, [str(each) for each in arguments])


def test_scenes_of_other_recordings_are_drawn_and_built_from_a_folder_of_them(lists, tmp_path, ross):
    speech = tmp_path / "speech"
    speech.mkdir()
    for name, path in zip(("anna", "bo-2", "cleo"), sorted((lists / "speech").rglob("*.flac")), strict=True):
        shutil.copy(path, speech / f"{name}.flac")
    shutil.copy(speech / "bo-2.flac", speech / "bo-3.flac")
    made = listed(tmp_path / "mine", "--describe", speech, "--corpus", "ours", "--licence", "CC0")
    assert (made.exit_code, made.output) == (0, "")
    lines = read_rows(tmp_path / "mine" / FILES[2], [Recording])[1]
    assert [(line.utterance, line.corpus, line.licence) for line in lines] == [
        ("anna", "ours", "CC0"), ("bo-2", "ours", "CC0"), ("cleo", "ours", "CC0"),
    ]  # fmt: skip
    (tmp_path / "mine" / FILES[0]).write_bytes(as_csv((RoomLine("S1", 0, 1),), RoomLine))
    code, _, errors = ross("build", "--list", tmp_path / "mine", *of(speech, tmp_path / "audio"))
    assert (code, errors) == (0, "")
    assert (tmp_path / "audio" / TURN / "mixture.wav").is_file()
    (speech / "anna.flac").unlink()
    code, _, errors = ross("build", "--list", tmp_path / "mine", *of(speech, tmp_path / "more"))
    assert (code, errors) == (2, f"ross: {speech}: anna of ours is missing; it is in ours\n")


def test_another_seed_draws_other_scenes_for_the_same_recordings(lists, tmp_path):
    drawn_first = []
    for seed in ((), ("--seed", 5), ()):
        shutil.copy(lists / FILES[2], tmp_path)
        assert listed(tmp_path, *seed).exit_code == 0
        drawn_first.append((tmp_path / FILES[1]).read_bytes())
    assert drawn_first[0] == drawn_first[2] != drawn_first[1]


def test_recordings_that_make_no_scene_are_refused_in_one_line(lists, tmp_path):
    lines = read_rows(lists / FILES[2], [Recording])[1]
    for wrong, words in (
        ([replace(lines[0], samples=159_999), *lines[1:]], "7-1-0000: expected at least 160000 samples, got 159999"),
        (lines[:2], "expected at least 3 recordings, got 2"),
    ):
        (tmp_path / FILES[2]).write_bytes(as_csv(wrong, Recording))
        done = listed(tmp_path)
        assert (done.exit_code, done.output.count("\n")) == (2, 1)
        assert words in done.output
        assert not (tmp_path / FILES[1]).exists()


@pytest.mark.parametrize(
    ("name", "samples", "rate", "words"),
    [
        ("a", np.ones(240_000), 24_000, "expected one channel at 16000 Hz, got 1 at 24000 Hz"),
        ("a", np.ones((160_000, 2)), RATE, "expected one channel at 16000 Hz, got 2 at 16000 Hz"),
        ("a", np.zeros(160_000), RATE, "expected a voice, got silence"),
        ("a", np.ones(159_999), RATE, "expected recordings of at least 10 s, *.flac or *.wav, all in this folder or"),
        ("a", np.arange(160_000) / 160_000, RATE, "expected at least 3 recordings, got 1"),
        ("a b", np.arange(160_000) / 160_000, RATE, "expected a name without spaces"),
    ],
    ids=["rate", "stereo", "silent", "short", "few", "spaces"],
)
def test_a_recording_that_cannot_be_described_is_named_in_one_line(tmp_path, name, samples, rate, words):
    (tmp_path / "speech").mkdir()
    soundfile.write(tmp_path / "speech" / f"{name}.wav", samples, rate)
    done = listed(tmp_path / "mine", "--describe", tmp_path / "speech", "--licence", "CC0")
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert words in done.output
    assert not (tmp_path / "mine").exists()


def test_a_file_that_is_no_recording_is_named_once(tmp_path):
    path = tmp_path / "speech" / "a.wav"
    path.parent.mkdir()
    path.write_text("no sound")
    done = listed(tmp_path / "mine", "--describe", path.parent, "--licence", "CC0")
    assert (done.exit_code, done.output.count(str(path))) == (2, 1)
    assert "not a recording that can be read: Format not recognised" in done.output


@pytest.mark.parametrize("option", ["--corpus", "--licence"])
def test_what_recordings_are_is_refused_where_none_are_described(lists, tmp_path, option):
    shutil.copy(lists / FILES[2], tmp_path)
    done = listed(tmp_path, option, "CC0")
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert "expected --describe, too" in done.output
    assert not (tmp_path / FILES[1]).exists()


@pytest.mark.parametrize(
    ("names", "words"),
    [("utterance,a,b,utterance", "expected one column 'utterance', got 2"), ("\x1b[2J,b", "got columns \\x1b[2J, b")],
)
def test_columns_that_cannot_be_meant_are_named_and_control_no_terminal(tmp_path, names, words):
    (tmp_path / FILES[2]).write_text(f"{names}\n")
    done = listed(tmp_path)
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert words in done.output
    assert "\x1b" not in done.output


def test_a_full_disk_is_named_as_one(monkeypatch, tmp_path):
    def full(path, data):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OutputError, match=r"a\.wav: cannot be written: No space left on device"):
        write_wav(tmp_path / "a.wav", np.zeros((1, 10)))


@pytest.mark.soak
def test_our_methods_are_scored_as_anybodys_and_the_oracle_is_best(audio, tmp_path, ross):
    for method in ("irm", "duet", "joint"):
        arguments = ("--audio", audio, "--method", method, "--out", tmp_path / method)
        assert ross("run", *arguments)[0] == 0
        assert scored(ross, audio, tmp_path / method, tmp_path / "rows")[0] == 0
    every = read_rows(tmp_path / "rows" / "separation.csv", [BenchmarkSeparation])[1]
    gains = {(row.method, row.scene): row.si_sdri_db for row in every}
    assert gains["irm", K3[0]] > gains["duet", K3[0]] > 3.0
    (turn,) = read_rows(tmp_path / "rows" / "localization.csv", [BenchmarkLocalization])[1]
    assert min(turn.errors_deg) < 5.0


def test_a_method_that_does_not_exist_is_refused(audio, tmp_path, ross):
    arguments = ("--audio", audio, "--method", "duett", "--out", tmp_path / "estimates")
    code, _, errors = ross("run", *arguments)
    assert (code, errors.count("\n")) == (2, 1)
    assert "did you mean 'duet'?" in errors
    assert not (tmp_path / "estimates").exists()


def test_the_program_of_the_page_enters_a_method(audio, tmp_path, monkeypatch, ross):
    program = tmp_path / "my_method.py"
    program.write_text(block(PAGE, "python", "# my_method.py").text)
    monkeypatch.setattr("sys.argv", ["my_method.py", str(audio), str(tmp_path / "mine")])
    runpy.run_path(str(program))
    assert scored(ross, audio, tmp_path / "mine", tmp_path / "rows")[0] == 0
    gains = [row.si_sdri_db for row in rows_of(tmp_path / "rows" / "separation.csv", BenchmarkSeparation).values()]
    assert min(gains) > 0.3  # the beam is better than one microphone
    with (tmp_path / "rows" / "localization.csv").open() as file:
        assert [line["k_estimated"] for line in csv.DictReader(file)] == ["0"]
