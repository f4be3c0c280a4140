"""What packages and images are made of, held to what the payload says of itself; the whole is built in soak tests."""

import importlib.util
import os
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

from ross_payload.actuators.tb6600.pulse_segments import RECORDING
from ross_payload.service.check import loaded

ROOT = Path(__file__).parents[2]
DEPLOY = ROOT / "docs" / "deploy"
MAINTAINER = [f"debian/ross-payload.{name}" for name in ("postinst", "prerm", "postrm")]
SCRIPTS = [*(path.name for path in DEPLOY.glob("*.sh")), *MAINTAINER]


@pytest.fixture(scope="module")
def environment():
    spec = importlib.util.spec_from_file_location("environment", DEPLOY / "environment.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def made(folder, *paths):
    for path in paths:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(path)


def files(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_shell_can_read_the_script(script):
    checked = subprocess.run(["sh", "-n", DEPLOY / script], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stderr


def test_with_the_configuration_of_the_package_nothing_turns_and_nobody_can_reach_it():
    config = loaded(DEPLOY / "debian" / "ross.toml")
    assert (config.actuator.kind, config.actuator.options.get("port", RECORDING)) == ("tb6600", RECORDING)
    assert config.service.autostart == "nothing"
    assert all(link.url.startswith("udpout:127.0.0.1:") for link in config.links)


def test_the_package_keeps_its_state_where_the_unit_has_it_kept():
    folder = re.search(r"(?m)^StateDirectory=(.*)", (ROOT / "docs/examples/ross.service").read_text())[1]
    assert loaded(DEPLOY / "debian" / "ross.toml").service.state_dir == f"/var/lib/{folder}"
    for script in ("postinst", "postrm"):
        assert f"/var/lib/{folder}" in (DEPLOY / f"debian/ross-payload.{script}").read_text()


def test_the_rules_of_the_package_are_those_of_the_example_without_numbers_of_single_devices():
    example = (ROOT / "docs/examples/99-ross.rules").read_text().splitlines()
    rules = (DEPLOY / "debian/ross-payload.ross.udev").read_text().splitlines()
    chosen = [line for line in rules if not line.startswith("#")]
    assert chosen
    assert set(chosen) <= set(example)
    assert not any("serial" in line or "KERNELS" in line for line in chosen)


def test_the_package_has_every_example_that_the_manual_speaks_of():
    command = ["make", "--dry-run", "--file", "docs/deploy/debian/rules", "override_dh_installexamples"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    examples = {f"docs/examples/{path.name}" for path in (ROOT / "docs/examples").iterdir() if path.is_file()}
    assert examples - set(told) == {"docs/examples/ross.service"}  # which is installed as the service


def test_tests_stubs_and_foreign_dialects_are_left_out_and_our_data_stay(environment, tmp_path):
    kept = {"numpy/a.py", "pymavlink/dialects/v20/common.py", "pymavlink/dialects/v20/__init__.py", "scipy/io/b.py"}
    kept |= {"ross_protocols/data/mavlink/ross.xml", "ross_protocols/data/x.h", "a.dist-info/METADATA"}
    gone = {"numpy/tests/t.py", "numpy/a.pyi", "numpy/core/include/a.h", "a.dist-info/direct_url.json"}
    gone |= {"pymavlink/dialects/v10/common.py", "pymavlink/dialects/v20/all.py", "pymavlink/dialects/v20/common.xml"}
    made(tmp_path, *kept, *gone)
    environment.prune(tmp_path, ())
    assert files(tmp_path) == kept
    environment.prune(tmp_path, environment.SMALLEST)
    assert files(tmp_path) == kept - {"scipy/io/b.py"}


def test_a_package_that_is_built_after_a_release_has_its_hash_among_the_others(tmp_path):
    tools, dist = tmp_path / "tools", tmp_path / "dist"
    made(tools, "dh")
    (tools / "tar").write_text("#!/bin/sh\n")  # of the whole tree
    (tools / "dpkg-buildpackage").write_text("#!/bin/sh\necho new > ../ross-payload_1+deb12_amd64.deb\n")
    for tool in tools.iterdir():
        tool.chmod(0o755)
    made(dist, "ross_payload-1.tar.gz")
    listed = subprocess.run(
        ["sha256sum", "ross_payload-1.tar.gz"], cwd=dist, capture_output=True, text=True, check=True
    )
    (dist / "SHA256SUMS").write_text(listed.stdout + "0  ross-payload_1+deb12_amd64.deb\n")
    path = f"{tools}:{os.environ['PATH']}"
    subprocess.run(["sh", DEPLOY / "build-deb.sh", dist], env=os.environ | {"PATH": path}, check=True)
    subprocess.run(["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=dist, check=True)
    assert [line.split()[1] for line in (dist / "SHA256SUMS").read_text().splitlines()] == [
        "ross_payload-1.tar.gz", "ross-payload_1+deb12_amd64.deb"
    ]  # fmt: skip
    assert files(dist) == {"SHA256SUMS", "ross_payload-1.tar.gz", "ross-payload_1+deb12_amd64.deb"}


def test_the_environment_starts_at_its_place_and_names_no_other(environment, tmp_path):
    made(tmp_path, "bin/ross", "bin/f2py", "bin/activate", "bin/python3")
    (tmp_path / "pyvenv.cfg").write_text(f"home = /usr/bin\ncommand = /usr/bin/python3 -m venv {tmp_path}\n")
    environment.settle(tmp_path, Path("/opt/ross"))
    assert files(tmp_path) == {"bin/ross", "bin/python3", "pyvenv.cfg"}
    assert (tmp_path / "bin/ross").read_text().startswith("#!/opt/ross/bin/python\n")
    assert (tmp_path / "pyvenv.cfg").read_text() == "home = /usr/bin\n"


def test_the_page_on_installing_names_every_extra():
    page = (ROOT / "docs/how-to/install.md").read_text()
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert set(re.findall(r"(?m)^\| `(\w+)` \|", page)) == set(extras)


@pytest.mark.parametrize("file", ["docs/how-to/container.md", "docs/deploy/compose.yaml"])
def test_a_wrong_configuration_is_not_restarted_without_end(file):
    """A container engine cannot be told to leave exit code 2 alone."""
    policies = re.findall(r"(?m)(?:--restart|^ *restart:) (\S+)", (ROOT / file).read_text())
    assert policies
    assert all(re.fullmatch(r"on-failure:\d+`[.;]?|on-failure:\d+", policy) for policy in policies), policies


def test_every_dialect_that_is_imported_stays(environment):
    sources = (
        path.read_text()
        for name in ("ross_payload", "sim", "protocols/ross_protocols")
        for path in (ROOT / name).rglob("*.py")
    )
    found = {name for text in sources for name in re.findall(r"from pymavlink\.dialects\.v20 import (\w+)", text)}
    assert {f"{name}.py" for name in found} | {"__init__.py"} == set(environment.DIALECTS)
