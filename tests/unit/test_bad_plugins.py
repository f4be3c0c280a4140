"""Separators and explorers of others that are wrong: one line with their name, at load or as a fault of the mission."""

import json
import sys
import time
from dataclasses import asdict, replace
from importlib.metadata import EntryPoint
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

from command_line import called
from examples import in_soak
from mission_bench import SETTINGS, OneGroupEach, ThreeTalkers, rig
from ross_payload import plugins
from ross_payload.config import Config, validated
from ross_payload.dsp.stft import Stft
from ross_payload.errors import PluginError
from ross_payload.events import Answer, Estimate, Finished, Outcome, SourceEstimate, State, StateChanged
from ross_payload.interfaces import Groups, Observation, Quality, Scene
from ross_payload.orders import Explore, Seek
from ross_payload.plugin_checks import CheckedLiveSeparator, CheckedSeparator, checked_explorer, load_separator
from ross_payload.service.assemble import explorer_of
from ross_sim.study.runs.study_case import Failure, attempt
from ross_sim.study.runs.study_design import Task, chosen
from ross_sim.study.runs.talker_placement import Source
from ross_sim.talkers.synthetic_voices import synthetic_voice
from session_bench import Bench, make
from short_mission import ALONE, SHORT

STFT = Stft(SETTINGS.rate, 256, 64)


def groups(spectrogram, scene, **changes):
    return replace(OneGroupEach().batch(spectrogram, scene), **changes)


def separator(batch):
    return SimpleNamespace(name="theirs", batch=batch)


def raising(spectrogram, scene):
    raise ValueError("two\nlines of trouble")


def leaving(spectrogram, scene):
    raise SystemExit(3)


BAD_RESULTS = {
    "raises": (raising, "batch raised ValueError: two lines of trouble"),
    "exits": (leaving, "batch raised SystemExit: 3"),
    "none": (lambda x, s: None, "batch: expected Groups, got NoneType"),
    "array": (lambda x, s: x, "batch: expected Groups, got ndarray"),
    "shape": (lambda x, s: groups(x, s, signals=np.stack([x[0]] * s.n_sources)[..., 1:]), "expected shape (n, "),
    "nan": (lambda x, s: groups(x, s, signals=np.full((s.n_sources, *x[0].shape), np.nan + 0j)), "got NaN"),
    "dtype": (lambda x, s: groups(x, s, signals=np.stack([x[0].real] * s.n_sources)), "complex numbers, got dtype"),
    "members": (lambda x, s: groups(x, s, members=((0,),)), "expected members of 3 groups, got 1"),
    "nobody": (
        lambda x, s: groups(x, s, signals=np.zeros((0, *x[0].shape), complex), members=()),
        "expected 1 to 3 groups, got 0",
    ),
    "too many": (
        lambda x, s: groups(x, s, signals=np.stack([x[0]] * 9), members=((),) * 9),
        "expected 1 to 3 groups, got 9",
    ),
    "index": (lambda x, s: groups(x, s, members=((0,), (1,), (7,))), "expected members from 0 to 2"),
    "masks": (lambda x, s: groups(x, s, masks=np.ones(3)), "masks: expected shape (3, "),
    "no members": (lambda x, s: groups(x, s, members=None), "members: expected a tuple of indices for every group"),
    "flat members": (lambda x, s: groups(x, s, members=(0, 1, 2)), "members: expected a tuple of indices"),
    "broken members": (lambda x, s: groups(x, s, members=((0.0,), (1.0,), (2.0,))), "expected members from 0 to 2"),
    "no reason": (lambda x, s: groups(x, s, why=None), "why: expected a text, got None"),
    "quality": (lambda x, s: groups(x, s, quality=(3.0,) * 3), "quality: expected finite numbers of type Quality"),
    "nan quality": (lambda x, s: groups(x, s, quality=(Quality(np.nan, 0.0),) * 3), "quality: expected finite numbers"),
    "loud": (
        lambda x, s: groups(x, s, signals=np.full((3, *x[0].shape), 1e200 + 0j)),
        "that single precision can hold",
    ),
}


class Late(ThreeTalkers):
    """An explorer that is good until the third orientation."""

    def estimate(self, observations):
        if len(observations) == self.patience:
            raise KeyError("state")
        return super().estimate(observations)


class Observes(ThreeTalkers):
    def __init__(self, seen):
        super().__init__()
        self.seen = seen

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        return self.seen


class Believes(ThreeTalkers):
    def __init__(self, believed):
        super().__init__()
        self.believed = believed

    def estimate(self, observations):
        return self.believed


class Reconsiders(ThreeTalkers):
    def reconsider(self, observations, believed):
        return [source()]


def source(azimuth=0.0, **changes):
    return replace(SourceEstimate(azimuth, 0.1, 0.9, resolved=True), **changes)


BAD_EXPLORERS = {
    "late": (Late(), "estimate raised KeyError: 'state'"),
    "none": (Observes(None), "observe: expected Observation, got NoneType"),
    "weight": (Observes(Observation(0.0, np.zeros(1), np.ones(1), np.nan)), "weight of 0 or more"),
    "grid": (Observes(Observation(0.0, np.zeros(2), np.ones(1), 1.0)), "density: expected shape (2)"),
    "nan": (Believes(Estimate((source(np.nan),))), "estimate: expected finite numbers"),
    "confidence": (Believes(Estimate((source(confidence=7.0),))), "confidence from 0 to 1"),
    "crowd": (Believes(Estimate(tuple(source() for _ in range(100)))), "expected at most 16 sources, got 100"),
    "list": (Believes([source()]), "estimate: expected Estimate, got list"),
    "elevation": (Believes(Estimate((source(elevation=np.nan),))), "expected a finite elevation"),
    "nominal": (Believes(Estimate((source(nominal_sigma=-0.1),))), "expected nominal_sigma >= 0 or None"),
    "directness": (Believes(Estimate((source(),), directness=np.nan)), "a finite directness or None"),
    "certain": (Believes(Estimate((source(),), certain="yes")), "expected certain true or false"),
    "resolved": (Believes(Estimate((source(resolved=None),))), "expected resolved true or false"),
    "rival": (Believes(Estimate((source(),), rival=Estimate((source(np.nan),)))), "estimate: rival: expected finite"),
    "no sources": (Believes(Estimate(None)), "sources: expected a tuple, got NoneType"),
    "peaks": (Observes(Observation(0.0, np.zeros(1), np.ones(1), 1.0, peaks=(np.nan,))), "peaks: expected a tuple"),
    "height": (Observes(Observation(0.0, np.zeros(1), np.ones(1), 1.0, height=np.nan)), "expected a finite height"),
    "again": (Reconsiders(), "reconsider: expected Estimate, got list"),
}


def rig_with(explorer=None, batch=None):
    """A mission among fakes with one plug-in of others."""
    mine = CheckedSeparator("separator 'theirs'", separator(batch)) if batch else None
    theirs = checked_explorer("theirs", lambda: explorer) if explorer else None
    again = theirs if theirs is not None and theirs.reconsiders else None
    return rig(explorer=theirs, separator=mine, likes=1, again=again)


# ------------------------------------------------------------------------------------------- in mid-mission


@pytest.mark.parametrize(("batch", "words"), BAD_RESULTS.values(), ids=BAD_RESULTS)
def test_a_bad_separator_ends_the_mission_as_a_fault_that_names_it(batch, words):
    flown = rig_with(batch=batch)
    result = flown.run()
    assert result.outcome is Outcome.FAULT
    assert result.reason.startswith("separator 'theirs': ")
    assert words in result.reason
    assert "\n" not in result.reason
    assert [one.reason for one in flown.outputs[-1].events if isinstance(one, Finished)] == [result.reason]
    assert flown.outputs[-1].stop


@pytest.mark.parametrize(("explorer", "words"), BAD_EXPLORERS.values(), ids=BAD_EXPLORERS)
def test_a_bad_explorer_ends_the_mission_as_a_fault_that_names_it(explorer, words):
    result = rig_with(explorer=explorer).run()
    assert result.outcome is Outcome.FAULT
    assert result.reason.startswith("explorer 'theirs': ")
    assert words in result.reason


def test_numbers_of_numpy_and_lists_become_those_of_python():
    def theirs(spectrogram, scene):
        told = (Quality(np.float32(3.0), np.float32(2.0)),) * scene.n_sources
        return groups(spectrogram, scene, members=[np.array([k]) for k in range(scene.n_sources)], quality=told)

    spectrogram = np.zeros((2, 5, 4), np.complex64)
    scene = Scene(np.arange(5.0), 0.05, 343.0, 2, np.zeros(2))
    separated = CheckedSeparator("theirs", separator(theirs)).batch(spectrogram, scene)
    assert json.dumps([separated.members, asdict(separated.quality[0])]) == (
        '[[[0], [1]], {"si_sdr": 3.0, "si_sdri": 2.0}]'
    )
    one = source(
        np.float32(0.5), resolved=np.bool_(True), confidence=np.float32(1.0), elevation=np.float32(0.25),
        nominal_sigma=np.float32(0.125),
    )  # fmt: skip
    believed = Estimate([one], certain=np.all([True]), directness=np.float32(0.75), rival=Estimate([one]))
    plain = checked_explorer("theirs", lambda: Believes(believed)).estimate([])
    assert json.dumps(asdict(plain)).startswith('{"sources": [{"azimuth": 0.5, ')
    assert (
        plain.rival.sources
        == plain.sources
        == (source(0.5, confidence=1.0, elevation=0.25, sigma=0.1, nominal_sigma=0.125),)
    )
    seen = Observation(np.float32(0.5), np.zeros(1), np.ones(1), np.int64(2), peaks=np.array([0.25], np.float32))
    heard = checked_explorer("theirs", lambda: Observes(seen)).observe(spectrogram, scene.frequencies, 0.5, None)
    assert json.dumps([heard.heading, heard.weight, heard.peaks]) == "[0.5, 2.0, [0.25]]"


def test_a_live_separator_that_writes_into_its_frame_changes_it_for_nobody_else():
    def step(state, frame, scene):
        frame *= 0.0
        return state, Groups(frame[:1, :, None], ((0,),), "theirs")

    scene = Scene(np.arange(5.0), 0.05, 343.0, 1, np.zeros(1))
    frame = np.ones((2, 5), np.complex64)
    theirs = CheckedLiveSeparator("theirs", SimpleNamespace(name="theirs", lookahead=1, step=step))
    _, separated = theirs.step(None, frame, scene)
    assert not separated.signals.any()
    assert frame.all()


def test_a_good_plug_in_is_left_alone_however_slow():
    def slow(spectrogram, scene):
        time.sleep(0.05)
        return groups(spectrogram, scene)

    assert rig_with(explorer=ThreeTalkers(), batch=slow).run().outcome is Outcome.TARGET_FOUND


def test_a_live_payload_says_the_fault_and_takes_the_next_order():
    def make_theirs(config):
        kit = make(config)
        theirs = CheckedSeparator("separator 'theirs'", separator(raising))
        return replace(kit, tools=replace(kit.tools, separator=theirs))

    words, bench = "separator 'theirs': batch raised ValueError: two lines of trouble", Bench(make=make_theirs)
    for number, task, answer in ((1, Seek, Answer.FAILED), (2, Explore, Answer.DONE)):
        bench.hop(task(number=number))
        bench.over(number)
        assert bench.answers(number)[-1] is answer
    assert bench.reason(1) == words
    said = [(one.state, one.detail) for one in bench.events if isinstance(one, StateChanged)]
    assert (State.FAULT, words) in said
    assert not bench.moving


# ------------------------------------------------------------------------------------------- at load


@pytest.fixture
def installed(monkeypatch, tmp_path):
    """Plug-ins of others: a module of this text, and an entry point for `theirs` in it."""

    def install(text, group="separators"):
        (tmp_path / "their_module.py").write_text(text)
        point = EntryPoint("theirs", "their_module:plugin", f"ross_payload.{group}")
        found = plugins.available
        theirs = {"theirs": point}
        monkeypatch.setattr(
            plugins, "available", lambda asked: {**found(asked), **theirs} if asked == point.group else found(asked)
        )

    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "their_module", raising=False)
    yield install
    sys.modules.pop("their_module", None)


BATCH = "    def batch(self, spectrogram, scene): pass\n"
BAD_SEPARATORS = {
    "import": ("1 / 0", "is broken: ZeroDivisionError"),
    "missing": ("x = 1", "is broken: AttributeError"),
    "class": (f"class plugin:\n    name = 'a'\n{BATCH}", "expected an object, got the class plugin: write plugin()"),
    "no name": (f"class A:\n{BATCH}plugin = A()", "expected a text `name`, got None"),
    "number": (f"class A:\n    name = 3\n{BATCH}plugin = A()", "expected a text `name`, got 3"),
    "no method": ("class A:\n    name = 'a'\nplugin = A()", "expected a method batch(spectrogram, scene), got None"),
    "one argument": (
        "class A:\n    name = 'a'\n    def batch(self, x): pass\nplugin = A()",
        "expected batch(spectrogram, scene), got batch(x): too many positional arguments",
    ),
}
BAD_FACTORIES = {
    "no make": ("plugin = 3", "expected an object with make(spacing, speed_of_sound[, options])"),
    "make raises": ("class plugin:\n    def make(*_): raise OSError('no model')", "make raised OSError: no model"),
    "no estimate": (
        "class A:\n    name = 'a'\n    def observe(self, s, f, h, n, *, frame_period=None): pass\n"
        "class plugin:\n    def make(*_): return A()",
        "expected a method estimate(observations), got None",
    ),
    "old observe": (
        "class A:\n    name = 'a'\n    def observe(self, s, f, h, n): pass\n    def estimate(self, o): pass\n"
        "class plugin:\n    def make(*_): return A()",
        "expected observe(spectrogram, frequencies, heading, noise_psd), got observe(s, f, h, n): got an unexpected",
    ),
}


@pytest.mark.parametrize(("text", "words"), BAD_SEPARATORS.values(), ids=BAD_SEPARATORS)
def test_a_bad_separator_is_refused_at_load_in_one_line(text, words, installed):
    installed(text)
    with pytest.raises(PluginError, match="'theirs'") as refused:
        load_separator("theirs")
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("text", "words"), BAD_FACTORIES.values(), ids=BAD_FACTORIES)
def test_a_bad_explorer_is_refused_at_load_in_one_line(text, words, installed):
    installed(text, "explorers")
    with pytest.raises(PluginError, match="explorer 'theirs'") as refused:
        explorer_of(validated(Config, {"explore": {"method": "theirs"}}, "here"))
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("command", [("config", "check"), ("run",)])
def test_the_command_line_refuses_it_too(command, installed, monkeypatch, capsys, tmp_path):
    installed(BAD_SEPARATORS["no method"][0])
    file = tmp_path / "ross.toml"
    soundfile.write(tmp_path / "quiet.wav", np.zeros((16000, 2)), 16000)
    source = f'audio.source = "file:{tmp_path}/quiet.wav"'
    file.write_text(f'{source}\nexploit.separator = "theirs"\nservice.state_dir = "{tmp_path}"\n')
    code, _, err = called(monkeypatch, capsys, *command, file)
    assert code == 2
    assert "separator 'theirs': expected a method batch" in err
    assert "Traceback" not in err


@pytest.mark.soak
def test_a_simulated_mission_ends_with_one_line_and_exit_code_1(installed, monkeypatch, capsys, tmp_path):
    installed("class A:\n    name = 'a'\n    def batch(self, spectrogram, scene): return None\nplugin = A()")
    (tmp_path / "short.toml").write_text(SHORT)
    code, out, err = called(
        monkeypatch,
        capsys,
        "sitl",
        "--scenario",
        tmp_path / "short.toml",
        "--separator",
        "theirs",
        "--informed",
        "--json",
    )
    assert (code, err) == (1, "")
    assert json.loads(out)["reason"] == "separator 'theirs': batch: expected Groups, got NoneType"


def test_what_a_plugin_prints_is_kept_out_of_the_report_as_json(installed, monkeypatch, capsys, tmp_path):
    text = "class A:\n    name = 'a'\n    def batch(self, spectrogram, scene): print('debugging')\nplugin = A()"
    installed(text)
    (tmp_path / "short.toml").write_text(ALONE)
    options = ("--scenario", tmp_path / "short.toml", "--separator", "theirs", "--informed", "--json")
    code, out, err = called(monkeypatch, capsys, "sitl", *options)
    assert (code, err) == (1, "debugging\n")
    assert json.loads(out)["outcome"] == "fault"


ALIGNED = Task("S1", 2, 0, target=0)
EXPLORED = Task("S1", 2, 0, start=0, explorer="theirs", unit=1.0)
BAD_EXPLORER = """
class A:
    name = 'a'
    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None): raise SystemExit(3)
    def estimate(self, observations): pass
class plugin:
    make = lambda *_: A()
"""


@pytest.mark.parametrize(
    "wrong",
    [
        ("separators", BAD_SEPARATORS["no method"][0], "separator 'theirs': expected a method batch"),
        ("explorers", "plugin = 7", "explorer 'theirs': make raised AttributeError"),
        ("explorers", "class plugin:\n    make = lambda *_: 7", "explorer 'theirs': expected a text `name`, got None"),
    ],
    ids=["separator", "explorer", "made explorer"],
)
def test_a_study_refuses_a_bad_plugin_in_one_line(wrong, installed, monkeypatch, capsys, tmp_path):
    kind, text, words = wrong
    installed(text, kind)
    out = tmp_path / "out"
    code, _, err = called(monkeypatch, capsys, "study", "quick", "--out", out, f"--{kind}", "theirs")
    assert code == 2
    assert words in err
    assert err.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("kind", "text", "wanted"),
    [
        (
            "separators",
            "class A:\n    name = 'a'\n    def batch(self, spectrogram, scene): return None\nplugin = A()",
            Failure(ALIGNED.id, "separator 'theirs': batch: expected Groups, got NoneType"),
        ),
        (
            "explorers",
            BAD_EXPLORER,
            Failure(EXPLORED.id, "explorer 'theirs': observe raised SystemExit: 3"),
        ),
    ],
    ids=["separator", "explorer"],
)
def test_a_bad_plugin_in_a_study_fails_its_task_by_name(kind, text, wanted, installed, tmp_path):
    installed(text, kind)
    for voice in (synthetic_voice(index, 16000) for index in (0, 1)):
        soundfile.write(tmp_path / f"{voice.name}.wav", voice.speech[: 8 * 16000], 16000)
    tiny = {"settings": ("S1",), "k": (2,), "layouts": 0, "run_s": 1.0, "rate_hz": 16000, "rotations": (2,)}
    study = chosen("quick", tiny | {kind: ("theirs",)}, False)
    task = {"separators": ALIGNED, "explorers": EXPLORED}[kind]
    assert attempt(task, study, Source(tmp_path, (), 16000)) == wanted


@pytest.mark.parametrize(
    "name", ["gaussian", "duet", "auxiva", "mvdr", *in_soak("auto", "refined", "lcmv", "iva", "paper")]
)
def test_every_built_in_separator_passes_the_checks(name):
    rng = np.random.default_rng(0)
    heard = rng.normal(size=(2, 8000)).astype(np.float32)
    spectrogram = STFT.analyse(heard)
    scene = Scene(STFT.frequencies, 0.05, 343.0, 3, np.array([-1e-4, 0.0, 1e-4]), np.ones(len(STFT.frequencies)) * 1e-4)
    assert load_separator(name).batch(spectrogram, replace(scene, hop=STFT.hop)).members is not None
