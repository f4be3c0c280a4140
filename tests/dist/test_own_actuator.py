"""'Add your own actuator', followed to the letter: its files, its commands, its claims."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from short_mission import SHORT

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "how-to" / "add-your-own-actuator.md"
FILE = re.compile(r"```(?:python|toml)\n# (?P<name>\S+)\n(?P<text>.*?)```", re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The files of the page, and the package installed beside them."""
    folder = tmp_path_factory.mktemp("own")
    files = dict(FILE.findall(PAGE.read_text()))
    assert set(files) == {"pyproject.toml", "my_turntable/driver.py", "my_turntable/device.py", "bench.toml"}
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    (folder / "my_turntable" / "__init__.py").touch()
    options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", "--target", folder / "site"]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, folder], check=True, capture_output=True)
    return folder


def run(folder, *command, cwd=None, timeout=250):
    environment = os.environ | {"PYTHONPATH": str(folder / "site"), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, "-m", *map(str, command)],
        cwd=cwd or folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False,
    )  # fmt: skip


def test_it_is_in_the_list(folder):
    listed = run(folder, "ross_payload.cli", "actuators").stdout
    assert re.search(r"^my_turntable +usable +Turntable with a text protocol", listed, re.MULTILINE)


def test_a_mission_turns_it(folder):
    (folder / "short.toml").write_text(SHORT)
    flown = run(folder, "ross_payload.cli", "sitl", "--scenario", "short.toml", "--actuator", "my_turntable")
    assert flown.returncode in {0, 3}, flown.stderr
    assert "fault" not in flown.stdout.lower()


def test_it_keeps_the_contract(folder):
    command = ["pytest", "-q", "-p", "no:cacheprovider", "tests/contract/test_actuator.py"]
    held = run(folder, *command, "--actuator-kind", "my_turntable", cwd=ROOT)
    assert held.returncode == 0, held.stdout
    assert int(re.search(r"(\d+) passed", held.stdout)[1]) > 30


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


def test_the_probe_looks_at_one_in_another_process(folder):
    environment = os.environ | {"PYTHONPATH": str(folder / "site")}
    world = [sys.executable, "-m", "ross_payload.cli", "world", "--actuator", "my_turntable", "--start", "now"]
    (folder / "short.toml").write_text(SHORT)
    command = [*world[:4], "short.toml", *world[4:]]
    with subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, text=True) as serving:
        try:
            port = next(found[1] for line in serving.stdout if (found := re.search(r'port = "(serial:.+)"', line)))
            text = (folder / "bench.toml").read_text().replace("serial:/dev/ttyUSB0:115200", port)
            (folder / "served.toml").write_text(text)
            probed = run(folder, "ross_payload.cli", "actuators", "probe", "served.toml", "--move", "--yes")
        finally:
            serving.terminate()
            serving.wait(60)
    assert probed.returncode in {0, 1}, probed.stdout + probed.stderr
    assert "it turns the way it is commanded" in probed.stdout
