"""The extension of BlueOS in one process tree: its front page, and the two programs behind it."""

import importlib.util
import json
import os
import sys
from contextlib import closing, suppress
from functools import partial
from http.client import HTTPConnection
from http.server import ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
import soundfile

from ports import free_port
from processes import program
from waiting import wait_for

START = Path(__file__).parents[2] / "docs" / "deploy" / "blueos" / "start.py"
METADATA = ("name", "description", "icon", "company", "version", "webpage", "api")  # that BlueOS' helper asks for
CONFIG = """
[audio]
source = "file:{folder}/noise.wav"
[actuator]
kind = "tb6600"
[[links]]
url = "udpout:127.0.0.1:{port}"
"""


def answered(port, path):
    """The status and the text that a server of this computer answers."""
    with closing(HTTPConnection("127.0.0.1", port, timeout=10)) as connection:
        connection.request("GET", path)
        answer = connection.getresponse()
        return answer.status, answer.read().decode()


@pytest.fixture
def extension(tmp_path, monkeypatch):
    """What has an extension run in a folder, without a configuration; and what asks its front page."""
    front, telemetry = free_port(), free_port()
    places = {"ROSS_CONFIG": tmp_path / "ross.toml", "STATE_DIRECTORY": tmp_path / "state", "ROSS_HOST": "127.0.0.1"}
    ports = {"ROSS_FRONT_PORT": front, "ROSS_PAGE_PORT": free_port(), "ROSS_TELEMETRY": f"udpin:127.0.0.1:{telemetry}"}
    for name, value in (places | ports).items():
        monkeypatch.setenv(name, str(value))
    (tmp_path / "state").mkdir()
    soundfile.write(tmp_path / "noise.wav", np.random.default_rng(0).normal(0, 0.01, (16000 * 40, 2)), 16000)

    def asked(path, port=front):
        with suppress(OSError):
            return answered(port, path)
        return 0, ""

    return program([sys.executable, START], tmp_path), asked, CONFIG.format(folder=tmp_path, port=telemetry)


@pytest.mark.soak
def test_blueos_finds_it_and_with_its_configuration_it_runs(extension, tmp_path):
    running, asked, config = extension
    file = Path(os.environ["ROSS_CONFIG"])
    with running:
        wait_for(lambda: asked("/")[0] == 200)
        assert set(METADATA) <= set(json.loads(asked("/register_service")[1]))
        assert asked("/icon.svg")[1].startswith("<svg")
        assert asked("/../etc/passwd")[0] == 404
        assert asked("/well") == (200, f"There is no {file} yet.")
        file.write_text(config)
        wait_for(lambda: asked("/well") == (200, "idle"))
        wait_for(lambda: asked("/", int(os.environ["ROSS_PAGE_PORT"]))[0] == 401)  # nobody without the token
    token = tmp_path / "state" / "page-token"
    assert token.stat().st_mode & 0o777 == 0o600
    assert not (tmp_path / "state" / "health").exists()  # the payload has ended in good order


@pytest.fixture
def start(monkeypatch):
    """The program of the extension as a module, on a clock that a test sets."""
    spec = importlib.util.spec_from_file_location("blueos_start", START)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "monotonic", lambda: module.now)
    module.now = 100.0
    return module


def test_the_token_of_the_page_is_made_once_and_for_its_owner_alone(start, tmp_path):
    settings = start.Settings(state=tmp_path)
    token = start.token_file(settings)
    assert token.stat().st_mode & 0o777 == 0o600
    before = token.read_text()
    assert start.token_file(settings).read_text() == before
    command = start.Extension(settings).page._command
    assert command[command.index("--token-file") + 1] == str(token)  # nobody gets in without it


def test_blueos_finds_the_front_page(start, tmp_path):
    extension = start.Extension(start.Settings(config=tmp_path / "ross.toml", state=tmp_path))
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(start.Front, extension)) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        asked = partial(answered, server.server_port)
        assert asked("/")[0] == 200
        assert set(METADATA) <= set(json.loads(asked("/register_service")[1]))
        assert asked("/icon.svg")[1].startswith("<svg")
        assert asked("/../etc/passwd")[0] == 404
        assert asked("/well") == (200, f"There is no {tmp_path / 'ross.toml'} yet.")
        server.shutdown()


@pytest.fixture
def starts(start, tmp_path):
    """How often a program that refuses its file has been started after another look, so many seconds later."""
    file, noted = tmp_path / "ross.toml", tmp_path / "noted"
    file.touch()
    child = start.Child(["sh", "-c", f"echo >> {noted}; exit 2"], file)

    def after(seconds):
        start.now += seconds
        child.look()
        if child._process is not None:
            child._process.wait()
            child.look()  # it has ended
        return len(noted.read_text()) if noted.exists() else 0

    return after, file


def test_the_front_page_says_that_the_configuration_is_refused(start, tmp_path):
    file = tmp_path / "ross.toml"
    file.write_text("[audio")
    extension = start.Extension(start.Settings(config=file, state=tmp_path))
    extension.payload = start.Child(["sh", "-c", "exit 2"], file)
    extension.payload.look()
    extension.payload._process.wait()
    extension.payload.look()
    well, state, advice = extension.told()
    assert (well, state) == (True, "The payload refuses its configuration.")  # well: a restart would not mend it
    assert str(file) in advice


def test_what_refuses_its_file_is_not_started_again_and_again(starts):
    after, _ = starts
    assert [after(seconds) for seconds in (0, 2, 2, 55)] == [1, 1, 1, 1]


def test_what_it_refused_may_be_a_device_that_comes_later(starts):
    after, _ = starts
    assert [after(seconds) for seconds in (0, 59, 2)] == [1, 1, 2]


def test_a_changed_file_is_tried_soon(starts):
    after, file = starts
    assert after(0) == 1
    os.utime(file, ns=(1, 1))
    assert after(2) == 2
