"""What may change in flight: the table, the pure change, and the file that outlives a restart."""

import math
import os
import threading
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.config import Config, load
from ross_payload.config.parameter_listing import listing
from ross_payload.config.parameter_store import Origin, Parameters
from ross_payload.config.parameter_table import TABLE, changed, value_of
from ross_payload.errors import ConfigError
from ross_payload.service.check import check_settable

ROOT = Path(__file__).parents[3]
names = st.sampled_from(list(TABLE))


@pytest.fixture
def file(tmp_path):
    return tmp_path / "state" / "params.toml"


def from_toml(tmp_path: Path, text: str) -> Config:
    path = tmp_path / "payload.toml"
    path.write_text(text)
    return load(path)


def set_once(config: Config, file: Path, **values: float) -> None:
    """One life of a payload in which somebody sets something."""
    with Parameters(config, file) as parameters:
        for name, value in values.items():
            parameters.set(name, value)


# ---------------------------------------------------------------------------------------------------- table


def test_the_table_is_small_and_its_names_fit_on_the_wire():
    assert len(TABLE) <= 30
    assert all(len(name) <= 16 and name.isascii() for name in TABLE)


def test_wiring_and_safety_are_not_in_the_table():
    tables = {parameter.place[0] for parameter in TABLE.values()}
    assert not tables & {"audio", "array", "actuator", "guard", "links", "service", "recording"}


def test_the_default_of_every_parameter_is_within_its_bounds():
    for parameter in TABLE.values():
        assert parameter.checked(value_of(Config(), parameter.name)) == value_of(Config(), parameter.name)


@pytest.mark.parametrize("name", TABLE)
def test_both_bounds_are_allowed_by_the_configuration(name):
    wide = changed(changed(Config(), "EXP_MAX_ROT", 24), "EXP_MIN_ROT", 1)
    for bound in (TABLE[name].lower, TABLE[name].upper):
        assert value_of(changed(wide, name, bound), name) == bound


def test_the_page_lists_every_parameter_as_it_is():
    page = (ROOT / "docs" / "reference" / "parameters.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert rows == [
        f"| `{p.name}` | `{p.key}` | {p.lower:g} | {p.upper:g} | {p.unit} | {value_of(Config(), p.name):g} | "
        f"{p.about} |"
        for p in TABLE.values()
    ]


# ---------------------------------------------------------------------------------------------------- change


def test_a_change_changes_one_key_and_nothing_else():
    before = Config()
    after = changed(before, "EXP_UNIT", 2.5)
    assert after.explore.unit_s == 2.5
    assert after == before.model_copy(update={"explore": before.explore.model_copy(update={"unit_s": 2.5})})
    assert before.explore.unit_s == 3.0


def test_what_a_file_may_not_say_together_a_parameter_may_not_either(tmp_path):
    narrow = from_toml(tmp_path, "[guard]\nlower_deg = -40\nupper_deg = 40\n")
    with pytest.raises(ConfigError, match=r"EXP_CONTINUOUS: .*limits at least 90 deg apart, got 80"):
        changed(narrow, "EXP_CONTINUOUS", 1.0)


def test_whole_numbers_and_switches_keep_their_type():
    config = changed(changed(Config(), "EXP_MAX_ROT", 8.0), "EXP_PIPELINED", 1.0)
    assert (config.explore.max_rotations, type(config.explore.max_rotations)) == (8, int)
    assert config.explore.pipelined is True


@given(names, st.floats(allow_nan=True, allow_infinity=True, width=32))
def test_any_number_is_taken_as_it_is_or_refused_by_name(name, value):
    try:
        after = changed(Config(), name, value)
    except ConfigError as error:
        assert str(error).startswith(name)
    else:
        assert value_of(after, name) == value
        assert TABLE[name].lower <= value <= TABLE[name].upper


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("EXP_UNIT", math.nan, "EXP_UNIT: expected a number from 0.5 to 60 s, got nan"),
        ("EXP_UNIT", 0.1, "EXP_UNIT: expected a number from 0.5 to 60 s, got 0.1"),
        ("EXP_MAX_ROT", 3.5, "EXP_MAX_ROT: expected a whole number from 1 to 24, got 3.5"),
        ("EXP_MIN_ROT", 13, "EXP_MIN_ROT: expected min_rotations <= max_rotations, got 13 and 12"),
        ("GUARD_SPEED", 1, "parameter 'GUARD_SPEED' is unknown; there are: EXP_LEAD_IN"),
    ],
)
def test_a_refusal_says_what_was_expected_and_what_was_got(name, value, says):
    with pytest.raises(ConfigError) as refused:
        changed(Config(), name, value)
    assert str(refused.value).startswith(says)


# ---------------------------------------------------------------------------------------------------- memory


def test_what_was_set_is_in_force_at_once_and_after_a_restart(file):
    with Parameters(Config(), file) as parameters:
        parameters.set("EXP_UNIT", 2.5)
        assert parameters.config.explore.unit_s == 2.5
    with Parameters(Config(), file) as again:
        assert again.value("EXP_UNIT") == 2.5
        assert again.notes == ()


MARKOV = "explore.continuous: expected an explorer that hears while turning, got 'markov'"
FAST = "explore.rate_deg_s: expected at most 30, as fast as tb6600 turns, got 90"


@pytest.mark.parametrize(
    ("tables", "earlier", "wrong", "says"),
    [
        ({"explore": {"method": "markov"}}, {}, ("EXP_CONTINUOUS", 1), MARKOV),
        ({"actuator": {"options": {"max_speed_deg_s": 30}}}, {"EXP_CONTINUOUS": 1}, ("EXP_RATE", 90), FAST),
        ({"actuator": {"options": {"max_speed_deg_s": 30}}}, {"EXP_RATE": 90}, ("EXP_CONTINUOUS", 1), FAST),
    ],
    ids=["an explorer that cannot", "too fast for the actuator", "set before"],
)
def test_what_the_payload_cannot_do_is_not_set_nor_kept_over_a_restart(file, tables, earlier, wrong, says):
    (name, value), config = wrong, Config.model_validate(tables)
    with Parameters(config, file, check_settable) as parameters:
        for other, before in earlier.items():
            parameters.set(other, before)
        with pytest.raises(ConfigError) as refused:
            parameters.set(name, value)
        assert str(refused.value) == f"{name}: {says}"
        assert parameters.value(name) != value
    set_once(config, file, **earlier | {name: value})  # as kept by an older version, or with another configuration
    with Parameters(config, file, check_settable) as again:
        check_settable(again.config)
        assert len(again.notes) == 1
        assert again.notes[0].endswith(f"{says}: discarded")
    shown = list(listing(config, file, check_settable))
    assert shown[0] == f"# {again.notes[0]}"
    check_settable(from_toml(file.parent, "\n".join(shown)))


@pytest.mark.parametrize(
    ("first", "then"), [({"EXP_MAX_ROT": 20}, {"EXP_MIN_ROT": 15}), ({"EXP_MIN_ROT": 1}, {"EXP_MAX_ROT": 2})]
)
def test_values_that_are_allowed_only_together_come_back_together(file, first, then):
    set_once(Config(), file, **first, **then)
    with Parameters(Config(), file) as again:
        assert {name: again.value(name) for name in first | then} == first | then
        assert again.notes == ()


def test_the_file_keeps_the_value_that_was_replaced(file):
    set_once(Config(), file, EXP_UNIT=2.5)
    assert tomllib.loads(file.read_text()) == {
        "version": 1,
        "parameters": {"EXP_UNIT": {"value": 2.5, "replaced": 3.0}},
    }


def test_the_configuration_wins_when_it_has_changed_since_and_says_so(file, tmp_path):
    set_once(Config(), file, EXP_UNIT=2.5, EXP_STEP=30)
    with Parameters(from_toml(tmp_path, "[explore]\nunit_s = 5.0\n"), file) as again:
        assert again.value("EXP_UNIT") == 5.0
        assert again.value("EXP_STEP") == 30
        (note,) = again.notes
    assert note == "EXP_UNIT: the configuration says 5, no longer 3: 2.5 is discarded"


def test_setting_back_what_the_configuration_says_leaves_nothing_in_the_file(file):
    set_once(Config(), file, EXP_UNIT=2.5)
    set_once(Config(), file, EXP_UNIT=3.0)
    assert tomllib.loads(file.read_text())["parameters"] == {}


def test_the_origin_tells_file_default_and_flight_apart(file, tmp_path):
    with Parameters(from_toml(tmp_path, "[explore]\nunit_s = 5.0\n"), file) as parameters:
        parameters.set("EXP_STEP", 30)
        assert parameters.origin("EXP_UNIT") is Origin.FILE
        assert parameters.origin("EXP_STEP") is Origin.IN_FLIGHT
        assert parameters.origin("XPL_RUN") is Origin.DEFAULT
        parameters.set("EXP_UNIT", 6.0)
        parameters.set("EXP_UNIT", 5.0)
        assert parameters.origin("EXP_UNIT") is Origin.FILE


def test_what_is_refused_changes_nothing(file):
    with Parameters(Config(), file) as parameters:
        with pytest.raises(ConfigError):
            parameters.set("EXP_UNIT", math.nan)
        assert parameters.config == Config()
    assert not file.exists()


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "unreadable"),
        (b"version = 1\n[parameters]\nEXP_UNIT = { value = 2.5, repl", "unreadable"),
        (b"\x00\xff\x00", "unreadable"),
        (b"version = 1\n[parameters]\nEXP_UNIT = { value = nan, replaced = 3.0 }\n", "unreadable"),
        (b"version = 1\n[parameters]\nEXP_UNIT = 2.5\n", "unreadable"),
        (b"version = 1\nparameters = 3\n", "unreadable"),
        (b"version = 2\n[parameters]\nEXP_UNIT = { value = 2.5, replaced = 3.0, by = 'hand' }\n", "newer"),
    ],
)
def test_a_file_that_cannot_be_used_is_kept_aside_and_said_so(file, content, word):
    file.parent.mkdir()
    file.write_bytes(content)
    with Parameters(Config(), file) as parameters:
        assert parameters.config == Config()
        (note,) = parameters.notes
        assert f"kept as params.toml.{word}" in note
        parameters.set("EXP_UNIT", 2.5)
    assert file.with_name(f"params.toml.{word}").read_bytes() == content
    with Parameters(Config(), file) as again:
        assert again.value("EXP_UNIT") == 2.5


def test_a_file_kept_aside_is_not_overwritten_by_the_next(file):
    file.parent.mkdir()
    for content in (b"first", b"second"):
        file.write_bytes(content)
        Parameters(Config(), file).close()
    assert file.with_name("params.toml.unreadable").read_bytes() == b"first"
    assert file.with_name("params.toml.unreadable-2").read_bytes() == b"second"


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ("EXP_UNIT = { value = 900.0, replaced = 3.0 }", "EXP_UNIT: expected a number from 0.5 to 60 s, got 900"),
        ("EXP_GONE = { value = 1.0, replaced = 3.0 }", "EXP_GONE: this version has no such parameter"),
    ],
)
def test_what_this_version_does_not_allow_is_dropped_and_said_so(file, entry, says):
    file.parent.mkdir()
    file.write_text(f"version = 1\n[parameters]\n{entry}\nEXP_STEP = {{ value = 30.0, replaced = 15.0 }}\n")
    with Parameters(Config(), file) as parameters:
        assert parameters.value("EXP_STEP") == 30
        assert parameters.value("EXP_UNIT") == 3.0
        (note,) = parameters.notes
    assert note.startswith(says)


def test_a_disk_that_cannot_be_written_is_trouble_but_the_value_is_in_force(tmp_path):
    blocked = tmp_path / "state"
    blocked.write_text("a file where the folder should be")
    with Parameters(Config(), blocked / "params.toml") as parameters:
        parameters.set("EXP_UNIT", 2.5)
        parameters.close()
        assert parameters.value("EXP_UNIT") == 2.5
        assert "cannot be written" in parameters.trouble


def test_a_crash_while_writing_leaves_the_old_file_whole(file, monkeypatch):
    set_once(Config(), file, EXP_UNIT=2.5)
    before = file.read_bytes()

    def crash(*_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(os, "fsync", crash)  # the moment after the data was handed to the system
    set_once(Config(), file, EXP_UNIT=4.0)
    assert file.read_bytes() == before


def test_without_a_path_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    set_once(Config(), None, EXP_UNIT=2.5)
    assert list(tmp_path.iterdir()) == []


def test_many_changes_are_written_last_value_last(file):
    with Parameters(Config(), file) as parameters:
        for step in range(1, 91):
            parameters.set("EXP_STEP", step)
    assert tomllib.loads(file.read_text())["parameters"]["EXP_STEP"]["value"] == 90


# ---------------------------------------------------------------------------------------------------- listing


def shown(config: Config, file: Path) -> dict[str, str]:
    """The origin of every key that is listed, by table.key."""
    found, table = {}, ""
    for line in listing(config, file):
        if line.startswith("["):
            table = line.strip("[]") + "."
        elif " = " in line and not line.startswith("#"):
            found[table + line.split(" = ")[0]] = line.rsplit("# ", 1)[1]
    return found


def test_the_listing_tells_value_and_origin_of_every_key(file, tmp_path):
    config = from_toml(tmp_path, '[explore]\nunit_s = 5.0\nstep_deg = 20.0\n[[links]]\nurl = "udpout:h:1"\n')
    set_once(config, file, EXP_STEP=30)
    origins = shown(config, file)
    assert origins["explore.unit_s"] == "file"
    assert origins["explore.step_deg"] == "in flight, instead of 20"
    assert origins["exploit.run_s"] == "default"
    assert origins["links.url"] == "file"
    assert origins["seed"] == "default"
    assert "step_deg = 30.0" in "\n".join(listing(config, file))


def test_a_spacing_that_follows_from_the_preset_is_not_said_to_be_in_the_file(file, tmp_path):
    config = from_toml(tmp_path, '[audio]\npreset = "respeaker-usb"\n[array]\noffset_deg = 3.0\n')
    origins = shown(config, file)
    assert (origins["array.spacing_m"], origins["array.offset_deg"]) == ("default", "file")
    told = from_toml(tmp_path, '[audio]\npreset = "respeaker-usb"\n[array]\nspacing_m = 0.06\n')
    assert shown(told, file)["array.spacing_m"] == "file"


def test_the_listing_is_a_file_that_means_the_same(file, tmp_path):
    text = (
        '[audio]\nsource = "file:a \\"b\\".wav"\nchannels = [2, 0]\n[informed]\nazimuths_deg = [10, -50.5]\n'
        '[actuator]\nkind = "tb6600"\noptions = { "steps per turn" = 200, pins = [1, 2], port = "x" }\n'
        '[[links]]\nurl = "udpout:h:1"\naccept = [255]\n[[links]]\nurl = "udpout:h:2"\n'
        '[listening]\nsdp_port = 8080\n[[listening.streams]]\nsink = "tcp"\noptions = { port = 5 }\n'
        '[[listening.streams]]\nsink = "file"\nwhat = "azimuth -40"\noptions = { path = "a.flac" }\n'
    )
    config = from_toml(tmp_path, text)
    assert from_toml(tmp_path, "\n".join(listing(config, file))) == config


def test_the_listing_only_looks_at_a_damaged_file(file):
    file.parent.mkdir()
    file.write_text("half a fi")
    assert "damaged" in next(iter(listing(Config(), file)))
    assert file.read_text() == "half a fi"
    assert list(file.parent.iterdir()) == [file]


def test_ross_config_show_prints_what_is_in_force(file, tmp_path, monkeypatch):
    from click.testing import CliRunner

    from ross_payload.cli import ross

    monkeypatch.setenv("STATE_DIRECTORY", str(file.parent))
    config = tmp_path / "payload.toml"
    config.write_text("[explore]\nunit_s = 5.0\n")
    set_once(load(config), file, XPL_RUN=20)
    shown = CliRunner().invoke(ross, ["config", "show", str(config)])
    assert shown.exit_code == 0
    assert [line.split()[-1] for line in shown.output.splitlines() if line.startswith("unit_s = 5.0")] == ["file"]
    assert "run_s = 20.0" in shown.output
    assert "in flight, instead of 10" in shown.output


def test_a_value_that_finds_no_thread_is_in_force_and_kept_with_the_next(file, monkeypatch, caplog):
    """It ended the payload, which sets values on the pump."""

    def refused(thread):
        raise RuntimeError("can't start new thread")

    with Parameters(Config(), file) as parameters:
        with monkeypatch.context() as patch:
            patch.setattr(threading.Thread, "start", refused)
            parameters.set("EXP_UNIT", 2.5)
        assert parameters.value("EXP_UNIT") == 2.5
        assert parameters.trouble == f"{file}: cannot be written: can't start new thread" == caplog.messages[0]
        parameters.set("EXP_STEP", 20.0)
    assert parameters.trouble == ""
    with Parameters(Config(), file) as parameters:
        assert (parameters.value("EXP_UNIT"), parameters.value("EXP_STEP")) == (2.5, 20.0)
