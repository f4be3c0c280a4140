"""``ross mavproxy``: MAVProxy with our module beside a payload, directly and behind an autopilot."""

import subprocess
import sys
from contextlib import ExitStack

import pytest

from mavproxy_prompt import mavproxy, need_mavproxy
from ross_payload.plugins import pip

pytestmark = pytest.mark.process
SCENARIO = """
title = "a payload under a vehicle"
[payload.telemetry]
system_id = 0
[[payload.links]]
url = "udpout:127.0.0.1:{port}"
role = "autopilot"
[noise]
snr_db = 25
[[talkers]]
azimuth_deg = 40.0
"""
SYSTEM = 7


def started(port, folder):
    ours = ["-m", "ross_payload.cli", "mavproxy", f"--master=udpin:127.0.0.1:{port}"]
    return mavproxy([*ours, "--default-modules", "link,cmdlong"], folder)


@pytest.fixture(scope="module")
def prompt(ross_run, free_port, tmp_path_factory):
    folder, port = tmp_path_factory.mktemp("direct"), free_port()
    with ross_run(folder, f'url = "udpout:127.0.0.1:{port}"'), started(port, folder) as prompt:
        prompt.asks("ross status", r"RoSS 1-191  \w+")
        yield prompt


@pytest.fixture(scope="module")
def behind(living, free_port, tmp_path_factory):
    """A prompt on the far side of an autopilot that passes no message of ours on, but for TUNNEL."""
    folder, ground, port = tmp_path_factory.mktemp("behind"), free_port(), free_port()
    (folder / "scenario.toml").write_text(SCENARIO.format(port=port))
    links = ["--link", f"udpin:127.0.0.1:{port}", "--link", f"udpout:127.0.0.1:{ground}"]
    with ExitStack() as stack:
        stack.enter_context(living(["autopilot", *links, "--system-id", str(SYSTEM)], folder / "autopilot", code=130))
        serve = ["sitl", "--serve", "--json", "--scenario", folder / "scenario.toml"]
        stack.enter_context(living(serve, folder / "payload"))
        yield stack.enter_context(started(ground, folder))


def test_the_module_is_loaded_and_helps(prompt):
    assert "Loaded module ross_payload.ground.mavproxy.mavproxy_ross" in prompt.said()
    prompt.read(r"ross listen voice\|SOURCE\|azimuth DEG", prompt.type("ross help"))


def test_status_says_state_and_health(prompt):
    place = prompt.type("ross status")
    prompt.read(r"RoSS 1-191  \w+.* last telemetry \d", place)
    prompt.read(r"axis [-\d.]+ deg, from the nose", place)
    place = prompt.type("ross status")
    while prompt.read(r"microphones +(both|no data)", place)[1] == "no data":  # it tells every second
        place = prompt.type("ross status")
    prompt.read(r"ok microphones +both receive sound", place)


def test_a_stop_a_refusal_with_its_reason_and_rearming_are_said(prompt):
    prompt.read("RoSS 1-191 stop: done", prompt.type("ross stop"))
    place = prompt.type("ross turn 20")
    prompt.read("RoSS 1-191 turn to 20 deg: refused: stopped: re-arm first", place)
    prompt.read("RoSS 1-191 rearm: done", prompt.type("ross rearm"))


def test_a_mistake_is_one_line(prompt):
    place = prompt.type("ross turn around")
    prompt.read("ross: expected a number, got 'around'", place)


def test_a_recording_is_begun_and_ended(prompt):
    prompt.read("RoSS 1-191 start recording: done", prompt.type("ross record on"))
    prompt.read("RoSS 1-191 stop recording: done", prompt.type("ross record off"))


@pytest.mark.soak
def test_behind_an_autopilot_tunnels_are_read_and_orders_arrive(behind):
    behind.asks("ross status", rf"RoSS {SYSTEM}-191  \w+")
    behind.asks("ross status", "ok microphones")
    behind.read(rf"RoSS {SYSTEM}-191 turn to 15 deg: (acknowledged|in progress)", behind.type("ross turn 15"))
    behind.read(rf"RoSS {SYSTEM}-191 stop: done", behind.type("ross stop"))
    behind.read(rf"RoSS {SYSTEM}-191 rearm: done", behind.type("ross rearm"))


def test_without_mavproxy_one_line_says_what_to_install(tmp_path):
    """As where it is not installed: its name leads nowhere."""
    blind = "import sys; sys.modules['MAVProxy'] = None; from ross_payload.cli import main; main()"
    command = [sys.executable, "-c", blind, "mavproxy"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert done.stderr == f"ross: MAVProxy is not installed here: {pip()} install mavproxy\n"


COMPLETE = """
from types import SimpleNamespace
from MAVProxy.modules.lib import rline
from ross_payload.ground.mavproxy.shell import COMPLETIONS
rline.rline_mpstate = SimpleNamespace(completion_functions={})
for words in (["st"], ["listen", ""], ["record", "o"]):
    print(*rline.complete_rules(COMPLETIONS, words))
"""


@pytest.mark.soak
def test_mavproxy_completes_our_words():
    need_mavproxy()
    command = [sys.executable, "-W", "ignore", "-c", COMPLETE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    first, listen, record = [line.split() for line in done.stdout.splitlines()]
    assert {"status", "stop", "listen", "record"} <= set(first)  # MAVProxy itself leaves out what does not fit
    assert set(listen) == {"voice", "azimuth"}
    assert set(record) == {"on", "off"}
