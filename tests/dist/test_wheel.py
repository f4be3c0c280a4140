"""What is published works away from the checkout."""

import json
import os
import re
import signal
import subprocess
import sys
import sysconfig
import venv
import zipfile
from contextlib import closing
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from ports import free_port
from short_mission import CHEAP, SOON, brief

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.soak  # what only a release builds


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """An empty environment with the wheel in it; its dependencies are lent by the environment of the tests."""
    folder = tmp_path_factory.mktemp("venv")
    venv.create(folder)
    pip = [sys.executable, "-m", "pip", "--python", folder / "bin" / "python"]
    command = [*pip, "install", "--quiet", "--no-deps", "--no-index", wheel]
    subprocess.run(command, check=True, capture_output=True)
    site = next(folder.glob("lib/python*/site-packages"))
    (site / "lent.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
    return folder


def test_the_wheel_holds_three_packages_and_their_data(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {
        "ross_payload",
        "ross_protocols",
        "ross_sim",
    }
    assert "ross_protocols/data/mavlink/ross.xml" in names
    assert "ross_protocols/data/canopen/ross_drive.eds" in names
    assert "ross_protocols/data/dronecan/ross/20854.Status.uavcan" in names
    assert "ross_sim/data/scenarios/demo.toml" in names
    assert "ross_payload/py.typed" in names
    assert "ross_payload/data/examples/ross.service" in names
    web = ROOT / "ross_payload" / "ground" / "web"
    page = {path.relative_to(ROOT).as_posix() for path in (*web.glob("*.html"), *web.glob("assets/**/*.*"))}
    assert "ross_payload/ground/web/assets/templates.js" in page
    assert page <= set(names)


def test_the_installed_command_flies_a_mission_outside_the_checkout(installed, tmp_path):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    asked = brief("one-talker", tmp_path, explore=SOON, check_s=1.0, run_s=2.0, **CHEAP)
    command = [installed / "bin" / "ross", "sitl", "--scenario", asked, "--informed", "--json", "--out", "results"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=250
    )
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "results" / "report.json").read_text())["outcome"] == "target_found"
    where = [installed / "bin" / "python", "-c", "import ross_payload; print(ross_payload.__file__)"]
    found = subprocess.run(where, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True).stdout
    assert Path(found.strip()).is_relative_to(installed)


def test_the_installed_ground_serves_its_page_outside_the_checkout(installed, tmp_path):
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [installed / "bin" / "ross", "ground", f"udpin:127.0.0.1:{free_port()}", "--port", "0"]
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True) as ground:
        try:
            url = ground.stdout.readline().split()[2]
            host = urlsplit(url).netloc
            page = got(host, "/")
            assert page.startswith("<!doctype html>")
            for asset in (*re.findall(r'(?:src|href)="(/assets/[^"]+)"', page), "/assets/app.js"):
                assert got(host, asset), asset
        finally:
            ground.send_signal(signal.SIGINT)
    assert ground.returncode == 0


def got(host, path):
    """The text at a path."""
    with closing(HTTPConnection(host)) as connection:
        connection.request("GET", path)
        answer = connection.getresponse()
        assert answer.status == 200, path
        return answer.read().decode()
