"""MAVProxy, without a terminal, beside a payload in another process."""

import sys
from pathlib import Path

import pytest

from mavproxy_prompt import mavproxy
from ross_payload.config.parameter_table import TABLE
from waiting import wait_for

pytestmark = pytest.mark.process
MAVPROXY = Path(sys.executable).with_name("mavproxy.py")
LAUNCHER = "runpy"  # what tells its block of the guide from others


def started(launcher, port, folder):
    arguments = ["-c", launcher, MAVPROXY, "--master", f"udpin:127.0.0.1:{port}"]
    arguments += ["--target-system", "1", "--target-component", "191", "--default-modules", "link,param,cmdlong,log"]
    return mavproxy(arguments, folder)


@pytest.fixture(scope="module")
def payload(ross_run, free_port, tmp_path_factory):
    port = free_port()
    with ross_run(tmp_path_factory.mktemp("mavproxy"), f'url = "udpout:127.0.0.1:{port}"') as payload:
        payload.port = port
        yield payload


@pytest.fixture(scope="module")
def prompt(payload, guide):
    with started(guide(LAUNCHER), payload.port, payload.folder) as prompt:
        yield prompt


def test_it_links_up_and_fetches_the_parameters(prompt):
    prompt.read(r"Detected vehicle 1:191 on link 0")
    prompt.read(rf"Received {len(TABLE)} parameters")
    prompt.type("param show EXP*")
    prompt.read(r"EXP_LEAD_IN +2\.0")


def test_what_it_writes_is_kept(prompt, payload):
    prompt.read(rf"Received {len(TABLE)} parameters")
    prompt.type("param set XPL_RUNS 3")
    wait_for(lambda: payload.kept() == {"XPL_RUNS": 3.0})


def test_it_prints_our_messages(prompt):
    prompt.read(r"Detected vehicle")
    prompt.type("watch ROSS_STATUS")
    prompt.read(r"< ROSS_STATUS \{time_usec : \d+, mission_time : \d+, state : \d+, outcome : 255, frame : 2")
    prompt.type("watch")


def test_its_commands_are_obeyed_by_name_and_the_texts_are_shown(prompt, payload):
    prompt.read(r"Detected vehicle")
    prompt.type("long ROSS_STOP")
    prompt.read(r"Got COMMAND_ACK: ROSS_STOP: ACCEPTED")
    prompt.type("long ROSS_EXPLORE")
    prompt.read(r"Got COMMAND_ACK: ROSS_EXPLORE: TEMPORARILY_REJECTED")
    prompt.read(r"AP: RoSS: explore refused: stopped: re-arm first")
    prompt.type("long ROSS_REARM")
    prompt.read(r"Got COMMAND_ACK: ROSS_REARM: ACCEPTED")
    wait_for(lambda: payload.lines()[-1] if "stopped: stopped by command" in payload.lines() else None)
