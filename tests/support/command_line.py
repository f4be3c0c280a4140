"""The command line, called in this process."""

import io
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import partial

import pytest

from ross_payload import cli


def called(monkeypatch, capsys, *arguments):
    """Call ``ross`` with these arguments; exit code, output, errors."""
    monkeypatch.setattr(sys, "argv", ["ross", *map(str, arguments)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    said = capsys.readouterr()
    return end.value.code, said.out, said.err


def called_once(*arguments):
    """Call ``ross`` for a fixture that several tests share; exit code, output, errors."""
    out, err = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
        patch.setattr(sys, "argv", ["ross", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            cli.main()
    return end.value.code, out.getvalue(), err.getvalue()


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    """Call ``ross`` as `called` does, with voices of its own in ``data`` of the folder of the test."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return partial(called, monkeypatch, capsys)
