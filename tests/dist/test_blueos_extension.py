"""The extension of BlueOS in one process tree: its front page, and the two programs behind it."""

import json
import os
import sys
from contextlib import closing, suppress
from http.client import HTTPConnection
from pathlib import Path

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


@pytest.fixture
def extension(tmp_path, monkeypatch):
    """What has an extension run in a folder, without a configuration; and what asks its front page."""
    front, telemetry = free_port(), free_port()
    places = {"ROSS_CONFIG": tmp_path / "ross.toml", "STATE_DIRECTORY": tmp_path / "state", "ROSS_HOST": "127.0.0.1"}
    ports = {"ROSS_FRONT_PORT": front, "ROSS_PAGE_PORT": free_port(), "ROSS_TELEMETRY": f"udpin:127.0.0.1:{telemetry}"}
    for name, value in (places | ports).items():
        monkeypatch.setenv(name, str(value))
    (tmp_path / "state").mkdir()
    soundfile.write(tmp_path / "noise.wav", np.random.default_rng(0).normal(0, 0.01, (16000 * 60, 2)), 16000)

    def asked(path, port=front):
        with closing(HTTPConnection("127.0.0.1", port, timeout=10)) as connection, suppress(OSError):
            connection.request("GET", path)
            answer = connection.getresponse()
            return answer.status, answer.read().decode()
        return 0, ""

    return program([sys.executable, START], tmp_path), asked, CONFIG.format(folder=tmp_path, port=telemetry)


def test_blueos_finds_it_and_it_waits_for_its_configuration_and_runs(extension, tmp_path):
    running, asked, config = extension
    file = Path(os.environ["ROSS_CONFIG"])
    with running:
        wait_for(lambda: asked("/")[0] == 200)
        assert set(METADATA) <= set(json.loads(asked("/register_service")[1]))
        assert asked("/icon.svg")[1].startswith("<svg")
        assert asked("/../etc/passwd")[0] == 404
        assert asked("/well") == (200, f"There is no {file} yet.")
        file.write_text("[audio")  # a mistake, which starting it again would not mend
        wait_for(lambda: asked("/well") == (200, "The payload refuses its configuration."))
        file.write_text(config)
        wait_for(lambda: asked("/well") == (200, "idle"))
        wait_for(lambda: asked("/", int(os.environ["ROSS_PAGE_PORT"]))[0] == 401)  # nobody without the token
    token = tmp_path / "state" / "page-token"
    assert token.stat().st_mode & 0o777 == 0o600
    assert not (tmp_path / "state" / "health").exists()  # the payload has ended in good order
