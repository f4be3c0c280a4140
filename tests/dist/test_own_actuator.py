"""'Add your own actuator', followed to the letter: its files, its commands, its claims."""

import math
import re
from types import SimpleNamespace

import pytest

from own_actuator import ROOT
from own_plugin import run
from short_mission import ALONE


def test_it_is_in_the_list(folder):
    listed = run(folder, "ross_payload.cli", "actuators").stdout
    assert re.search(r"^my_turntable +usable +Turntable with a text protocol", listed, re.MULTILINE)


@pytest.mark.soak
def test_a_mission_turns_it(folder):
    (folder / "short.toml").write_text(ALONE)
    flown = run(folder, "ross_payload.cli", "sitl", "--scenario", "short.toml", "--actuator", "my_turntable")
    assert flown.returncode in {0, 3}, flown.stderr
    assert "fault" not in flown.stdout.lower()


def test_a_line_that_began_before_it_was_opened_is_no_fault(folder):
    written = {}
    exec((folder / "my_turntable" / "driver.py").read_text(), written)  # noqa: S102  # the page's own text
    arrived = [b"4.2 3.5\nA 14.2 0.0\nA 14", b".2 0.0\n"]
    wire = SimpleNamespace(receive=lambda: arrived, send=None, close=None)
    driver = written["backend"].driver(written["Options"]())
    for _ in range(2):  # also when it is opened again
        driver.open(wire, 0.0)
        driver.read(0.01)
        state = driver.snapshot(0.01)
        assert (state.fault, state.settled, state.angle) == ("", True, pytest.approx(math.radians(14.2)))


def test_it_keeps_the_contract(folder):
    command = ["pytest", "-q", "-p", "no:cacheprovider", "tests/contract/test_actuator.py"]
    held = run(folder, *command, "--actuator-kind", "my_turntable", cwd=ROOT)
    assert held.returncode == 0, held.stdout
    assert int(re.search(r"(\d+) passed", held.stdout)[1]) > 20


@pytest.mark.soak
def test_a_driver_that_breaks_a_rule_does_not_keep_the_contract(folder, tmp_path):
    broken = tmp_path / "site"
    broken.mkdir()
    for path in (folder / "site").rglob("*"):
        target = broken / path.relative_to(folder / "site")
        target.mkdir(exist_ok=True) if path.is_dir() else target.write_bytes(path.read_bytes())
    driver = broken / "my_turntable" / "driver.py"
    driver.write_text(driver.read_text().replace("rate == 0.0 and there", "True"))
    command = ["pytest", "-q", "-p", "no:cacheprovider", "tests/contract/test_actuator.py", "-k", "not_settled_between"]
    held = run(tmp_path, *command, "--actuator-kind", "my_turntable", cwd=ROOT)
    assert held.returncode == 1, held.stdout
