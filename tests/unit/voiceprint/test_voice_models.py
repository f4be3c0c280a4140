"""Networks that a user adds to compare voices."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import onnx
import pytest

from ross_payload.audio.audio_files import read_mono
from ross_payload.errors import ConfigError, PluginError
from ross_payload.interfaces import Clip
from ross_payload.voiceprint import VoiceStore, built_in_model, embedding_model, enrol
from ross_payload.voiceprint.built_in import SEVERAL
from ross_payload.voiceprint.disturbed_copies import COPIES, disturbed
from ross_payload.voiceprint.embedding_model import BUILT_IN, MOST_NUMBERS, EmbeddingModel
from ross_payload.voiceprint.embedding_print import Calibration, unit
from ross_payload.voiceprint.features import RATE, at_rate
from ross_payload.voiceprint.model_folder import ANY, ModelFolder
from speaker_network import SIZE, speaker_network, vowel

WHOLE = SIZE + built_in_model().size  # of the network and the built-in model together


@pytest.fixture
def folder(tmp_path):
    return ModelFolder(tmp_path / "data" / "voice-models")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "small.onnx"
    path.write_bytes(speaker_network())
    return path


@pytest.fixture(scope="module")
def network():
    return EmbeddingModel(speaker_network(), "small.onnx", Calibration((20.0, 40.0), (0.3, 0.5)))


@pytest.fixture(scope="module")
def ann(network):
    return enrol(vowel(), RATE, network)


def test_a_network_is_kept_used_by_itself_and_removed(folder, file):
    assert folder.in_use().fingerprint == built_in_model().fingerprint
    added = folder.add(file)
    assert (added.size, added.licence, added.calibration) == (WHOLE, "CC0-1.0", ANY)
    assert folder.names() == ("small",)
    assert folder.in_use().fingerprint == folder.in_use("small").fingerprint == added.fingerprint
    assert folder.in_use("built-in").fingerprint == built_in_model().fingerprint
    folder.remove("small")
    assert folder.names() == ()
    with pytest.raises(ConfigError, match="no voice model 'small' was added"):
        folder.remove("small")


@pytest.mark.parametrize("place", ["{away}/mine", "../../away/mine"], ids=["absolute", "relative"])
def test_no_file_outside_the_folder_is_removed(folder, file, tmp_path, place):
    folder.add(file)
    away = tmp_path / "away"
    away.mkdir()
    own = [away / "mine.onnx", away / "mine.json"]
    for path in own:
        path.write_text("the user's own")
    with pytest.raises(ConfigError, match=r"no voice model '.*' was added"):
        folder.remove(place.format(away=away))
    assert [path.read_text() for path in own] == 2 * ["the user's own"]
    assert folder.names() == ("small",)


def test_a_network_is_run_without_telemetry(file, tmp_path):
    home, code = (
        tmp_path / "home",
        f"from ross_payload.voiceprint import model_folder as m; m.ModelFolder.default().add(m.Path({str(file)!r}))",
    )
    home.mkdir()
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "ORT_"))}
    subprocess.run([sys.executable, "-c", code], env=environment | {"HOME": str(home)}, check=True, timeout=60)
    assert [path.name for path in home.iterdir()] == [".local"]
    assert [path.name for path in (home / ".local" / "share").iterdir()] == ["ross"]


def test_of_several_networks_one_has_to_be_chosen(folder, file, tmp_path):
    folder.add(file)
    other = tmp_path / "other.onnx"
    other.write_bytes(speaker_network(seed=1))
    folder.add(other)
    with pytest.raises(ConfigError, match="expected one of other, small or built-in as voice model, got 'auto'"):
        folder.in_use()
    assert folder.in_use("other").fingerprint != folder.in_use("small").fingerprint
    with pytest.raises(ConfigError, match="smal"):
        folder.in_use("smal")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"no network", "expected an ONNX file"),
        (speaker_network(bands=40), r"expected float32 \(batch, frames, 80\), got feats"),
        (speaker_network(over_time=False), r"expected one embedding \(batch, size\)"),
        (speaker_network(frames=30), r"expected float32 \(batch, frames, 80\), got feats"),
        (speaker_network(last="by_frame"), "got 30 of 30 frames and 300 of 300 frames"),
        (speaker_network(last="nothing"), "got zeros"),
        (speaker_network(last="roots"), "got numbers that are not finite"),
        (speaker_network(last="fixed"), "an embedding that depends on what is heard, got the same twice"),
        (speaker_network(size=MOST_NUMBERS + 1), f"of at most {MOST_NUMBERS} numbers, got {MOST_NUMBERS + 1}"),
    ],
    ids=[
        "text", "40 bands", "an embedding per frame", "0.3 s only", "a number per frame", "zeros", "not finite",
        "of nobody", "too large to be kept",
    ],
)  # fmt: skip
def test_what_is_no_network_of_speakers_is_refused_and_replaces_nothing(folder, file, content, words):
    kept = folder.add(file).fingerprint
    file.write_bytes(content)
    with pytest.raises(ConfigError, match=words):
        folder.add(file)
    assert folder.load("small").fingerprint == kept


def test_what_a_kill_has_left_of_a_network_is_deleted(folder, file):
    folder.add(file)
    left = folder.folder / ".0123abcd.part-small.onnx"
    for call in (lambda: folder.add(file), lambda: folder.remove("small")):
        left.write_bytes(b"half of it")
        call()
        assert not left.exists()


def test_a_network_that_does_not_end_is_refused(folder, file, monkeypatch):
    monkeypatch.setattr(embedding_model, "TRIAL_TIMEOUT_S", 0.2)
    file.write_bytes(speaker_network(last="endless"))
    with pytest.raises(ConfigError, match=r"expected an embedding of 30 frames within 0.2 s, got none"):
        folder.add(file)


def test_a_network_whose_weights_are_in_another_file_is_refused_also_where_that_is(folder, tmp_path, monkeypatch):
    """The copy would not have them."""
    monkeypatch.chdir(tmp_path)
    network = onnx.load_from_string(speaker_network())
    onnx.save(network, "parts.onnx", save_as_external_data=True, location="parts.data", size_threshold=0)
    with pytest.raises(ConfigError, match="its weights are in a file beside it: save it with all of them inside"):
        folder.add(tmp_path / "parts.onnx")


@pytest.mark.parametrize("name", ["a b.onnx", ".onnx", "auto.onnx", "built-in.onnx", "small.pt"])
def test_names_that_would_mislead_are_refused(folder, tmp_path, name):
    (tmp_path / name).write_bytes(speaker_network())
    with pytest.raises(ConfigError, match="as the name of a file"):
        folder.add(tmp_path / name)


class Failing:
    """A session of onnxruntime that does not go on as it began."""

    def __init__(self, found):
        self.found = found

    def run(self, _outputs, _inputs):
        if isinstance(self.found, Exception):
            raise self.found
        return [self.found]


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (RuntimeError("[ONNXRuntimeError] : 6\nby a kernel"), r"frames, got \[ONNXRuntimeError\] : 6$"),
        (np.full((1, SIZE), np.nan), "got numbers that are not finite"),
        (np.ones((1, SIZE + 1)), r"got shape \(17,\)"),
    ],
)
def test_a_network_that_fails_later_is_one_clear_line(monkeypatch, found, words):
    network = EmbeddingModel(speaker_network(), "small.onnx", ANY)
    monkeypatch.setattr(network, "_session", Failing(found))
    with pytest.raises(PluginError, match=f"small.onnx: expected .*{words}"):
        enrol(vowel(), RATE, network)


@pytest.mark.parametrize(("wrong", "got"), [(np.nan, "not finite"), (0.0, "zeros")])
def test_a_print_that_compares_with_nothing_does_not_replace_a_good_one(ann, tmp_path, wrong, got):
    store = VoiceStore(tmp_path / "voices")
    before = store.save("ann", ann).read_bytes()
    with pytest.raises(ConfigError, match=got):
        store.save("ann", replace(ann, embedding=wrong * ann.embedding))
    assert store.path("ann").read_bytes() == before


def test_a_calibration_is_kept_beside_its_network(folder, file, tmp_path):
    own = tmp_path / "own.json"
    own.write_text(json.dumps({"slopes": [10, 20], "thresholds": [0.2, 0.4], "source": "twelve readers"}))
    folder.add(file, own)
    assert folder.load("small").calibration == Calibration((10.0, 20.0), (0.2, 0.4), "twelve readers")
    own.write_text(json.dumps(json.loads(own.read_text()) | {"poor": [5, -0.1]}))
    folder.add(file, own)
    assert folder.load("small").calibration == Calibration((10.0, 20.0), (0.2, 0.4), "twelve readers", (5.0, -0.1))
    folder.add(file)
    assert folder.load("small").calibration == ANY


@pytest.mark.parametrize(
    "content",
    [
        '{"slopes": [1], "thresholds": [0, 0], "source": ""}',
        '{"slopes": [-1, 1], "thresholds": [0, 0], "source": ""}',
        '{"slopes": [1, 1], "thresholds": [0, 1], "source": ""}',
        '{"slopes": [1e999, 1], "thresholds": [0, 0], "source": ""}',
        f'{{"slopes": [1{"0" * 400}, 1], "thresholds": [0, 0], "source": ""}}',
        '{"slopes": [1, 1], "thresholds": [0, 0], "source": "", "poor": [0, 0]}',
        '{"slopes": [1, 1], "thresholds": [0, 0], "source": "", "poor": [1, 2]}',
        '{"slopes": [1, 1], "thresholds": [0, 0], "source": "", "poor": 1}',
        "{}",
        "[]",
        "[",
    ],
)
def test_a_wrong_calibration_is_refused(folder, file, tmp_path, content):
    (tmp_path / "own.json").write_text(content)
    with pytest.raises(ConfigError, match=r"own.json: expected a calibration|own.json: no calibration"):
        folder.add(file, tmp_path / "own.json")
    assert folder.names() == ()


def test_ratios_follow_the_duration():
    calibration = Calibration((20.0, 40.0), (0.3, 0.5))
    assert calibration.ratio(0.4, 1.0) == calibration.ratio(0.4, 3.0) == pytest.approx(2.0)
    assert calibration.ratio(0.4, 10.0) == calibration.ratio(0.4, 60.0) == pytest.approx(-4.0)
    between = calibration.ratio(0.4, np.sqrt(30.0))
    assert between == pytest.approx(0.0)


def test_a_poor_voice_has_a_slope_and_a_threshold_of_its_own():
    calibration = Calibration((20.0, 40.0), (0.3, 0.5), poor=(10.0, 0.1))
    for seconds in (3.0, 10.0):
        assert calibration.ratio(0.4, seconds, 1.0) == pytest.approx(3.0)
    assert calibration.ratio(0.4, 3.0, 0.5) == pytest.approx(15.0 * 0.2)
    assert calibration.ratio(0.4, 3.0, 0.0) == pytest.approx(2.0)
    assert Calibration((20.0, 40.0), (0.3, 0.5)).ratio(0.4, 3.0, 1.0) == pytest.approx(2.0)


def test_how_poor_clips_are_counts_by_how_long_they_are():
    poor = Calibration((20.0, 40.0), (0.3, 0.5), poor=(10.0, 0.1))
    network = EmbeddingModel(speaker_network(), "small.onnx", poor)
    print_ = enrol(vowel(seed=1), RATE, network)
    clips = [Clip(vowel(seconds=3.0, seed=2), 1.0), Clip(vowel(seconds=1.5, seed=3), 0.4)]
    mean = unit(2 * network.embed(clips[0].samples) + network.embed(clips[1].samples))
    assert print_.score_clips(clips, RATE).value == pytest.approx(print_.compared(mean, 4.5, 0.8).value)
    assert print_.compared(mean, 4.5, 0.8).value != pytest.approx(print_.compared(mean, 4.5).value, abs=0.5)


def test_a_voice_scores_higher_against_its_own_print(network):
    print_ = enrol(vowel(seed=1), RATE, network)
    own, other = (print_.score(vowel(formant=formant, seed=2), RATE).value for formant in (700.0, 2500.0))
    assert own > other
    assert np.linalg.norm(print_.embedding) == pytest.approx(1.0)
    assert print_.score(vowel(seed=2).repeat(3), 3 * RATE).value == pytest.approx(own, abs=0.5)  # another rate


def test_what_the_built_in_model_says_is_added_to_the_cosine_of_the_network(network):
    voices = [vowel(seed=1), vowel(formant=2500.0, seed=2)]
    enrolled, heard = (unit(3 * network.embed(voice) + network.embed(vowel(seed=3))) for voice in voices)
    cosine = float(unit(enrolled[:SIZE]) @ unit(heard[:SIZE]))
    told = built_in_model().similarity(unit(enrolled[SIZE:]), unit(heard[SIZE:]))
    assert network.similarity(enrolled, heard) == pytest.approx(cosine + BUILT_IN * told)
    assert network.similarity(enrolled, heard) == pytest.approx(network.similarity(enrolled, 0.5 * heard))


def test_where_the_built_in_model_has_heard_nothing_the_network_decides(network):
    enrolled, heard = (network.embed(vowel(seed=seed)) for seed in (1, 2))
    heard[SIZE:] = 0.0
    assert network.similarity(enrolled, heard) == pytest.approx(float(unit(enrolled[:SIZE]) @ unit(heard[:SIZE])))


@pytest.mark.parametrize("n", [0, 1, 399, 1000, 4799])
def test_of_less_than_the_shortest_there_is_no_embedding(network, n):
    for model in (network, built_in_model()):
        embedding = model.embed(vowel()[:n])
        assert embedding.shape == (model.size,)
        assert not embedding.any()
    assert np.linalg.norm(network.embed(vowel()[:4800])) == pytest.approx(1.0)


def test_clips_of_one_voice_count_by_how_long_they_are_and_each_is_looked_at_once(network, ann, monkeypatch):
    clips = [vowel(seconds=seconds, formant=formant) for seconds, formant in ((2.0, 700.0), (4.0, 2500.0))]
    mean = unit(2 * network.embed(clips[0]) + 4 * network.embed(clips[1]))
    calls, embed = [], network.embed
    monkeypatch.setattr(network, "embed", lambda samples: calls.append(len(samples)) or embed(samples))
    fresh = replace(ann, known={})
    both, again = (fresh.score_clips(list(map(Clip, order)), RATE) for order in (clips, clips[::-1]))
    assert both.value == pytest.approx(ann.compared(mean, 6.0).value)
    assert again.value == pytest.approx(both.value)
    assert calls == [2 * RATE, 4 * RATE]


def test_short_clips_are_joined_and_silent_ones_are_nothing(network, ann):
    short = [vowel(seconds=0.75, seed=seed) for seed in range(2)]
    assert ann.score_clips(list(map(Clip, short)), RATE) == ann.score(np.concatenate(short), RATE)
    padded = ann.score_clips([Clip(np.zeros(2 * RATE)), Clip(vowel())], RATE)
    assert padded.value == pytest.approx(ann.compared(network.embed(vowel()), 6.0).value)


def test_of_a_model_that_single_clips_have_calibrated_several_must_say_more():
    print_ = enrol(vowel(seed=1), RATE)
    clips = [vowel(seconds=2.0, seed=seed) for seed in (2, 3)]
    mean = unit(sum(built_in_model().embed(clip) for clip in clips))
    assert print_.score_clips(list(map(Clip, clips)), RATE).value == pytest.approx(
        print_.compared(mean, 4.0).value - SEVERAL
    )
    assert print_.score_clips([Clip(clips[0])], RATE) == print_.score(clips[0], RATE)


def test_silence_and_a_moment_say_nothing(network):
    print_ = enrol(vowel(), RATE, network)
    for voice in (np.zeros(RATE), vowel(seconds=0.2)):
        assert (print_.score(voice, RATE).value, print_.score(voice, RATE).accepted) == (0.0, False)


@pytest.mark.soak
def test_a_print_is_of_many_conditions_unless_it_was_separated(network):
    clean, separated = (enrol(vowel(), RATE, network, separated=flag) for flag in (False, True))
    assert separated.embedding == pytest.approx(network.embed(vowel()))
    assert float(clean.embedding @ separated.embedding) < 0.99999


def test_disturbed_copies_are_the_same_every_time_and_as_long():
    voice = vowel(seconds=1.0)
    copies, again = list(disturbed(voice)), list(disturbed(voice))
    assert len(copies) == COPIES
    for one, same in zip(copies, again, strict=True):
        assert (one == same).all()
        assert len(one) == len(voice)
        assert np.corrcoef(one, voice)[0, 1] > 0.3  # still this voice
        assert np.corrcoef(one, voice)[0, 1] < 0.99


def test_prints_are_kept_and_are_of_one_model_alone(ann, network, tmp_path):
    store = VoiceStore(tmp_path / "voices")
    print_ = ann.agreed("asked")
    path = store.save("ann", print_)
    assert path.stat().st_mode & 0o077 == 0
    again = store.load("ann", network)
    assert (again.consent, again.seconds) == ("asked", print_.seconds)
    voice = vowel(seed=3)
    assert again.score(voice, RATE).value == pytest.approx(print_.score(voice, RATE).value, abs=1e-3)
    with pytest.raises(ConfigError, match="made with another voice model: enrol this voice again"):
        store.load("ann")
    other = EmbeddingModel(speaker_network(seed=1), "other.onnx", ANY)
    with pytest.raises(ConfigError, match="enrol this voice again"):
        store.load("ann", other)


@pytest.mark.parametrize("wrong", [[0.1] * SIZE, [0.0] * WHOLE, [float("nan")] * WHOLE, "x"])
def test_a_damaged_print_is_refused(ann, network, tmp_path, wrong):
    store = VoiceStore(tmp_path / "voices")
    path = store.save("ann", ann)
    path.write_text(json.dumps(json.loads(path.read_text()) | {"embedding": wrong}))
    with pytest.raises(ConfigError, match="damaged voice print"):
        store.load("ann", network)


@pytest.mark.soak
def test_a_published_network_tells_readers_apart(shared_model, speech):
    model = EmbeddingModel(shared_model.read_bytes(), shared_model.name, ANY)
    names = ("ls3005", "ls3331")
    clips = {(name, part): read_mono(speech / name / f"{part}.flac") for name in names for part in ("enrol", "speech")}
    clean = {name: clips[name, "enrol"] for name in names}
    prints = {name: enrol(voice[: 3 * rate], rate, model) for name, (voice, rate, _) in clean.items()}
    for name in names:
        voice, rate, _ = clips[name, "speech"]
        embedding = model.embed(at_rate(voice[: 3 * rate], rate))
        scores = {other: one.compared(embedding, 3.0) for other, one in prints.items()}
        assert [other for other, score in scores.items() if score.accepted] == [name]
