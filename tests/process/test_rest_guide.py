"""What the guide to the REST interface shows works as printed, beside a simulated mission; a generated client, too."""

import json
import math
import os
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from urllib.request import Request, urlopen

import pytest

from manual import blocks
from processes import ROSS, program
from ross_sim.scenario import load
from short_mission import ALONE
from waiting import wait_for

PAGE = "docs/how-to/use-the-rest-interface.md"
PRINTED = "http://127.0.0.1:8765"
LIMIT_S = 240.0


def shell(ending):
    """The command of the guide that ends so."""
    lines = [line for one in blocks("sh") if one.page == PAGE for line in one.commands if "Bearer" not in line]
    (found,) = [line for line in lines if line.rstrip("'").endswith(ending)]
    return found


def script(containing):
    (found,) = [one.text for one in blocks("python") if one.page == PAGE and containing in one.text]
    return found


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A simulated payload with a page, and the address of that."""
    folder = tmp_path_factory.mktemp("flown")
    scenario = ALONE.replace("run_s = 1.0", "run_s = 600.0")
    (folder / "short.toml").write_text(scenario)  # one talker, to whom it listens until it is stopped
    # in no hurry: what it simulates while a client is made is for nobody
    options = ["sitl", "--serve", "--page", "--scenario", "short.toml", "--speed", "1", "--seed", "1"]
    environment = {**os.environ, "HOME": str(folder), "PYTHONUNBUFFERED": "1"}
    environment.pop("STATE_DIRECTORY", None)
    with program([*ROSS, *options], folder, env=environment, end=signal.SIGINT) as (_, log):
        url = wait_for(lambda: re.search(r"http://\S+:\d+", log.read_text()), LIMIT_S)[0]
        wait_for(lambda: asked(f"{url}/api/v1/payloads")["payloads"], LIMIT_S)
        yield SimpleNamespace(url=url, base=f"{url}/api/v1", folder=folder, truth=load(folder / "short.toml"))


def told(flown, containing):
    """Run a command of the guide; return the answer."""
    command = [
        "sh",
        "-c",
        shell(containing).replace(PRINTED, flown.url).replace("curl ", "curl --silent --show-error "),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def run(flown, text, *arguments):
    """Run a program of the guide; return the lines that it prints."""
    command = [sys.executable, "-c", text, *arguments]
    done = subprocess.run(command, cwd=flown.folder, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def azimuths(truth):
    """Where the talkers are, degrees clockwise."""
    return sorted(-talker.azimuth_deg % 360 for talker in truth.talkers)


def near(found, truth):
    """Whether somebody is found near everybody there, within 20 deg: half a second of sound tells no more."""
    apart = [[abs((one - other + 180) % 360 - 180) for one in found] for other in azimuths(truth)]
    return all(min(each, default=math.inf) < 20 for each in apart)


@contextmanager
def following(flown):
    """The command of the guide that follows events, as it goes on."""
    command = shell("/events").replace(PRINTED, flown.url).replace("curl ", "exec curl --silent ")
    with subprocess.Popen(["sh", "-c", command], stdout=subprocess.PIPE, text=True) as curl:
        try:
            yield curl
        finally:
            curl.kill()


def test_the_commands_of_the_guide_see_turn_set_and_stop(flown):
    assert [each["id"] for each in told(flown, "8765/api/v1/payloads")["payloads"]] == ["1-191"]
    assert told(flown, "/payloads/1-191")["standing"]["who"] == "1-191"
    assert told(flown, "/sources")["sources"] == []
    with following(flown) as curl:
        turned = told(flown, "orders?wait=30")
        assert (turned["words"], turned["state"]) == ("turn to 20 deg", "done")
        assert told(flown, "/payloads/1-191")["pointing"]["heading"] == pytest.approx(20, abs=1)
        assert told(flown, "EXP_UNIT")["value"] == 2.5
        stopped = [told(flown, "1-191/stop"), *told(flown, "v1/stop")["orders"]]
        assert [each["words"] for each in stopped] == ["stop", "stop"]
        while not (line := curl.stdout.readline()).startswith("event: OrderStatus"):
            assert line, "the events have ended"


def test_the_printed_answers_have_the_fields_of_true_ones(flown):
    order, problem = (json.loads(one.text) for one in blocks("json") if one.page == PAGE)
    assert order.keys() == told(flown, "1-191/stop").keys()
    wrong = json.dumps({"kind": "turn", "heading": 400})
    command = ["curl", "--silent", "--json", wrong, f"{flown.base}/payloads/1-191/orders"]
    assert json.loads(subprocess.run(command, capture_output=True, check=True).stdout) == problem


@pytest.mark.soak
def test_a_generated_client_flies_a_mission(flown):
    command = shell("ross_ground_client").replace(PRINTED, flown.url)
    programs = Path(sys.executable).parent
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    made = subprocess.run(
        [*command.split(), "--fail-on-warning"], cwd=flown.folder, env=environment, capture_output=True, text=True,
        timeout=LIMIT_S, check=False,
    )  # fmt: skip
    assert made.returncode == 0, made.stdout + made.stderr
    again(flown)
    lines = run(flown, script("ross_ground_client"), flown.base)
    assert lines[0] == "EXP_UNIT 1.0"
    assert lines[1] == "explore: done"
    found = [float(word) for word in next(line for line in lines if line.startswith("sources at")).split()[2:-1]]
    assert near(found, flown.truth), lines
    assert lines[3] == "listen to source 0: in_progress"
    assert lines[4:] == [
        "stop", "cancelled", "turn to 10 deg was refused: stopped: re-arm first", "rearm: done", "park: done",
        "heading 0",
    ]  # fmt: skip


def test_the_program_of_the_guide_finds_everybody(flown):
    again(flown)
    lines = run(flown, script("urlopen"), flown.base)
    assert lines[-len(flown.truth.talkers) - 1].startswith("explore done")
    assert near([float(line.split()[-2]) for line in lines if line.startswith("source ")], flown.truth), lines


def asked(url, **fields):
    """Ask without a program of its own."""
    body = json.dumps(fields).encode() if fields else None
    with urlopen(Request(url, body, {"Content-Type": "application/json"})) as answer:  # noqa: S310
        return json.load(answer)


def again(flown):
    """Let the payload move again, after whatever was tried before."""
    done = asked(f"{flown.base}/payloads/1-191/orders?wait=30", kind="rearm")
    assert done["state"] == "done", done
