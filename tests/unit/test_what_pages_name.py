"""What README and manual name is there: links, keys of the configuration, options of commands, words of the program."""

import re
from functools import cache
from typing import get_args
from urllib.parse import urlsplit

import click
import pytest

from manual import BLOCK, ROOT, pages
from ross_payload import plugins
from ross_payload.actuators.registry import GROUP
from ross_payload.cli import ross
from ross_payload.config import Config, Table
from ross_sim.scenario import Scenario

LINK = re.compile(r"\]\(([^)\s]+)\)")
LABEL = re.compile(r"^\(([\w-]+)\)=$", re.MULTILINE)
URL = re.compile(r"https?://[^\s)>`\"']+")
CODE = re.compile(r"`[^`\n]+`")
KEY = re.compile(r"`\[{1,2}([\w.]+)\]{1,2} (\w+)")  # `[guard] lower_deg`
DOTTED = re.compile(r"`([a-z_]+)\.([a-z_]+)(?= =|`)")  # `guard.lower_deg`, `mount.source = "autopilot"`
OTHERS = {"wav", "json", "toml", "tlog", "log", "app", "load_dsdl"}  # endings of files; names of the package dronecan
BACK_ENDS = set(plugins.available(GROUP)) - {"ideal"}  # which is the simulator's, and has nothing to set up
UNDOCUMENTED = {"--help", "--version"}


def prose(path):
    """A page without its blocks."""
    return BLOCK.sub("", path.read_text(encoding="utf-8"))


@cache
def anchors(path):
    """The names that GitHub and MyST give the headings of a page, and those that it gives itself."""
    text = prose(path)
    own = LABEL.findall(text)
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles} | set(own)


@cache
def labels():
    """The names that pages of the manual give themselves, which all of them know."""
    return {label for path in pages() for label in LABEL.findall(prose(path))}


@pytest.mark.parametrize("page", (*pages(), ROOT / "CHANGELOG.md"), ids=lambda path: path.stem)
def test_a_link_leads_to_a_file_and_its_heading(page):
    for target in LINK.findall(CODE.sub("", prose(page))):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        path = page.parent / file if file else page
        assert path.exists(), f"{page.name}: {target}"
        if anchor:
            known = anchors(path) if file else anchors(path) | labels()
            assert anchor in known, f"{page.name}: {target}: {sorted(known)}"


@pytest.mark.parametrize("path", (*pages(), ROOT / "CHANGELOG.md"), ids=lambda path: path.stem)
def test_an_address_of_the_web_is_one(path):
    for url in URL.findall(CODE.sub("", prose(path))):
        parts = urlsplit(url)
        assert parts.scheme == "https", f"{path.name}: {url}"
        assert re.fullmatch(r"([a-z0-9-]+\.)+[a-z]{2,}", parts.hostname or ""), f"{path.name}: {url}"
        assert not url.endswith((".", ",", ":")), f"{path.name}: {url}"


# ------------------------------------------------------------------------------------------------ keys


def tables(model, prefix=""):
    """The keys of every table of a file, by the name of the table: {"guard": {"lower_deg", ...}, ...}."""
    found = {}
    for name, field in model.model_fields.items():
        kinds = [field.annotation, *get_args(field.annotation)]
        kinds += [inner for kind in kinds for inner in get_args(kind)]
        for kind in kinds:
            if isinstance(kind, type) and issubclass(kind, Table):
                found[prefix + name] = set(kind.model_fields)
                found |= tables(kind, f"{prefix}{name}.")
    return found


@cache
def known_keys():
    known = tables(Config)
    for name, keys in tables(Scenario).items():
        known[name] = known.get(name, set()) | keys
    return known


@pytest.mark.parametrize("path", pages(), ids=lambda path: path.stem)
def test_a_key_of_the_configuration_exists(path):
    if "decisions" in path.parts:
        return  # they tell what was, too
    text, known = path.read_text(encoding="utf-8"), known_keys()
    named = KEY.findall(text)
    named += [(name, key) for name, key in DOTTED.findall(text) if name in tables(Config) and key not in OTHERS]
    assert [f"[{name}] {key}" for name, key in named if key not in known.get(name, ())] == []


@pytest.mark.parametrize("kind", sorted(BACK_ENDS))
def test_the_reference_tells_default_and_meaning_of_every_option_of_a_back_end(kind):
    reference = ROOT / "docs" / "reference"
    text = "".join((reference / page).read_text(encoding="utf-8") for page in ("configuration.md", "vehicle-yaw.md"))
    heading = "## `[actuator.options]`\n" if kind == "vehicle_yaw" else f"## `[actuator.options]` of `{kind}`\n"
    section = text.split(heading)[1].split("\n## ")[0]
    rows = [line.split("|")[1:4] for line in section.splitlines() if line.startswith("| `")]
    told = {key for keys, _, means in rows for key in re.findall(r"`(\w+)`", keys) if means.strip()}
    assert told == set(plugins.load(GROUP, kind).Config.model_fields)


def test_a_wrong_key_would_be_found():
    known = known_keys()
    assert "lower_deg" in known["guard"]
    assert "lower" not in known["guard"]
    assert {"sink", "what"} <= known["listening.streams"]
    assert "gust_s" in known["vehicle"]


# ------------------------------------------------------------------------------------------------ options


def commands(group, words=()):
    """All commands below a group, by their words: {("sitl",): command, ("study", "missions"): command, ...}."""
    context, found = click.Context(group), {}
    unlisted = ["separators"] if group.name == "study" else []  # what `ross study` without another word is
    for name in [*group.list_commands(context), *unlisted]:
        command = group.get_command(context, name)
        found[*words, name] = command
        if isinstance(command, click.Group):
            found |= commands(command, (*words, name))
    return found


def options(command):
    long = {option for each in command.params for option in (*each.opts, *each.secondary_opts)}
    return {option for option in long if option.startswith("--")} - UNDOCUMENTED


@cache
def sections():
    """What the reference says of every command: {"sitl": text, ...}; that of studies is a page of its own."""
    reference = ROOT / "docs" / "reference"
    text = (reference / "command-line.md").read_text(encoding="utf-8")
    found = {}
    for section in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        name = re.match(r"`ross ([\w-]+)", section)[1]
        found[name] = found.get(name, "") + section
    found["study"] += (reference / "study.md").read_text(encoding="utf-8")
    found["study"] += (ROOT / "docs" / "how-to" / "run-a-study.md").read_text(encoding="utf-8")
    return found


def test_the_reference_has_a_section_for_every_command_and_for_no_other():
    assert set(sections()) == {name for name, *_ in commands(ross)}


@pytest.mark.parametrize("words", sorted(commands(ross)), ids=" ".join)
def test_the_reference_names_every_option_of_a_command(words):
    told = set(re.findall(r"--[a-z][\w-]*", sections()[words[0]]))
    missing = options(commands(ross)[words]) - told
    assert not missing, f"ross {' '.join(words)}: {sorted(missing)} are not in docs/reference"


@pytest.mark.parametrize("name", sorted(sections()))
def test_the_reference_names_no_option_that_a_command_lacks(name):
    rows = re.findall(r"^\| (`-.*?) \|", sections()[name], re.MULTILINE)
    told = {option for row in rows for option in re.findall(r"--[a-z][\w-]*", row)}
    own = {option for words, command in commands(ross).items() if words[0] == name for option in options(command)}
    assert told <= own, f"ross {name} has no {sorted(told - own)}"


# ------------------------------------------------------------------------------------------------ words


@cache
def program():
    """What our programs can say: their sources without line ends and quotes, so that joined texts are whole."""
    folders = (ROOT / "ross_payload", ROOT / "protocols" / "ross_protocols")
    files = sorted(path for top in folders for suffix in ("py", "js") for path in top.rglob(f"*.{suffix}"))
    return "\n".join(path.read_text(encoding="utf-8") for path in files)


def test_a_message_of_the_table_for_operators_is_one_of_the_programs():
    page = (ROOT / "docs" / "reference" / "troubleshooting.md").read_text(encoding="utf-8")
    section = page.split("## Messages to the operator")[1].split("\n## ")[0]
    cells = [row.split(" | ")[0] for row in re.findall(r"^\| (`.*)$", section, re.MULTILINE)]
    said = [words for cell in cells for words in re.findall(r"`([^`]+)`", cell)]
    assert len(said) > 35
    parts = [part.strip() for words in said for part in re.split(r"\.\.\.|: ", words)]
    assert [part for part in parts if len(part) > 3 and part not in program()] == []
