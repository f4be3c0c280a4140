"""`ross evaluate`: the score of two takes is the score against the truth, and every mistake is one line."""

import json
from functools import cache, partial

import numpy as np
import pytest
import soundfile
from scipy.signal import butter, lfilter

from command_line import called
from examples import in_soak, rows_in_soak
from ross_payload.audio.audio_files import write_wav
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.stft import Stft
from ross_payload.evaluation.takes import Take, lag_of, paired, placed, read_take
from ross_payload.separation.auto_separator import separator as auto
from ross_payload.separation.local_gaussian_model import separator as gaussian
from ross_sim.study.scenes.mixtures import FRAME, HOP, RATE, aligned_heading, record, scene_of
from ross_sim.study.scenes.room_settings import SETTINGS

pytestmark = pytest.mark.lockstep

SECONDS = 6
AZIMUTHS_DEG, TARGET = (170.0, 70.0, -50.0), 1
QUIET = 0.05  # full scale per unit of the simulation


def talker(seed, seconds=SECONDS):
    """Noise in syllables: what matters of speech here is that it comes and goes, in time and in frequency."""
    rng = np.random.default_rng(seed)
    n = round(seconds * RATE)
    spectrum = np.zeros((FRAME // 2 + 1, Stft(RATE, FRAME, HOP).frames_of(n)), complex)
    on = rng.random((30, spectrum.shape[1] // 8 + 1)) < 0.25
    gate = np.repeat(np.repeat(on, 8, axis=1)[:, : spectrum.shape[1]], 17, axis=0)
    noise = rng.standard_normal((*gate.shape, 2)) @ [1, 1j]
    spectrum[4 : 4 + len(gate)] = gate * noise
    return Stft(RATE, FRAME, HOP).synthesise(spectrum, n)


@pytest.fixture(scope="module")
def scene():
    azimuths = -np.deg2rad(AZIMUTHS_DEG)
    heading = aligned_heading(azimuths, TARGET)
    voices = [talker(seed) for seed in range(3)]
    return record(voices, azimuths, TARGET, heading, SETTINGS["S1"], rng=np.random.default_rng(9)), heading


@pytest.fixture(scope="module")
def takes(scene, tmp_path_factory):
    recording, _ = scene
    folder = tmp_path_factory.mktemp("takes")
    write_wav(folder / "a.wav", QUIET * recording.mixture, RATE)
    write_wav(folder / "b.wav", QUIET * recording.images[TARGET], RATE)
    return folder


@pytest.fixture
def run(monkeypatch, capsys):
    return partial(called, monkeypatch, capsys, "evaluate")


DUET = ("--separator", "duet")
CHEAP = ("--separator", "gaussian")  # than what is taken unless somebody asks for another


@pytest.fixture(scope="module")
def known_scores():
    """What was said of the takes that all tests share, by the arguments."""
    return {}


@pytest.fixture
def scored(run, takes, known_scores):
    def call(*arguments, how=CHEAP):
        asked = tuple(map(str, (*arguments, *how)))
        if asked not in known_scores:
            code, out, err = run(*asked, "--json")
            assert code == 0, err
            known_scores[asked] = out
        return json.loads(known_scores[asked])

    return call


def known(heading):
    return [word for azimuth in AZIMUTHS_DEG for word in ("--azimuth", azimuth)] + ["--heading", -np.rad2deg(heading)]


@pytest.fixture(scope="module")
def truth(scene):
    """Tell the SI-SDRi of the target's group from a sample on, from the simulator's own signals."""
    recording, _ = scene

    @cache
    def separated(known_noise, separator):
        stft = Stft(RATE, FRAME, HOP)
        groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise))
        return stft.synthesise(groups.signals[groups.members.index((TARGET,))], recording.mixture.shape[1])

    def told(start=0, *, known_noise=False, separator=gaussian):
        voice = separated(known_noise, separator)
        return si_sdri(voice[start:], recording.mixture[0, start:], recording.reference[start:])

    return told


def best(values):
    return next(group for group in values["groups"] if group["best"])


@pytest.mark.parametrize(("how", "separator"), [(CHEAP, gaussian), *rows_in_soak(((), auto))])
def test_the_score_is_that_of_the_ground_truth(scene, takes, scored, *, how, separator, truth):
    _, heading = scene
    values = scored(takes / "a.wav", takes / "b.wav", *known(heading), how=how)
    assert best(values)["sources"] == [TARGET]
    assert best(values)["si_sdri_db"] == pytest.approx(truth(separator=separator), abs=0.1)
    assert best(values)["si_sdri_db"] > 5
    assert values["lag_s"] == 0


@pytest.mark.parametrize("delay", in_soak(-0.37, 0.37 + 0.4 / RATE))
def test_another_start_and_level_of_the_second_take_change_nothing(scene, takes, scored, tmp_path, *, delay, truth):
    recording, heading = scene
    alone, n = recording.images[TARGET], recording.images.shape[-1]
    size = 2 * n
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(size) * delay * RATE)
    late = np.fft.irfft(np.fft.rfft(alone, size) * turn, size)[:, : n + max(round(delay * RATE), 0)]
    write_wav(tmp_path / "late.wav", 0.6 * QUIET * late, RATE)
    values = scored(takes / "a.wav", tmp_path / "late.wav", *known(heading))
    assert values["lag_s"] == pytest.approx(-delay, abs=0.2 / RATE)
    assert best(values)["si_sdri_db"] == pytest.approx(truth(max(round(-delay * RATE), 0)), abs=0.1)


def test_a_target_of_the_other_polarity_scores_alike_and_is_said_to_be(takes, scored, tmp_path):
    samples, rate = soundfile.read(takes / "b.wav", always_2d=True)
    soundfile.write(tmp_path / "turned.wav", -samples, rate, subtype="PCM_24")
    turned, plain = (scored(takes / "a.wav", take, *DUET) for take in (tmp_path / "turned.wav", takes / "b.wav"))
    assert turned.pop("notes") == ["target: its polarity is the opposite of that in the mixture, and turned over"]
    assert turned == {name: value for name, value in plain.items() if name != "notes"}


@pytest.mark.soak
def test_the_target_may_have_been_recorded_at_another_rate(scene, takes, scored, tmp_path, truth):
    recording, heading = scene
    size = recording.images.shape[-1]
    twice = 2 * np.fft.irfft(np.fft.rfft(recording.images[TARGET]), 2 * size)
    write_wav(tmp_path / "b48.wav", QUIET * twice, 2 * RATE)
    values = scored(takes / "a.wav", tmp_path / "b48.wav", *known(heading))
    assert best(values)["si_sdri_db"] == pytest.approx(truth(), abs=0.2)
    assert any("48000" in note for note in values["notes"])


def test_without_directions_those_that_stand_out_are_taken(scene, takes, scored, truth):
    recording, _ = scene
    values = scored(takes / "a.wav", takes / "b.wav")
    assert values["directions"] == "found in the mixture"
    assert sorted(values["tdoas_us"]) == pytest.approx(sorted({round(t, 12) for t in 1e6 * recording.tau}), abs=15)
    assert best(values)["si_sdri_db"] == pytest.approx(truth(), abs=1.5)


@pytest.mark.soak
def test_a_quiet_start_of_the_mixture_tells_the_noise(scene, takes, scored, tmp_path, truth):
    recording, heading = scene
    both = np.concatenate([recording.lead_in, recording.mixture], axis=1)
    write_wav(tmp_path / "quiet.wav", QUIET * both, RATE)
    values = scored(tmp_path / "quiet.wav", takes / "b.wav", *known(heading))
    assert values["lag_s"] == 2.0
    assert values["noise"].startswith("measured")
    assert best(values)["si_sdri_db"] == pytest.approx(truth(known_noise=True), abs=0.3)
    assert scored(takes / "a.wav", takes / "b.wav")["noise"] == "unknown"


def test_gain_and_polarity_of_a_configuration_are_applied_to_both_files(scene, takes, scored, tmp_path):
    for name in ("a.wav", "b.wav"):
        take = read_take(takes / name)
        write_wav(tmp_path / name, take.samples * np.array([[1.0], [-0.5]]), take.rate)
    path = tmp_path / "ross.toml"
    path.write_text(f"[audio]\nrate_hz = {RATE}\ngain_db = [0.0, 6.0206]\ninvert = [false, true]\n")
    directions = known(scene[1])
    right = scored(takes / "a.wav", takes / "b.wav", *directions)
    wired = scored(tmp_path / "a.wav", tmp_path / "b.wav", "--config", path, *directions)
    assert best(wired)["si_sdri_db"] == pytest.approx(best(right)["si_sdri_db"], abs=0.02)


def test_a_configuration_sets_the_rate_the_array_and_the_separator(scene, takes, scored, tmp_path):
    path = tmp_path / "payload.toml"
    path.write_text('[audio]\nrate_hz = 16000\n[array]\nspacing_m = 0.04\n[exploit]\nseparator = "duet"\n')
    values = scored(takes / "a.wav", takes / "b.wav", "--config", path, "--azimuth", 0, how=())
    assert (values["rate_hz"], values["separator"]) == (16000, "duet")
    assert values["tdoas_us"] == [pytest.approx(0.04 / 343 * 1e6, abs=0.01)]
    resampled = [note.split(":")[0] for note in values["notes"] if "resampled from 24000 to 16000" in note]
    assert resampled == ["mixture", "target"]


@pytest.mark.parametrize(("told", "frame"), [("", 2048), ("frame = 1024\n", 1024)])
def test_the_report_tells_the_frame_that_was_used(takes, scored, tmp_path, *, told, frame):
    path = tmp_path / f"{frame}.toml"
    path.write_text(f"[audio]\nrate_hz = 16000\n{told}")
    values = scored(takes / "a.wav", takes / "b.wav", "--config", path, "--azimuth", 0)
    assert values["configuration"]["audio"]["frame"] == frame


def test_one_direction_separates_nothing_and_says_so(takes, scored):
    values = scored(takes / "b.wav", takes / "b.wav")
    assert len(values["groups"]) == 1
    assert any("only one direction" in note for note in values["notes"])


@pytest.mark.soak
def test_delays_and_azimuths_say_the_same(scene, takes, scored):
    recording, heading = scene
    by_delay = [word for tau in recording.tau for word in ("--tdoa-us", 1e6 * tau)]
    one, other = (scored(takes / "a.wav", takes / "b.wav", *how) for how in (by_delay, known(heading)))
    assert one["groups"] == other["groups"]


def test_a_shorter_take_is_scored_where_both_are_heard_and_said_so(takes, scored, tmp_path):
    samples, rate = soundfile.read(takes / "b.wav", always_2d=True)
    soundfile.write(tmp_path / "short.wav", samples[: (SECONDS - 1) * rate], rate, subtype="PCM_24")
    values = scored(takes / "a.wav", tmp_path / "short.wav")
    assert values["scored_s"] == SECONDS - 1
    assert any(note.startswith("mixture: scored over the 5.00 s of 6.00 s") for note in values["notes"])


def test_some_samples_at_the_ends_are_not_worth_a_note():
    sound = np.random.default_rng(0).normal(size=(2, 32012))
    pair = paired(Take(sound[:, :32000], 16000), Take(sound[:, 12:], 16000), 16000)
    assert pair.span == slice(12, 32000)
    assert pair.notes == ()


def test_out_holds_every_voice_and_the_report_and_none_of_an_earlier_run(takes, scored, run, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "group-7.wav").write_text("of an earlier evaluation")
    (out / "notes.txt").write_text("mine")
    values = scored(takes / "a.wav", takes / "b.wav", "--sources", 2, "--out", out)
    assert sorted(path.name for path in out.iterdir()) == ["group-0.wav", "group-1.wav", "notes.txt", "report.json"]
    assert json.loads((out / "report.json").read_text()) == values
    assert str(tmp_path) not in (out / "report.json").read_text()
    info = soundfile.info(out / "group-0.wav")
    assert (info.subtype, info.samplerate, info.frames) == ("PCM_24", RATE, SECONDS * RATE)


def test_voices_louder_than_full_scale_are_softer_in_the_files_and_not_cut_off(takes, scored, tmp_path):
    """A float file may count as 16 bits do: its scores are those of the same file at full scale, the files' too."""
    loud = {}
    for name in ("a.wav", "b.wav"):
        samples, _ = soundfile.read(takes / name)
        soundfile.write(loud.setdefault(name, tmp_path / name), 32768 * samples, RATE, subtype="FLOAT")
    out, plain = tmp_path / "out", scored(takes / "a.wav", takes / "b.wav", "--sources", 2, "--out", tmp_path / "plain")
    values = scored(*loud.values(), "--sources", 2, "--out", out)
    assert best(values)["si_sdr_db"] == pytest.approx(best(plain)["si_sdr_db"], abs=0.01)
    softer = [note for note in values["notes"] if "full scale: files of --out are" in note]
    assert len(softer) == 1
    assert plain["notes"] == []
    voices = [[soundfile.read(where / f"group-{n}.wav")[0] for n in (0, 1)] for where in (tmp_path / "plain", out)]
    gain = 32768 * 10 ** (-float(softer[0].split()[-3]) / 20)
    assert np.abs(voices[1]).max() == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(voices[1], gain * np.array(voices[0]), rtol=0.02, atol=1e-4)


def test_a_note_on_files_needs_files(takes, scored, tmp_path):
    samples, _ = soundfile.read(takes / "a.wav")
    soundfile.write(tmp_path / "loud.wav", 100 * samples, RATE, subtype="FLOAT")
    assert scored(tmp_path / "loud.wav", takes / "b.wav", "--sources", 2)["notes"] == []


@pytest.mark.parametrize(("level", "subtype"), [(1.0, "FLOAT"), (1.0, "PCM_16"), (0.9, "FLOAT"), (-1.0, "FLOAT")])
def test_two_channels_that_are_the_same_are_refused(takes, run, tmp_path, level, subtype):
    """Also after a conversion to 16 bits, which adds another dither to each, or where one of them is softer."""
    samples, _ = soundfile.read(takes / "a.wav")
    both = np.array([1.0, level]) * samples[:, [0, 0]]
    dither = 2.0**-16 * np.random.default_rng(0).uniform(-1, 1, both.shape) if subtype == "PCM_16" else 0.0
    soundfile.write(tmp_path / "mono.wav", both + dither, RATE, subtype=subtype)
    code, out, err = run(tmp_path / "mono.wav", takes / "b.wav", *DUET)
    assert (code, out) == (2, "")
    assert err == "ross: mixture: both channels are the same: expected one per microphone\n"


def test_the_table_names_the_gain(takes, run):
    code, out, _ = run(takes / "a.wav", takes / "b.wav", "--separator", "duet")
    assert code == 0
    assert "separated by duet" in out


def test_the_table_shows_the_compass_degrees_that_were_given(takes, run, scored):
    where = ["--azimuth", 320, "--azimuth", 80, "--heading", 350]
    code, out, _ = run(takes / "a.wav", takes / "b.wav", *where, *DUET)
    assert code == 0
    assert "320 deg" in out
    assert "80 deg" in out
    assert scored(takes / "a.wav", takes / "b.wav", *where, how=DUET)["azimuths_deg"] == [40.0, -80.0]


def wav(folder, samples, rate=16000):
    path = folder / "odd.wav"
    soundfile.write(path, samples, rate, subtype="FLOAT")
    return path


def stereo(seed, seconds=3.0):
    return 0.1 * np.random.default_rng(seed).standard_normal((round(16000 * seconds), 2))


def not_audio(folder):
    (folder / "odd.wav").write_text("not audio")
    return folder / "odd.wav"


BAD = {
    "one per microphone, got 1": lambda folder: wav(folder, stereo(1)[:, 0]),
    "one per microphone, got 3": lambda folder: wav(folder, np.column_stack([stereo(1), stereo(2)[:, 0]])),
    "silent": lambda folder: wav(folder, np.zeros((48000, 2))),
    "microphone 2 is silent": lambda folder: wav(folder, stereo(1) * [1, 0]),
    "microphone 1 is silent": lambda folder: wav(folder, stereo(1) * [0, 1] + [0.1, 0]),  # but for its offset
    "expected finite samples": lambda folder: wav(folder, np.where(np.arange(48000)[:, None] == 5, np.nan, stereo(1))),
    "got NaN or infinity": lambda folder: wav(folder, stereo(1) + np.where(np.arange(48000)[:, None] == 5, np.inf, 0)),
    "no such file": lambda folder: folder / "odd.wav",
    "expected at least 1 s, got 0.50 s": lambda folder: wav(folder, stereo(1, 0.5)),
    "expected at least 1 s, got 0.00 s": lambda folder: wav(folder, stereo(1, 0)),
    "expected at least 8000 Hz, got 4000 Hz": lambda folder: wav(folder, stereo(1), 4000),
    "expected at most 192000 Hz, got 1999999999 Hz": lambda folder: wav(folder, stereo(1), 1_999_999_999),
    "expected samples of at most 1e+06 re full scale, got": lambda folder: wav(folder, 1e30 * stereo(1)),
    "expected audio": not_audio,
    "not in the mixture": lambda folder: wav(folder, stereo(99)),
}


@pytest.mark.parametrize("words", BAD)
def test_a_bad_recording_is_one_line_and_exit_code_2(takes, run, tmp_path, words):
    code, out, err = run(takes / "a.wav", BAD[words](tmp_path), "--out", tmp_path / "out")
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


WRONG = {
    "expected only one of them": ["--azimuth", 10, "--sources", 2],
    "--heading: expected together with --azimuth": ["--heading", 10],
    "expected at most 146 us (d / v_p), got 400": ["--tdoa-us", 400],
    "expected a finite number, got nan": ["--azimuth", "nan"],
    "--azimuth: expected -360 to 360 deg, got 1000": ["--azimuth", 10, "--azimuth", 1000],
    "--heading: expected -360 to 360 deg, got -361": ["--azimuth", 10, "--heading", -361],
    "is unknown": ["--separator", "magic"],
    "cannot be read": ["--config", "nowhere.toml"],
}


@pytest.mark.parametrize("words", WRONG)
def test_a_wrong_option_is_one_line_and_exit_code_2(takes, run, words):
    code, out, err = run(takes / "a.wav", takes / "b.wav", *WRONG[words])
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


def test_the_lag_is_found_between_samples():
    rng = np.random.default_rng(3)
    n, lag = 40000, 1234.3
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum[n // 3 :] = 0
    late = np.fft.irfft(spectrum * np.exp(-2j * np.pi * np.fft.rfftfreq(n) * lag))
    target = np.fft.irfft(spectrum)
    assert lag_of(late + 2 * rng.standard_normal(n) * target.std(), target) == pytest.approx(lag, abs=0.1)
    moved, span = placed(target, lag, n)
    inner = slice(100, -100)
    assert np.abs(moved - late[span])[inner].max() < 0.01 * target.std()


@pytest.mark.soak
def test_noise_in_the_second_take_limits_the_score_as_the_guide_says(scene, takes, scored, tmp_path):
    """A perfect output against a target with noise n dB below it scores n dB, and s and n add as powers."""
    recording, heading = scene
    alone = recording.images[TARGET]
    noise = np.random.default_rng(8).standard_normal(alone.shape) * np.sqrt((alone[0] ** 2).mean() * 10**-1.54)
    write_wav(tmp_path / "noisy.wav", QUIET * (alone + noise), RATE)
    against_truth = best(scored(takes / "a.wav", takes / "b.wav", *known(heading)))["si_sdr_db"]
    against_noise = best(scored(takes / "a.wav", tmp_path / "noisy.wav", *known(heading)))["si_sdr_db"]
    expected = -10 * np.log10(10 ** (-against_truth / 10) + 10**-1.54)
    assert against_noise == pytest.approx(expected, abs=0.5)


def test_a_constant_offset_of_a_recording_is_not_evaluated(tmp_path):
    sound = 0.05 * np.random.default_rng(4).standard_normal((2, RATE))
    sound -= sound.mean(axis=1, keepdims=True)
    write_wav(tmp_path / "plain.wav", sound, RATE)
    write_wav(tmp_path / "offset.wav", sound + np.array([[0.2], [-0.1]]), RATE)
    plain, offset = (read_take(tmp_path / f"{name}.wav").samples for name in ("plain", "offset"))
    assert offset == pytest.approx(plain, abs=2**-22)


def test_a_difference_of_roll_off_is_taken_out_of_a_take(tmp_path):
    sound = np.random.default_rng(0).normal(0, 0.1, (1, 2 * RATE)).repeat(2, axis=0)
    sound[1] = lfilter(*butter(1, 40.0, "highpass", fs=RATE), sound[1])
    write_wav(tmp_path / "take.wav", sound, RATE)
    first, second = read_take(tmp_path / "take.wav", ChannelMap((0, 1), roll_offs=(0.0, 40.0))).samples
    assert first[RATE:] == pytest.approx(second[RATE:], abs=1e-4)


def test_a_recording_that_has_clipped_is_said_to_be(takes, scored, tmp_path):
    mixture, _ = soundfile.read(takes / "a.wav")
    soundfile.write(tmp_path / "a.wav", np.clip(mixture / np.abs(mixture).max() * 4, -1, 1), RATE, "PCM_16")
    soundfile.write(tmp_path / "loud.wav", mixture / np.abs(mixture).max() * 4, RATE, "FLOAT")
    clipped, loud = (scored(tmp_path / name, takes / "b.wav", "--sources", 3) for name in ("a.wav", "loud.wav"))
    assert [note for note in clipped["notes"] if note.startswith("mixture: clipped (")]
    assert not [note for note in loud["notes"] if "clipped" in note]


def test_directions_that_cannot_be_those_of_the_target_are_said_to_be(scene, takes, scored, tmp_path):
    _, heading = scene
    swapped = [tmp_path / name for name in ("a.wav", "b.wav")]
    for path in swapped:
        write_wav(path, soundfile.read(takes / path.name)[0].T[::-1], RATE)
    where = [part for azimuth in AZIMUTHS_DEG for part in ("--azimuth", azimuth)]
    where += ["--heading", -np.rad2deg(heading)]
    right, wrong = scored(takes / "a.wav", takes / "b.wav", *where), scored(*swapped, *where)
    assert not right["notes"]
    (note,) = wrong["notes"]
    assert note.startswith("target: heard at -1") and "are the channels swapped" in note
    assert not scored(*swapped, "--sources", 3)["notes"]


@pytest.mark.parametrize("lead_in", [0, 3], ids=["from the start", "and alone before"])
def test_a_fan_that_is_heard_beside_the_target_alone_makes_no_direction_wrong(scene, takes, scored, tmp_path, lead_in):
    """It would if the highest density alone counted, or if the noise of the start were not left out."""
    _, heading = scene
    target = soundfile.read(takes / "b.wav")[0].T
    alone = np.pad(target, ((0, 0), (lead_in * RATE, 0)))
    fan = np.random.default_rng(4).standard_normal(alone.shape[1])  # abeam
    write_wav(tmp_path / "b.wav", alone + 10 ** (-5 / 20) * np.std(target) * fan, RATE)
    where = ("--azimuth", AZIMUTHS_DEG[TARGET], "--heading", -np.rad2deg(heading))
    notes = scored(takes / "a.wav", tmp_path / "b.wav", *where)["notes"]
    assert not [note for note in notes if "heard at" in note]
