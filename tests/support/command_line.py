"""The command line, called in this process."""

import sys

import pytest

from ross_payload import cli


def called(monkeypatch, capsys, *arguments):
    """Call ``ross`` with these arguments; exit code, output, errors."""
    monkeypatch.setattr(sys, "argv", ["ross", *map(str, arguments)])
    with pytest.raises(SystemExit) as end:
        cli.main()
    said = capsys.readouterr()
    return end.value.code, said.out, said.err
