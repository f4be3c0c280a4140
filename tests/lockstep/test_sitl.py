"""The whole mission in the simulator, as its user runs it."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

from command_line import called_once
from examples import in_soak
from mission_fixtures import without_picture
from processes import ROSS
from ross_payload.orders import Stop
from ross_payload.service.runner import Runner
from ross_sim.clock import SimClock
from ross_sim.devices.ideal import IdealActuator
from ross_sim.sitl import mission_session
from short_mission import CHEAP, PAIR, SOON, brief, changed

pytestmark = pytest.mark.lockstep


def ross(*arguments, **options):
    command = [*ROSS, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=250, **options)


def sitl(out, *arguments):
    done = ross("sitl", "--out", out, "--json", *arguments)
    assert "Traceback" not in done.stderr, done.stderr
    return done, json.loads((out / "report.json").read_text())


@pytest.fixture
def mission(run, tmp_path):
    """Fly in this process: the exit code, what it says of itself, and its report; results are in ``tmp_path/out``."""

    def flown(*arguments, out="out", drawn=False):
        with nullcontext() if drawn else without_picture():
            code, _, said = run("sitl", "--json", "--out", tmp_path / out, *arguments)
        assert "Traceback" not in said, said
        return code, said, json.loads((tmp_path / out / "report.json").read_text())

    return flown


@dataclass(frozen=True)
class Flown:
    """A mission that a program has flown."""

    asked: tuple[object, ...]  # of `ross sitl`
    done: subprocess.CompletedProcess
    report: dict
    out: Path


@pytest.fixture(scope="module", params=["sooner", *in_soak("as it is")])
def demo(request, tmp_path_factory):
    """The demo with seed 1: it explores and listens for less time unless it is flown as it is."""
    folder = tmp_path_factory.mktemp("demo")
    asked = ("--seed", 1)
    if request.param == "sooner":
        asked = ("--scenario", brief("demo", folder, explore=SOON, check_s=1.0, run_s=1.0), *asked)
    return Flown(asked, *sitl(folder / "out", *asked), folder / "out")


def test_the_demo_finds_everyone_and_the_target(demo):
    report = demo.report
    assert demo.done.returncode == 0
    assert (report["outcome"], report["k"]) == ("target_found", 3)
    assert all(abs(source["azimuth_error_deg"]) < 5 for source in report["sources"])


def test_the_demo_looks_for_no_slip_where_nothing_slips(demo):
    assert demo.report["slips_deg"] == []
    said = [json.loads(line) for line in (demo.out / "events.jsonl").read_text().splitlines()]
    assert [event["index"] for event in said if event["event"] == "OrientationHeard"].count(0) == 1  # explored once


def test_the_demo_gains_more_than_12_db(demo):
    target = next(group for group in demo.report["groups"] if group["target"])
    assert target["talkers"] == [demo.report["target"]]
    assert target["accepted"]
    assert target["si_sdri_db"] > 12


def test_the_gain_is_in_the_file_that_one_listens_to(demo):
    voice, rate = soundfile.read(demo.out / "target.wav")
    mixture, _ = soundfile.read(demo.out / "mixture.wav")
    assert len(voice) == demo.report["configuration"]["payload"]["exploit"]["run_s"] * rate
    assert mixture.shape[1] == 2
    assert abs(len(mixture) / rate - demo.report["mission_s"]) < 1
    assert np.abs(voice).max() > 0.01
    frames = np.sqrt(np.mean(voice.reshape(-1, rate // 10) ** 2, axis=1))
    assert (frames > 1e-4).mean() > 0.5  # no gap of silence in place of a voice


def test_everything_promised_is_there(demo):
    names = {path.name for path in demo.out.iterdir()}
    promised = {
        "report.json",
        "timing.json",
        "mixture.wav",
        "target.wav",
        "mission.png",
        "mission.tlog",
        "events.jsonl",
    }
    assert promised <= names
    assert json.loads(demo.done.stdout)["outcome"] == demo.report["outcome"]
    lines = (demo.out / "events.jsonl").read_text().splitlines()
    assert json.loads(lines[-1])["event"] == "Finished"
    assert str(demo.out) not in (demo.out / "report.json").read_text()


def same_files(one, two, but=()):
    names = sorted(path.name for path in one.iterdir())
    assert names == sorted(path.name for path in two.iterdir())
    for name in set(names) - {"timing.json", *but}:
        assert (one / name).read_bytes() == (two / name).read_bytes(), name


@pytest.mark.soak  # of two processes, with a recording: test_replay
def test_a_rerun_in_another_process_whose_telemetry_nobody_hears_gives_the_same_bytes(demo, mission, tmp_path):
    mission(*demo.asked, "--telemetry", "udpout:127.0.0.1:9", drawn=True)
    same_files(demo.out, tmp_path / "out", but={"mission.tlog"})  # where both fly alike: test_onlooker


@pytest.mark.soak
def test_recorded_talkers_are_told_apart(speech, tmp_path):
    done, report = sitl(tmp_path / "out", "--speech", speech, "--seed", 3)
    assert done.returncode == 0
    assert all(abs(source["azimuth_error_deg"]) < 5 for source in report["sources"])


def test_a_target_that_is_not_there_is_not_found(mission, tmp_path):
    explore = SOON | {"unit_s": 1.0}
    asked = brief("no-target", tmp_path, explore=explore, max_restarts=0, check_s=1.0, run_s=1.0, **CHEAP)
    text = asked.read_text().replace("target = 3", "target = 4")  # unlike both, for less is heard
    asked.write_text(text.replace("[[talkers]]\nazimuth_deg = -80\n", ""))
    code, _, report = mission("--scenario", asked, "--actuator", "ideal")
    assert code == 3
    assert report["k"] == report["k_true"] == 2
    assert not report["groups"]


def test_a_mission_that_takes_somebody_else_for_the_target_does_not_end_with_0(run, tmp_path):
    """The payload accepts any voice here; only the simulation knows that it is wrong."""
    asked = brief("no-target", tmp_path, explore=SOON, criterion=-100.0, check_s=1.0, run_s=1.0, **CHEAP)
    code, said, _ = run("sitl", "--scenario", asked, "--actuator", "ideal", "--informed")
    assert code == 4
    assert re.search(r"\ntarget found: source \d is the target \(wrong: it is (arthur|bella|cedric)\)\. ", said)


@pytest.fixture(scope="module")
def silent(tmp_path_factory):
    """A mission in silence, with seed 2 and another title, drawn: its results are among files that were there before.

    The exit code, the folder of the results, and what is said.
    """
    folder = tmp_path_factory.mktemp("silent")
    out = folder / "out"
    out.mkdir()
    for name in ("group-photo.wav", "group-7.wav", "notes.txt"):
        (out / name).write_text("mine")
    asked = brief("silence", folder, explore=SOON)
    asked.write_text("title = 'cost $\\\\frac$ [red]'\n" + asked.read_text().split("\n", 1)[1])
    code, said, errors = called_once("sitl", "--out", out, "-s", asked, "--seed", 2)
    assert "Traceback" not in errors
    return code, out, said


def test_a_silent_room_holds_nobody(silent):
    code, out, said = silent
    report = json.loads((out / "report.json").read_text())
    assert code == 3
    assert report["k"] == 0
    assert report["reason"] == "nobody is talking"
    assert said.endswith(f"\nResults: {out}/ (listen: mixture.wav; look: mission.png)\n")


def test_a_silent_room_holds_nobody_for_microphones_with_an_offset_either(mission, monkeypatch, tmp_path):
    """Periods that began and ended with a step had up to four talkers in them."""
    begin = Runner.__init__

    class Offset:
        def __init__(self, source):
            self._source = source

        def __getattr__(self, name):
            return getattr(self._source, name)

        def read(self, n):
            block = self._source.read(n)
            return replace(block, samples=block.samples + np.array([[0.01], [0.008]], np.float32))

    monkeypatch.setattr(
        Runner,
        "__init__",
        lambda self, mission, source, *rest, **more: begin(self, mission, Offset(source), *rest, **more),
    )
    asked = changed("silence", tmp_path, {"snr_db = 20": "snr_db = 45"})
    code, _, report = mission("--scenario", asked, "--seed", 2)
    assert (code, report["k"], report["reason"]) == (3, 0, "nobody is talking")


@pytest.mark.soak  # of the room alone: test_noise_sources
def test_another_seed_gives_other_noise(silent, mission, tmp_path):
    mission(
        "--scenario", brief("silence", tmp_path, explore=SOON | {"max_rotations": 1, "min_rotations": 1}), "--seed", 1
    )
    one, two = (soundfile.read(folder / "mixture.wav", frames=16000)[0] for folder in (silent[1], tmp_path / "out"))
    assert (one != two).mean() > 0.5


def test_other_files_in_the_folder_are_left_alone_and_a_title_is_only_a_title(silent):
    _, out, _ = silent
    assert (out / "mission.png").stat().st_size
    assert (out / "group-photo.wav").read_text() == "mine"
    assert (out / "notes.txt").read_text() == "mine"
    assert not (out / "group-7.wav").exists()  # taken for an earlier mission's


def test_one_talker_is_found(mission, tmp_path):
    code, _, report = mission(
        "--scenario", brief("one-talker", tmp_path, explore=SOON, check_s=1.0, run_s=1.0, **CHEAP)
    )
    assert (code, report["k"]) == (0, 1)
    assert abs(report["sources"][0]["azimuth_error_deg"]) < 5


@pytest.mark.parametrize("wanted", [True, False])
def test_an_actuator_that_cannot_be_closed_costs_no_results(run, short, tmp_path, monkeypatch, wanted):
    def broken(actuator, *error):
        raise OSError("the wire is gone")

    monkeypatch.setattr(IdealActuator, "__exit__", broken)
    short.write_text(PAIR)
    out = ("--out", tmp_path / "out") if wanted else ()
    code, printed, errors = run("sitl", "--scenario", short, "--informed", "--actuator", "ideal", "--json", *out)
    assert (code, errors) == (1, "ross: the driver broke: OSError('the wire is gone')\n")
    told = json.loads(printed)["outcome"]
    assert told != "fault"
    assert (tmp_path / "out").exists() == wanted
    if wanted:
        report = json.loads((tmp_path / "out" / "report.json").read_text())
        assert report["outcome"] == told
        assert soundfile.info(tmp_path / "out" / "mixture.wav").duration >= report["mission_s"]


@pytest.mark.soak
def test_two_talkers_that_mirror_each_other_are_two(tmp_path):
    done, report = sitl(tmp_path / "out", "--scenario", "two-talkers-mirrored")
    assert (done.returncode, report["k"]) == (0, 2)
    assert report["alignment"]["used"]["isolation_us"] > 50


@pytest.mark.soak
def test_the_ideal_actuator_hears_the_same(demo, tmp_path):
    _, ideal = sitl(tmp_path / "out", *demo.asked, "--actuator", "ideal")
    found = sorted(source["azimuth_deg"] for source in demo.report["sources"])
    np.testing.assert_allclose(found, sorted(source["azimuth_deg"] for source in ideal["sources"]), atol=0.5)


def test_ctrl_c_in_the_middle_of_a_move_decelerates_and_closes_the_files(short, tmp_path):
    short.write_text(PAIR)
    out = tmp_path / "out"
    command = [
        sys.executable,
        "-u",
        "-m",
        "ross_payload.cli",
        "sitl",
        "--scenario",
        short,
        "--informed",
        "--speed",
        "2",
        "--out",
        out,
    ]
    with subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        for line in process.stdout:
            if "turning to" in line:
                break
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        rest, err = process.communicate(timeout=60)
    assert process.returncode == 130, err + rest
    assert "Traceback" not in err
    report = json.loads((out / "report.json").read_text())
    assert report["outcome"] == "stopped"
    assert soundfile.info(out / "mixture.wav").duration >= report["mission_s"]
    assert not [path for path in out.iterdir() if path.name.startswith(".")]
    last = json.loads((out / "events.jsonl").read_text().splitlines()[-1])
    assert last["event"] == "Finished"


WRITING = """
import sys, time
from ross_payload import cli
from ross_sim.sitl import mission_session
write = mission_session._write
def slowly(*those):
    print("writing", flush=True)
    time.sleep(1.0)
    write(*those)
mission_session._write = slowly
mission_session.stopping.__defaults__ = (30.0,)
sys.argv[0] = "ross"
cli.main()
"""


def test_a_signal_that_is_passed_on_while_results_are_written_does_not_cost_them(short, tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-c", WRITING, "sitl", "--scenario", str(short), "--speed", "1", "--out", str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert any("turning to" in line for line in process.stdout)
        process.send_signal(signal.SIGINT)
        assert any(line == "writing\n" for line in process.stdout)
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (130, "")
    assert json.loads((out / "report.json").read_text())["outcome"] == "stopped"


ENDLESS = """
class Endless:
    name = "endless"
    def batch(self, spectrogram, scene):
        print("computing", flush=True)
        while True:
            pass
separator = Endless()
"""


ALIVE = ("--serve", "--speed", "max", "--telemetry", "udpout:127.0.0.1:9")


@pytest.mark.parametrize(
    ("number", "how", "later"),
    [(signal.SIGINT, ["--informed"], 0.2), (signal.SIGTERM, ["--informed"], 0.2), (signal.SIGINT, ALIVE, 2.2)],
)
def test_a_second_signal_ends_a_mission_whose_plug_in_computes_for_ever(number, how, later, short, tmp_path):
    package, out = tmp_path / "package", tmp_path / "out"
    (package / "endless-1.dist-info").mkdir(parents=True)
    points = "[ross_payload.separators]\nendless = endless:separator\n"
    (package / "endless-1.dist-info" / "entry_points.txt").write_text(points)
    (package / "endless.py").write_text(ENDLESS)
    short.write_text(PAIR + "\n[payload.service]\nautostart = 'seek'\n")
    options = ["--scenario", short, *how, "--separator", "endless", "--out", out]
    command = [*ROSS, "sitl", *map(str, options)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(package), os.environ.get("PYTHONPATH", "")])}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        try:
            assert any(line == "computing\n" for line in process.stdout), process.stderr.read()
            for _ in range(2):
                process.send_signal(number)
                time.sleep(later)
            _, err = process.communicate(timeout=30)
        finally:
            process.kill()
    said = err.strip().removeprefix("MAVLink at udpout:127.0.0.1:9\n\n")
    assert (process.returncode, said) == (130, "ross: interrupted")
    assert not out.exists()


def test_a_signal_that_a_script_passes_on_is_no_second_one():
    """A terminal gives Ctrl-C to a script and to what it runs; the script gives SIGTERM to that."""
    clock, orders = SimClock(), []
    stop = mission_session.stopping(SimpleNamespace(order=orders.append), clock, Stop())
    stop("SIGINT")
    clock.sleep(0.05)
    stop("SIGTERM")
    assert set(orders) == {Stop()}
    clock.sleep(0.2)
    with pytest.raises(KeyboardInterrupt):
        stop("SIGINT")


def test_limits_that_exclude_every_alignment_end_cleanly(mission, short):
    short.write_text(PAIR + "\n[payload.guard]\nlower_deg = -1.0\nupper_deg = 1.0\n")
    code, said, report = mission("--scenario", short)
    assert code in (0, 3), said
    assert report["rotations"] == 0
    candidates = report["alignment"]["candidates"] if report["alignment"] else []
    assert all(abs(candidate["joint_deg"]) <= 1.0 for candidate in candidates)
    assert {candidate["rule"] for candidate in candidates} <= {"limited", "stay"}


@pytest.mark.usefixtures("demo")  # fills the caches
def test_a_full_disk_is_one_line_and_the_earlier_results_stay(short, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.json").write_text("the good old one")
    limit = "import resource as r; r.setrlimit(r.RLIMIT_FSIZE, (150_000, 150_000))\n"
    limit += "from ross_payload.cli import main; main()"
    command = [sys.executable, "-c", limit, "sitl", "--scenario", str(short), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1, done.stderr
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr
    assert (out / "report.json").read_text() == "the good old one"


SOONER = {  # what happens in the scenario `restart`, in less time and to fewer
    "max_rotations = 6": "lead_in_s = 1.0\nunit_s = 1.0\nmin_rotations = 2\nmax_rotations = 2",
    "runs = 2": "runs = 2\ncheck_s = 1.0\nrun_s = 2.0\nseparator = 'gaussian'\ntrack = false",
    "[[39, 59]]": "[[7.5, 11]]",
    "[[talkers]]\nazimuth_deg = 155\n": "",  # who stays
    "end_s = 42": "end_s = 10",
    "start_s = 43": "start_s = 11",
}


@pytest.mark.soak  # without a room: test_modes
@pytest.mark.parametrize("shorter", [True, pytest.param(False, marks=pytest.mark.soak)], ids=["sooner", "as it is"])
def test_a_mission_that_loses_its_target_starts_again_and_finds_it(mission, tmp_path, shorter):
    code, _, report = mission("--scenario", changed("restart", tmp_path, SOONER if shorter else {}), "--seed", 1)
    events = [json.loads(line)["event"] for line in (tmp_path / "out" / "events.jsonl").read_text().splitlines()]
    assert "ScoreDropped" in events
    assert (code, report["outcome"]) == (0, "target_found")
    assert next(group for group in report["groups"] if group["target"])["talkers"] == [report["target"]]


@pytest.mark.soak
def test_a_target_asked_for_by_name_is_in_the_room(mission, short, speech, tmp_path):
    names = ("ls3005", "ls3331", "vctk_p226")  # more than are there: each is enrolled
    (tmp_path / "speech").mkdir()
    for name in names:
        (tmp_path / "speech" / name).symlink_to(speech / name)
    short.write_text(PAIR)
    wanted = ("--speech", tmp_path / "speech", "--target", "vctk_p226")
    code, _, report = mission("--scenario", short, "--informed", *wanted)
    assert (code, report["target"]) == (0, "vctk_p226")


def test_a_sigterm_while_setting_up_leaves_nothing_behind(tmp_path):
    out = tmp_path / "out"
    command = [*ROSS, "sitl", "--out", str(out)]
    environment = os.environ | {"ROSS_CACHE": str(tmp_path / "cold")}  # making the voices takes seconds
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment) as process:
        while not out.exists():
            time.sleep(0.02)
        time.sleep(0.3)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)
    assert process.returncode == 130
    assert not out.exists()


@pytest.mark.soak
def test_clipped_recordings_still_run(run, caplog, tmp_path, short, speech):
    folder = tmp_path / "speech"
    folder.mkdir()
    for name in ("ls3005", "ls3331"):
        samples, rate = soundfile.read(speech / name / "speech.flac", frames=320000)
        soundfile.write(folder / f"{name}.wav", np.clip(samples * 20, -1, 1), rate)
    short.write_text(PAIR)
    _, said, _ = run("sitl", "--scenario", short, "--informed", "--speech", folder, "--json")
    assert json.loads(said)["outcome"] in ("target_found", "no_target")
    assert caplog.text.count("is clipped") == 2
