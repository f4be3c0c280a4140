"""Every code block of README and manual is run or checked by a test; what is not is named here, with the reason."""

import configparser
import importlib.util
import json
import re
import tomllib
from pathlib import Path

import click
import pytest

from manual import ROOT, block, blocks, every_block, pages
from ross_payload.cli import ross

# Who checks the blocks of a language. A block in any other language, or without one, is an error.
LANGUAGES = {
    "sh": "tests/dist/test_documented_commands.py",
    "toml": "tests/dist/test_documented_commands.py",
    "python": __file__,  # PROGRAMS
    "text": __file__,  # output, or what is typed elsewhere: no command of a shell
    "json": __file__,
    "ini": __file__,
    "yaml": __file__,
    "c": "tests/interop/test_c_headers.py",
    "xml": "tests/unit/telemetry/test_mirrors.py",
    "docker": None,  # no container engine runs where the tests run
    "{eval-rst}": "tests/dist/test_docs.py",
    "{include}": "tests/dist/test_docs.py",
    "{literalinclude}": "tests/dist/test_docs.py",
    "{toctree}": "tests/dist/test_docs.py",
}

# Who runs a printed program: page, words that tell it from others, and the test; None and why it is only compiled.
PROGRAMS = [
    ("explanation/contradictions", ">>>", "tests/unit/test_walk_pages.py"),
    ("explanation/one-turn-through-the-code", ">>>", "tests/unit/test_walk_pages.py"),
    ("how-to/add-your-own-actuator", "# my_turntable/", "tests/dist/test_own_actuator.py"),
    ("how-to/add-your-own-explorer", "# my_explorer.py", "tests/dist/test_own_explorer.py"),
    ("how-to/add-your-own-separator", "# my_separator.py", "tests/dist/test_own_separator.py"),
    ("how-to/add-your-own-sink", "# my_sink.py", "tests/dist/test_own_sink.py"),
    ("how-to/command-the-payload", "command_long_send", "tests/process/test_guides.py"),
    ("how-to/command-the-payload", "divmod", "tests/unit/ground/test_guide_scripts.py"),
    ("how-to/dronecan-node", "TYPENAMES", "tests/unit/dronecan/test_dronecan_report.py"),
    ("how-to/enrol-by-pointing", "payload.enrol", "tests/unit/ground/test_guide_scripts.py"),
    ("how-to/enter-your-method", "# my_method.py", "tests/unit/study/test_benchmark.py"),
    ("how-to/ground-stations", "unwrap", "tests/interop/test_ground_stations.py"),
    ("how-to/interoperate", "MavlinkDirect", "tests/interop/test_mavsdk.py"),
    ("how-to/interoperate", "runpy", "tests/interop/test_mavproxy.py"),
    ("how-to/look-at-a-flight", "mcap.reader", "tests/unit/ground/test_flights_mcap.py"),
    ("how-to/read-telemetry", "mavlink_connection", "tests/process/test_guides.py"),
    ("how-to/run-a-study", "dask_jobqueue", None),  # needs Slurm
    ("how-to/script-the-ground", "payload.turn(10)", "tests/interop/test_ground_clients.py"),
    ("how-to/script-the-ground", "payload.events()", "tests/process/test_guides.py"),
    ("how-to/script-the-ground", "session_description", "tests/unit/ground/test_payload_client_streams.py"),
    ("how-to/script-the-ground", "turn_both", "tests/unit/ground/test_guide_scripts.py"),
    ("how-to/simulate-devices", "socketcand", "tests/unit/actuators/test_hub.py"),
    ("how-to/turntable-as-gimbal", "gimbal_list", "tests/interop/test_turntable_gimbal.py"),
    ("how-to/use-the-rest-interface", "urllib", "tests/process/test_rest_guide.py"),
    ("how-to/use-the-rest-interface", "ross_ground_client", "tests/process/test_rest_guide.py"),
    ("reference/ground-page", "ws_connect", "tests/unit/ground/test_guide_scripts.py"),
]
PROGRAM_OF_A_SHELL = re.compile(r"(\S*/)?(ross|pip|python3?|make|sudo|sh|git|pytest|apt) ")
SYNOPSIS = re.compile(r"^ross (study(?: [a-z]+)*)(.*)$", re.MULTILINE)
MODULE = re.compile(r"python -m (ross_sim[\w.]+)((?:[^`\n;]|\\\n)*)")
NAME = re.compile(r"\bross_(?:payload|protocols|sim)(?:\.\w+)+")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
GROUPS = set(PROJECT["entry-points"])
HISTORY = re.compile(r"<!--.*?-->", re.DOTALL)  # says from which commit a table is, in the words of that commit


def titled(block):
    return f"{block.page}:{block.line}"


def test_somebody_checks_the_language_of_every_block():
    unknown = [f"{titled(block)}: ```{block.language}" for block in every_block() if block.language not in LANGUAGES]
    assert not unknown, f"expected a language of {sorted(LANGUAGES)}"
    assert all(test is None or Path(ROOT, test).is_file() for test in LANGUAGES.values())


@pytest.mark.parametrize("block", blocks("python"), ids=titled)
def test_somebody_runs_a_program(block):
    page = block.page.removeprefix("docs/").removesuffix(".md")
    mine = [test for where, words, test in PROGRAMS if where == page and words in block.text]
    assert len(mine) == 1, f"{titled(block)}: add it to PROGRAMS, or the words are those of several"
    text = "".join(path.read_text(encoding="utf-8") for path in readers(mine[0]))
    assert mine[0] is None or Path(page).name in text, f"{mine[0]} does not read {page}"


def readers(test):
    """A test's file, and what it has its pages from."""
    if test is None:
        return []
    above = [folder / "conftest.py" for folder in (ROOT / test).parents if (folder / "conftest.py").is_file()]
    return [ROOT / test, *above, *(ROOT / "tests" / "support").glob("own_*.py")]


def test_every_program_of_the_table_is_printed():
    for page, words, _ in PROGRAMS:
        assert block(f"docs/{page}.md", "python", words)


@pytest.mark.parametrize("block", blocks("text"), ids=titled)
def test_a_text_holds_no_command_that_nobody_checks(block):
    for line in block.text.splitlines():
        if SYNOPSIS.match(line):
            continue  # checked below
        assert not PROGRAM_OF_A_SHELL.match(line.strip()), f"{titled(block)}: `{line}` belongs into a block `sh`"


@pytest.mark.parametrize("block", [one for one in blocks("text") if SYNOPSIS.search(one.text)], ids=titled)
def test_a_synopsis_names_options_that_exist(block):
    for words, rest in SYNOPSIS.findall(block.text):
        command, context = ross, click.Context(ross)
        for word in words.split():
            command = command.get_command(context, word) if isinstance(command, click.Group) else command
        if isinstance(command, click.Group):
            command = command.get_command(context, "separators")  # `ross study` without another word
        known = {option for each in command.params for option in each.opts}
        assert set(re.findall(r"--[a-z-]+", rest)) <= known, f"{titled(block)}: {words}"


@pytest.mark.parametrize("block", blocks("json"), ids=titled)
def test_a_printed_object_is_json(block):
    """An object, or one in every line."""
    lines = block.text.splitlines()
    each_line = all(line.startswith("{") and line.endswith("}") for line in lines)
    assert all(isinstance(json.loads(text), dict) for text in (lines if each_line else [block.text]))


@pytest.mark.parametrize("block", blocks("ini"), ids=titled)
def test_a_printed_file_of_settings_can_be_read(block):
    parser = configparser.ConfigParser(strict=False, delimiters="=")
    parser.read_string(block.text if "[" in block.text else f"[all]\n{block.text}")
    assert [parser[name] for name in parser.sections() if not parser[name]] == []


def test_the_printed_action_gives_inputs_that_the_action_takes():
    yaml = pytest.importorskip("yaml", reason="needs PyYAML, which comes with the extra cluster")
    action = yaml.safe_load((ROOT / "docs" / "examples" / "ci" / "action.yml").read_text(encoding="utf-8"))
    (printed,) = blocks("yaml")
    steps = [step for job in yaml.safe_load(printed.text)["jobs"].values() for step in job["steps"]]
    (ours,) = [step for step in steps if "docs/examples/ci" in step.get("uses", "")]
    assert set(ours["with"]) <= set(action["inputs"])


@pytest.mark.parametrize("path", pages(), ids=lambda path: path.stem)
def test_a_module_that_is_run_exists_and_has_the_options(path):
    text = HISTORY.sub("", path.read_text(encoding="utf-8"))
    for name, rest in MODULE.findall(text):
        source, _ = source_of(name)
        missing = [option for option in re.findall(r"--[a-z][\w-]*", rest) if f'"{option}"' not in source]
        assert not missing, f"{name} has no {missing}"


@pytest.mark.parametrize("path", pages(), ids=lambda path: path.stem)
def test_a_name_of_ours_is_in_the_code(path):
    if "decisions" in path.parts:
        return  # they tell what was, too
    for name in NAME.findall(HISTORY.sub("", path.read_text(encoding="utf-8"))):
        if name in GROUPS:
            continue
        source, rest = source_of(name)
        assert all(re.search(rf"\b{part}\b", source) for part in rest), f"{path.name}: {name}"


def source_of(name):
    """The text of the module of a dotted name, and the words behind it that are no module."""
    package, *rest = name.split(".")
    spec = importlib.util.find_spec(package)
    while rest and spec.submodule_search_locations:
        deeper = importlib.util.find_spec(f"{spec.name}.{rest[0]}")
        if deeper is None:
            break
        spec, rest = deeper, rest[1:]
    return Path(spec.origin).read_text(encoding="utf-8"), rest
