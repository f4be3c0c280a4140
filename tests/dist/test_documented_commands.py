"""Every command and TOML file that README and manual print is good: run, parsed or named with the reason why not."""

import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest
import soundfile

from command_syntax import complaint, ross_commands
from examples import in_soak
from manual import ROOT, blocks, pages
from processes import ROSS
from ross_payload import plugins
from ross_payload.actuators.registry import GROUP, checked_options
from ross_payload.config import Config, validated
from ross_payload.config.parameter_store import Parameters
from ross_sim.scenario import Scenario
from ross_sim.study.runs.study_design import Study
from ross_sim.talkers.synthetic_voices import synthetic_voice

SHELL = [(block.page, command) for block in blocks("sh") for command in block.commands]
INLINE = re.compile(r"`(?:[^`\n]*/)?(ross [^`\n]+)`")

# Where a printed command is run. Every command belongs to exactly one line; a line that fits nothing is an error, too.
RUN, RUN_IN_SOAK, ELSEWHERE, NOT_RUN = "run here", "run here by make soak", "run by another test", "not run"
WHERE = [
    (r"make (demo|test|release)", NOT_RUN, "sets up a virtual environment from an index; a release does it by hand"),
    (r"make deb", ELSEWHERE, "tests/dist/test_debian_package.py"),
    (r"source ~/ross/bin/activate$", NOT_RUN, "changes the reader's own shell"),
    (r"make (check|docs)$", NOT_RUN, "what every change must pass; tests/dist/test_docs.py builds the manual"),
    (r"curl -H", NOT_RUN, "needs the reader's own ground station; tests/unit/ground/test_rest_token.py does as much"),
    (r"curl |openapi-python-client ", ELSEWHERE, "tests/process/test_rest_guide.py"),
    (r"make protocols|cc |tshark .*-r ", ELSEWHERE, "tests/interop/test_wireshark.py"),
    (r"tshark .*-i lo", NOT_RUN, "captures from an interface, which needs rights"),
    (r"pip install hypothesis", NOT_RUN, "what the tests themselves run with"),
    (r"pip uninstall|rm -r ~", NOT_RUN, "deletes what the reader has"),
    (r"ross enroll anna --forget", ELSEWHERE, "tests/unit/voiceprint/test_voiceprint_store.py"),
    (r"pip install \.$", ELSEWHERE, "tests/dist/test_own_actuator.py"),
    (r"(~/ross/bin/|venv/bin/)?pip install |python3 -m venv (~/ross|venv)$", ELSEWHERE, "tests/dist/test_wheel.py"),
    (r"(PYTHON=venv/bin/python ROSS=venv/bin/ross )?sh (ross/)?docs/examples/ci/fly.sh", ELSEWHERE,
     "tests/process/test_sitl_in_ci.py"),
    (r"ross (evaluate|sitl) .*delay-and-sum", ELSEWHERE, "tests/dist/test_own_separator.py"),
    (r"ross config check loud.toml", ELSEWHERE, "tests/dist/test_own_sink.py"),
    (r"ross config check reachy.toml|ross (actuators probe|doctor) reachy.toml", ELSEWHERE,
     "tests/dist/test_reachy_mini.py"),
    (r"ross config check camera.toml|pytest tests/contract/test_audio_source.py", ELSEWHERE,
     "tests/dist/test_own_audio_source.py"),
    (r"pytest -m hardware", NOT_RUN, "turns real hardware"),
    (r"pytest tests/contract|ross actuators probe bench|ross sitl --actuator my_turntable", ELSEWHERE,
     "tests/dist/test_own_actuator.py"),
    (r"sudo apt install ./dist/ross-payload|sudo -u ross -H ross doctor", ELSEWHERE,
     "tests/dist/test_debian_package.py"),
    (r"sudo podman build", ELSEWHERE, "tests/dist/test_container.py"),
    (r"sudo podman", NOT_RUN, "no container engine runs where the tests run; tests/dist/test_container.py"),
    (r"sudo |uname|arecord|alsamixer|udevadm|ip -details|candump|systemctl|journalctl", NOT_RUN,
     "needs root, a Raspberry Pi, or systemd as the first process"),
    (r"/opt/ross/bin/python ", ELSEWHERE, "tests/dist/test_wheel.py"),
    (r"ross sitl --serve|ross ground( udpin.*)?$|ross monitor|ross mavproxy|ross autopilot|ross world demo --pcm"
     r"|ross enroll arthur|ross sitl --speed 1", ELSEWHERE, "tests/process/test_documented_pairs.py"),
    (r"ross run", ELSEWHERE, "tests/process/test_documented_pairs.py"),
    (r"ross ground --host", ELSEWHERE, "tests/browser/test_ground_page.py"),
    (r"ross ground --map", ELSEWHERE, "tests/browser/test_map.py"),
    (r"(mkdir|cp) .*dronecan_vendor_specific_types", ELSEWHERE, "tests/interop/test_dronecan_vendor_types.py"),
    (r"pulseaudio|PULSE_SERVER|ross world demo --pipe", ELSEWHERE, "tests/interop/test_live_portaudio.py"),
    (r"ross listen", ELSEWHERE, "tests/unit/audio/test_rtp_sink.py"),
    (r"ross voice-model", ELSEWHERE, "tests/lockstep/test_voice_model.py"),
    (r"python -m ross_sim.study.", NOT_RUN, "takes recordings; its options: test_every_block_is_checked"),
    (r"python launcher.py", ELSEWHERE, "tests/interop/test_mavproxy.py"),
    (r"ffplay |gst-launch-1.0 ", ELSEWHERE, "tests/interop/test_rtp_players.py"),
    (r"vlc ", NOT_RUN, "needs a screen"),
    (r"ross hub|ross device", ELSEWHERE, "tests/realtime/test_device.py"),
    (r"ross devices --tap|ross (actuators probe|doctor) ross.toml", NOT_RUN, "needs the reader's microphones or motor"),
    (r"ross (actuators|devices)$", RUN, 0),
    (r"ross sitl --scenario one-talker --seed 1 --record tapes|ross sessions|ross replay tapes/0001", ELSEWHERE,
     "tests/lockstep/test_replay.py"),
    (r"ross enroll anna", RUN, 0),
    (r"ross evaluate", RUN, 0),
    (r"\(umask 077", RUN, 0),
    (r"ross sitl --list", RUN, 0),
    (r"ross study missions", ELSEWHERE, "tests/lockstep/test_missions_command.py"),
    (r"ross calibrate ross.toml", ELSEWHERE, "tests/unit/calibration/test_calibrate_command.py"),
    (r"ross study calibration", ELSEWHERE, "tests/lockstep/test_calibration.py"),
    (r"ross study table", ELSEWHERE, "tests/unit/study/test_page_tables.py"),
    (r"ross study benchmark|python my_method.py", ELSEWHERE, "tests/unit/study/test_benchmark.py"),
    (r"ross sitl --scenario no-target(; echo \$\?)?$", RUN_IN_SOAK, {0, 3}),
    (r"ross sitl.*--speech (DIR|~/crowd|~/recordings)|ross study separation --speech", NOT_RUN,
     "needs the reader's own recordings"),
    (r"ross study full .*--engine|dask (scheduler|worker)", ELSEWHERE, "tests/process/test_study_cluster.py"),
    (r"ross study status", ELSEWHERE, "tests/lockstep/test_study_shards.py"),
    (r"ross study (full .*--shard|merge)", ELSEWHERE, "tests/lockstep/test_study_shards.py"),
    (r"ross study (separation|above|noise|--out|quick --explorers)", NOT_RUN,
     "takes hours; presets are run by tests/lockstep/test_study.py"),
    (r"ross study quick --out", RUN_IN_SOAK, {0}),
    (r"ross sitl", RUN_IN_SOAK, {0, 3}),
    (r"ross tlog", RUN_IN_SOAK, {0}),
]  # fmt: skip


def place_of(command):
    """What is done with a command, and the detail; None when it is in no line of the table."""
    bare = command.replace(".venv/bin/", "")
    return next(((kind, detail) for pattern, kind, detail in WHERE if re.match(pattern, bare)), None)


@pytest.mark.parametrize(("page", "command"), SHELL)
def test_a_printed_command_is_in_the_table(page, command):
    assert place_of(command), f"{page}: add `{command}` to WHERE: run it, or say why not"


def test_the_table_names_only_what_is_printed_and_tests_that_exist():
    bare = [command.replace(".venv/bin/", "") for _, command in SHELL]
    for number, (pattern, kind, detail) in enumerate(WHERE):
        mine = [one for one in bare if re.match(pattern, one)]
        assert any(not any(re.match(before[0], one) for before in WHERE[:number]) for one in mine), pattern
        assert kind != ELSEWHERE or (ROOT / detail).is_file(), detail


@pytest.mark.parametrize(
    ("page", "command"), [one for one in SHELL if ross_commands(one[1])], ids=lambda value: value[:60]
)
def test_a_printed_ross_command_has_options_that_exist_and_good_values(page, command):
    for arguments in ross_commands(command):
        assert not complaint(arguments), f"{page}: {command}"


@pytest.mark.parametrize("path", pages(), ids=lambda path: path.stem)
def test_a_command_in_a_sentence_has_options_that_exist(path):
    if path.stem == "mavproxy":
        return  # its `ross` is the module's command inside of MAVProxy
    for text in filter(is_complete, INLINE.findall(path.read_text(encoding="utf-8"))):
        said = complaint(shlex.split(text)[1:])
        assert not re.search("No such|not one of|not a valid|unexpected", said), f"{text}: {said}"


def is_complete(text):
    """Whether a command in a sentence stands for itself: no placeholder such as KIND or N, no range."""
    return not re.search(r"\b[A-Z]+\b|\.\.", text)


def test_a_wrong_command_would_be_found():
    assert "No such option" in complaint(["sitl", "--scenari0"])
    assert "No such command" in complaint(["sitlx"])
    assert "'fast'" in complaint(["sitl", "--speed", "fast"])
    assert "No such command" in complaint(["sessions", "--folder", "tapes", "erase"])
    assert ross_commands("sudo -u ross -H /opt/ross/bin/ross enroll a b.wav; ross tlog x | jq .") == [
        ["enroll", "a", "b.wav"],
        ["tlog", "x"],
    ]


# ------------------------------------------------------------------------------------------------ run


@pytest.fixture
def sandbox(tmp_path, monkeypatch):
    """A folder with the files that the pages speak of, and a `ross` on the path."""
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "ross").symlink_to(Path(plugins.sys.executable).with_name("ross"))
    monkeypatch.setenv("PATH", f"{programs}:/usr/bin:/bin")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)
    rng, rate = np.random.default_rng(0), 16000
    alone = rng.laplace(scale=0.05, size=3 * rate) * np.repeat(rng.uniform(0.1, 1, 30), rate // 10)
    other = rng.laplace(scale=0.05, size=3 * rate)
    soundfile.write("mixture.wav", np.stack([alone + other, alone + np.roll(other, 2)], axis=1), rate)
    for name in ("target.wav", "alone.wav"):
        soundfile.write(name, np.stack([alone, alone], axis=1), rate)
    for name in ("anna.wav", "anna-reads.wav"):
        soundfile.write(name, synthetic_voice(0, rate).enrolment[: 10 * rate], rate)
    scenario = next(one for one in blocks("toml") if one.page.endswith("write-a-scenario.md"))
    (tmp_path / "table.toml").write_text(scenario.text)
    return tmp_path


def run(command, folder, timeout=280):
    """Run a line as a shell does; where it needs no shell, without one: most of its time would be the start."""
    line = command.replace(".venv/bin/", "")
    alone = line.startswith("ross ") and not set(line) & set("~$*?;&|<>(){}`")
    words = [*ROSS, *shlex.split(line)[1:]] if alone else line
    done = subprocess.run(
        words, shell=not alone, cwd=folder, capture_output=True, text=True, timeout=timeout, check=False
    )
    assert "Traceback" not in done.stderr, done.stderr
    return done


def of_kind(kind):
    """(page, command) of all that is done with so; what is in no line of the table is a test's failure above."""
    return [(page, command) for page, command in SHELL if (place_of(command) or (None,))[0] == kind]


def shown(page, kind):
    return [command for where, command in of_kind(kind) if where == page]


def pages_with_news(kind):
    """Pages that print a command of a kind which no page before prints."""
    first = {}
    for page, command in of_kind(kind):
        first.setdefault(command.replace(".venv/bin/", ""), page)
    return sorted(set(first.values()))


FIRST = "docs/how-to/own-recordings.md"  # enrols a voice, and evaluates a recording


@pytest.mark.parametrize("page", [FIRST, *in_soak(*(page for page in pages_with_news(RUN) if page != FIRST))])
def test_the_cheap_commands_of_a_page_do_what_they_say(page, sandbox):
    for command in shown(page, RUN):
        done = run(command, sandbox)
        assert done.returncode == 0, f"{command}\n{done.stderr}"


@pytest.mark.soak
@pytest.mark.parametrize("page", sorted({page for page, _ in of_kind(RUN_IN_SOAK)}))
def test_the_missions_of_a_page_are_flown(page, sandbox):
    for command in shown(page, RUN_IN_SOAK):
        done = run(command, sandbox, timeout=3000)
        assert done.returncode in place_of(command)[1], f"{command}\n{done.stderr}"


TUTORIALS = {"docs/tutorials/first-mission.md": "make demo", "docs/tutorials/hear-it.md": "ross sitl --scenario"}
PRINTED = re.compile(r" *\d+\.\d\d s  .*")  # a line of a mission


@pytest.mark.parametrize("page", TUTORIALS)
def test_a_mission_prints_what_the_tutorial_shows(page, sandbox):
    command = next(line for where, line in SHELL if where == page and line.startswith(TUTORIALS[page]))
    printed = run(command.replace("make demo", "ross sitl"), sandbox).stdout.splitlines()
    shown = [line for one in blocks("text") if one.page == page for line in one.text.splitlines()]
    lines = [line for line in shown if PRINTED.fullmatch(line)]
    assert len(lines) >= 3
    for line in lines:
        start, cut, _ = line.partition(" ...")
        assert any(one.startswith(start) if cut else one == line for one in printed), line


# ------------------------------------------------------------------------------------------------ TOML


def as_config(values, path):
    config = validated(Config, values, str(path))
    if config.actuator.kind in plugins.available(GROUP):
        checked_options(config)


def as_scenario(values, path):
    validated(Scenario, {"title": "a part", "talkers": [{"azimuth_deg": 0}]} | values, str(path))


def as_study(values, path):
    validated(Study, values, str(path))


def as_package(values, path):
    assert values["project"]["entry-points"]


def as_parameters(values, path):
    with Parameters(Config(), path) as parameters:
        assert not parameters.notes


READERS = {  # of files that are no payload's configuration, by page and by words in them
    ("write-a-scenario", ""): as_scenario,
    ("turntable-as-gimbal", "talkers"): as_scenario,
    ("on-a-drone", "[vehicle]"): as_scenario,
    ("run-a-study", ""): as_study,
    ("add-your-own-actuator", "# pyproject.toml"): as_package,
    ("add-your-own-explorer", "# pyproject.toml"): as_package,
    ("add-your-own-explorer", "# explored.toml"): as_scenario,
    ("add-your-own-separator", "# pyproject.toml"): as_package,
    ("add-your-own-sink", "# pyproject.toml"): as_package,
    ("parameters", "[parameters]"): as_parameters,
}


@pytest.mark.parametrize("block", blocks("toml"), ids=lambda block: f"{block.page}:{block.line}")
def test_a_printed_toml_file_is_good(block, tmp_path):
    path = tmp_path / "printed.toml"
    path.write_text(block.text)
    stem = Path(block.page).stem
    reader = next((read for (page, words), read in READERS.items() if page == stem and words in block.text), as_config)
    reader(tomllib.loads(block.text), path)


@pytest.mark.parametrize("block", blocks("python"), ids=lambda block: f"{block.page}:{block.line}")
def test_a_printed_program_is_python(block):
    if not block.text.startswith(">>>"):  # those are run by tests/unit/test_walk_pages.py
        compile(block.text, block.page, "exec")
