"""`ross sitl --serve`: a payload that lives on its sockets, for a ground station that is not ours."""

import asyncio
import io
import json
import os
import signal
import stat
import subprocess
import sys
import time
import zipfile
from contextlib import contextmanager
from pathlib import Path

import aiohttp
import pytest
import soundfile
from pymavlink import mavutil

from ground_page import browser
from processes import ROSS, program
from ross_sim.scenario import load
from ross_sim.sitl.serve import linked
from waiting import wait_for

EXPLORE, RECORD = 54000, 54008
ACCEPTED, IN_PROGRESS = 0, 5


@contextmanager
def serving(scenario, *arguments):
    """A served payload and the ground station that it speaks to."""
    ground = mavutil.mavudp("127.0.0.1:0", input=True, source_system=255)
    try:
        url = f"udpout:127.0.0.1:{ground.port.getsockname()[1]}"
        command = [*ROSS, "sitl", "--serve", "--scenario", scenario]
        command += ["--telemetry", url, "--speed", "4", "--json", *arguments]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as payload:
            try:
                yield payload, ground
            finally:
                payload.send_signal(signal.SIGINT)
                payload.said, payload.erred = payload.communicate(timeout=60)
                sys.stderr.write(payload.erred)  # for whom a test fails
    finally:
        ground.close()


def wait(ground, kind, fits=lambda message: True, seconds=60):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        message = ground.recv_match(type=kind, blocking=True, timeout=1)
        if message is not None and fits(message):
            return message
    raise AssertionError(f"no such {kind} in {seconds} s")


def order(ground, number, *values):
    filled = [*values, *[0] * (7 - len(values))]
    ground.mav.command_long_send(1, 191, number, 0, *filled)
    return wait(ground, "COMMAND_ACK", lambda ack: ack.command == number).result


def test_it_idles_until_ordered_explores_and_ends_with_the_truth(short, tmp_path):
    out = tmp_path / "out"
    with serving(short, "--out", out) as (payload, ground):
        heartbeat = wait(ground, "HEARTBEAT", lambda message: message.get_srcComponent() == 191)
        assert heartbeat.custom_mode == 0
        assert order(ground, EXPLORE) == IN_PROGRESS
        wait(ground, "COMMAND_ACK", lambda ack: (ack.command, ack.result) == (EXPLORE, ACCEPTED))
        heartbeat = wait(ground, "HEARTBEAT", lambda message: message.get_srcComponent() == 191)
        assert payload.poll() is None
    assert (payload.returncode, payload.erred) == (0, "")
    truth = json.loads((out / "truth.json").read_text())
    assert max(angle for _, angle in truth["headings_deg"]) > 10
    assert soundfile.info(out / "mixture.wav").frames == truth["samples"]


SLOW = """
import sys, time
from ross_payload import cli
from ross_payload.service.runner import Runner
from ross_sim.sitl.ground_truth import TruthWriter
run, finish = Runner.run, TruthWriter.finish
def running(runner):
    print("running", file=sys.stderr, flush=True)
    return run(runner)
def slowly(*those):
    print("finishing", file=sys.stderr, flush=True)
    time.sleep(1.0)
    finish(*those)
Runner.run, TruthWriter.finish = running, slowly
sys.argv[0] = "ross"
cli.main()
"""


def test_a_signal_that_is_passed_on_does_not_cost_the_results(short, tmp_path):
    command = [sys.executable, "-c", SLOW, "sitl", "--serve", "--scenario", short, "--out", tmp_path / "out", "--json"]
    with program(command, tmp_path, code=0, lives=False) as (process, log):
        wait_for(lambda: "running" in log.read_text())
        process.terminate()
        wait_for(lambda: "finishing" in log.read_text())
        process.terminate()
        process.wait(30)
    assert (tmp_path / "out" / "truth.json").exists()


@pytest.mark.soak  # with a page: the last but one
def test_what_it_records_on_request_is_in_the_folder(short, tmp_path):
    with serving(short, "--record", tmp_path / "tapes") as (payload, ground):
        wait(ground, "HEARTBEAT", lambda message: message.get_srcComponent() == 191)
        wait_for(lambda: any(tmp_path.glob("tapes/*/audio.wav")))  # from its first Input on
        assert order(ground, RECORD, 0) == ACCEPTED
    assert payload.returncode == 0, payload.erred
    (session,) = (tmp_path / "tapes").iterdir()
    assert soundfile.info(session / "audio.wav").channels == 2


def test_without_a_link_it_speaks_to_where_ground_stations_listen(short):
    assert [link.url for link in linked(load(short)).payload.links] == ["udpout:127.0.0.1:14550"]


def test_the_links_of_a_scenario_are_kept(short):
    short.write_text(short.read_text() + '[[payload.links]]\nurl = "udpin:127.0.0.1:14600"\n')
    assert [link.url for link in linked(load(short)).payload.links] == ["udpin:127.0.0.1:14600"]


@contextmanager
def page_of(scenario, home):
    """A served payload with a page, and the address of the page."""
    command = [sys.executable, "-u", "-m", "ross_payload.cli", "sitl", "--serve", "--page", "--scenario", str(scenario)]
    environment = {**os.environ, "HOME": str(home)}
    environment.pop("STATE_DIRECTORY", None)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment) as it:
        try:
            yield it, it.stdout.readline().split()[-1]
        finally:
            it.send_signal(signal.SIGINT)
            it.said = it.stdout.read()  # not `communicate`, which leaves out what came along with the first line


async def recorded(url):
    """Record on request; return the archive that the page gives, and what it says of the recordings."""
    async with browser(url) as one:
        await one.next("fleet", lambda told: told["payloads"])
        await one.say(type="order", id="1-191", order={"kind": "record", "on": True})
        await one.next("recordings", lambda told: told["known"] and told["known"][0]["running"])
        await asyncio.sleep(1.0)  # of sound
        await one.say(type="order", id="1-191", order={"kind": "record", "on": False})
        told = await one.next("recordings", lambda told: told["known"] and not told["known"][0]["running"])
    async with aiohttp.ClientSession() as client, client.get(f"{url}recordings/0001.zip") as answer:
        assert answer.status == 200
        return told, await answer.read()


async def test_what_the_page_says_is_recorded_is_on_the_disk_afterwards_without_being_asked_for_at_the_start(
    short, tmp_path
):
    with page_of(short, tmp_path) as (payload, url):
        told, archive = await recorded(url)
    assert payload.returncode == 0, payload.said
    folder = Path(told["folder"])
    (known,) = told["known"]
    session = folder / known["name"]
    assert soundfile.info(session / "audio.wav").duration == pytest.approx(known["seconds"])
    assert f"nothing is recorded until a command asks for it; folder of recordings: {folder}" in payload.said
    assert f": {session}\n" in payload.said
    assert (stat.S_IMODE(session.stat().st_mode), stat.S_IMODE((session / "audio.wav").stat().st_mode)) == (
        0o700,
        0o600,
    )
    assert (session / "voice.npz").exists(), "nobody's: so the session is replayed in another configuration, too"
    with zipfile.ZipFile(io.BytesIO(archive)) as held:
        assert held.read("0001/audio.wav") == (session / "audio.wav").read_bytes()


@pytest.mark.parametrize("speed", ["0", "fast"])
def test_a_speed_that_is_none_is_refused(run, speed):
    code, _, err = run("sitl", "--serve", "--speed", speed, "--telemetry", "udpout:127.0.0.1:9")
    assert code == 2
    assert "expected max or a number of times real time (0.01 to 1000), got" in err
