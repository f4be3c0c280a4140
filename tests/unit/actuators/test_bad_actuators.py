"""What a user can get wrong about an actuator: one clear line, exit code 2, and nothing moves."""

from __future__ import annotations

import re
import socket
import stat
from pathlib import Path

import pytest

from command_line import called
from ross_payload.config import load
from ross_payload.errors import PluginError
from ross_sim.devices.far_end import far_end_of

CAN = '[actuator]\nkind = "{kind}"\noptions = {{ port = "{port}"{more} }}\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "bench.toml"
    path.write_text(text)
    return path


def ross(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str]:
    """The exit code, and the complaint: what failed, or the only line of the error output."""
    code, said, complained = called(monkeypatch, capsys, *arguments)
    assert "Traceback" not in complained + said
    failed = [line for line in said.splitlines() if line.startswith("fail")]
    lines = failed or complained.splitlines()
    assert len(lines) == 1, said + complained
    return int(str(code)), lines[0]


CONFIGURATIONS = {
    "actuator 'crane' is unknown; there are: .*ideal": '[actuator]\nkind = "crane"\n',
    "unknown key 'portt'": '[actuator]\nkind = "tb6600"\noptions = { portt = "x" }\n',
    "expected lower_deg below upper_deg, got 20": "[guard]\nlower_deg = 20\nupper_deg = 10\npark_deg = 15\n",
    "max_speed_deg_s": "[guard]\nmax_speed_deg_s = nan\n",
    "max_acceleration_deg_s2": "[guard]\nmax_acceleration_deg_s2 = inf\n",
    "max_move_s": "[guard]\nmax_move_s = -1\n",
    "park_deg: expected .*, the limits, got 300": "[guard]\npark_deg = 300\n",
    "wire|nowhere": CAN.format(kind="tb6600", port="nowhere:", more=""),
    "expected can:INTERFACE:CHANNEL": CAN.format(kind="dronecan_servo", port="can:", more=""),
    "interface 'telepathy' cannot be used": CAN.format(kind="dronecan_servo", port="can:telepathy:0", more=""),
    "cannot join the bus": CAN.format(kind="dronecan_servo", port="can:socketcan:can99", more=""),
    "can:socketcan:can99": CAN.format(kind="canopen_drive", port="can:socketcan:can99", more=""),
    "/dev/ttyNOTHING": CAN.format(kind="grbl", port="serial:/dev/ttyNOTHING:115200", more=""),
    "own_node_id|node_id": CAN.format(
        kind="dronecan_servo", port="can:virtual:0", more=", node_id = 5, own_node_id = 5"
    ),
    "expected .*links.*, got none": '[actuator]\nkind = "mavlink_gimbal"\n',
    "limits that meet": '[actuator]\nkind = "ideal"\n[guard]\nlower_deg = 1000\nupper_deg = 1100\npark_deg = 1050\n',
}


@pytest.mark.parametrize("words", CONFIGURATIONS)
def test_a_mistake_in_the_file_is_one_line(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, CONFIGURATIONS[words])
    code, line = ross(monkeypatch, capsys, "actuators", "probe", file, "--move", "--yes")
    assert code == 2
    assert re.search(words, line), line


@pytest.mark.parametrize(("kind", "scheme"), [("tb6600", "pulses"), ("dronecan_servo", "can"), ("ideal", "ideal")])
def test_a_port_where_nobody_or_somebody_else_answers_is_named(
    kind: str, scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        file = written(tmp_path, CAN.format(kind=kind, port=f"{scheme}:tcp:127.0.0.1:{port}", more=""))
        code, line = ross(monkeypatch, capsys, "actuators", "probe", file, "--move", "--yes")
        assert (code, "no greeting" in line) == (2, True), line
    code, line = ross(monkeypatch, capsys, "actuators", "probe", file, "--move", "--yes")
    assert (code, "cannot connect" in line) == (2, True), line


def test_a_line_that_this_user_may_not_open_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    line = tmp_path / "ttyUSB0"
    line.touch(mode=0o000)
    assert not stat.S_IMODE(line.stat().st_mode)
    file = written(tmp_path, CAN.format(kind="grbl", port=f"serial:{line}:115200", more=""))
    code, said = ross(monkeypatch, capsys, "actuators", "probe", file, "--move", "--yes")
    assert code == 2
    assert str(line) in said


def installed(name: str, module: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install a package of others: a back end and its far end of this name in a module; the file that names it."""
    info = folder / f"{name}-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
    points = f"[ross_payload.actuators]\n{name} = {name}:backend\n[ross_sim.far_ends]\n{name} = {name}:far_end\n"
    (info / "entry_points.txt").write_text(points)
    (folder / f"{name}.py").write_text(module)
    monkeypatch.syspath_prepend(folder)
    return written(folder, f'[actuator]\nkind = "{name}"\n')


def test_a_back_end_without_its_extra_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = installed("lacking", "raise ModuleNotFoundError('x', name='can')\n", tmp_path, monkeypatch)
    code, line = ross(monkeypatch, capsys, "actuators", "probe", file)
    assert (code, "pip install 'python-can>=" in line) == (2, True), line


RAISING = """
from ross_payload.config import Table
class backend:
    class Config(Table):
        pass
    def open(*_):
        raise KeyError("resolution")
class far_end:
    def make(*_):
        raise KeyError("friction")
"""


@pytest.mark.parametrize("command", [("actuators", "probe"), ("config", "check")])
def test_a_back_end_that_raises_is_named(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = installed("raising", RAISING, tmp_path, monkeypatch)
    code, line = ross(monkeypatch, capsys, *command, file)
    assert (code, "actuator 'raising': open raised KeyError('resolution')" in line) == (2, True), line


LEAVING = RAISING.replace('KeyError("resolution")', "SystemExit(0)")
LESS = """
from ross_payload.actuators.driver_shell import capabilities_of
from ross_payload.config import Table
class Less:
    command = state = home = release = poll = __enter__ = __exit__ = print
    {more}
class backend:
    {config}
    def open(*_):
        return Less()
"""
TABLE = "class Config(Table): pass"
BROKEN = {
    "leaving": (LEAVING, "actuator 'leaving': open raised SystemExit(0)"),
    "stopless": (
        LESS.format(config=TABLE, more="capabilities = 1"),
        "got Less without stop, capab",
    ),
    "optionless": (
        LESS.format(config="Config = dict", more=""),
        "expected a pydantic model as Config",
    ),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_a_back_end_that_cannot_be_stopped_or_ends_the_program_is_refused(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text, words = BROKEN[kind]
    file = installed(kind, text, tmp_path, monkeypatch)
    code, line = ross(monkeypatch, capsys, "config", "check", file)
    assert (code, words in line) == (2, True), line


def test_a_far_end_that_raises_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = load(installed("toppling", RAISING, tmp_path, monkeypatch))
    with pytest.raises(PluginError, match=r"^far end 'toppling': make raised KeyError\('friction'\)$"):
        far_end_of(config)


def test_the_gimbal_of_an_autopilot_is_not_shown_as_our_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, '[actuator]\nkind = "mavlink_gimbal"\n[gimbal]\nmode = "device"\n')
    code, line = ross(monkeypatch, capsys, "config", "check", file)
    assert code == 2
    assert "gimbal" in line
