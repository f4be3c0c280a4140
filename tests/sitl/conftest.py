"""What the simulated missions share."""

import sys

import pytest

from ross_payload import cli

SHORT = """
title = "a short mission"
[payload.explore]
lead_in_s = 2.0
unit_s = 0.5
min_rotations = 1
max_rotations = 2
[payload.exploit]
check_s = 1.0
run_s = 1.0
max_restarts = 0
[[talkers]]
azimuth_deg = 40
[[talkers]]
azimuth_deg = 155
[[talkers]]
azimuth_deg = -80
"""


@pytest.fixture
def short(tmp_path):
    path = tmp_path / "short.toml"
    path.write_text(SHORT)
    return path


@pytest.fixture
def run(monkeypatch, capsys):
    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["ross", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        said = capsys.readouterr()
        return end.value.code, said.out, said.err

    return call
