"""Arguments and options of every command: names that tell, numbers that are numbers, and help after a typing error."""

import click
import pytest

from ross_payload import cli


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["sitll"], "sitl"),
        (["config", "chek", "a.toml"], "check"),
        (["sitl", "--scenario", "drone-yaww"], "drone-yaw"),
        (["world", "dmo"], "demo"),
        (["study", "papr", "--out", "out"], "paper"),
        (["study", "--separators", "auxva", "--out", "out"], "auxiva"),
        (["enroll", "--forget", "annn"], "ann"),
    ],
)
def test_a_slip_of_the_pen_is_told_what_may_be_meant(run, tmp_path, monkeypatch, words, meant):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data" / "ross" / "voices").mkdir(parents=True)
    (tmp_path / "data" / "ross" / "voices" / "ann.json").write_text("{}")
    code, out, err = run(*words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"id you mean '{meant}'?" in err


def usages(command, path=("ross",)):
    """Every usage line."""
    context = click.Context(command, info_name=path[-1])
    yield command.collect_usage_pieces(context)
    for name in command.list_commands(context) if isinstance(command, click.Group) else ():
        yield from usages(command.get_command(context, name), (*path, name))


def test_every_argument_is_named_after_what_it_is():
    pieces = [piece for usage in usages(cli.ross) for piece in usage if piece.isupper()]
    assert "MIXTURE" in pieces
    assert not [piece for piece in pieces if len(piece.strip("[]. ")) < 3]


def commands(command, path=("ross",)):
    """Every command that is no group, and how it is called."""
    if not isinstance(command, click.Group):
        yield " ".join(path), command
        return
    context = click.Context(command, info_name=path[-1])
    for name in command.list_commands(context):
        yield from commands(command.get_command(context, name), (*path, name))


NUMBERS = [
    pytest.param(option, id=f"{called} {option.opts[0]}")
    for called, command in commands(cli.ross)
    for option in command.params
    if isinstance(option.type, click.types.FloatParamType)
]


def test_the_options_that_are_numbers_are_found():
    assert {"ross calibrate --turn", "ross world --quiet", "ross monitor --wait"} <= {each.id for each in NUMBERS}


@pytest.mark.parametrize("option", NUMBERS)
def test_no_number_may_be_nan(option):
    with pytest.raises(click.BadParameter, match=r"expected a (finite )?number, got nan"):
        option.type_cast_value(click.Context(cli.ross), ("nan",) if option.multiple else "nan")


def test_infinity_is_a_number_where_something_may_never_end():
    taken = set()
    for each in NUMBERS:
        (option,) = each.values
        try:
            option.type_cast_value(click.Context(cli.ross), ("inf",) if option.multiple else "inf")
        except click.BadParameter:
            continue
        taken.add(each.id)
    assert taken == {"ross listen --duration", "ross monitor --wait"}


@pytest.mark.parametrize("option", ["--turn", "--listen", "--elevation"])
def test_a_turn_by_nan_is_one_line_before_anything_is_opened(run, tmp_path, option):
    code, out, err = run("calibrate", tmp_path / "absent.toml", option, "nan")
    assert (code, out) == (2, "")
    assert err == f"ross: Invalid value for '{option}': expected a finite number, got nan\n"
