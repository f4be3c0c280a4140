"""``ross monitor`` as a process: on a terminal, on a pipe, beside emulated payloads."""

import json
import os
import re
import signal
import subprocess
from contextlib import contextmanager

import pytest

from examples import in_soak
from fleet_bench import FleetBench
from monitor_bench import MONITOR, TIMEOUT_S, speaking, terminal
from ports import free_port

COLOURS = re.compile(rb"\x1b\[[0-9;]*3[0-7]m")
LEFT = b"\x1b[?1049l"


@pytest.fixture
def port():
    return free_port()


@contextmanager
def lines_of(*arguments):
    """The monitor on a pipe, which must end in good order."""
    process = subprocess.Popen([*MONITOR, *arguments], stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            code = process.wait(TIMEOUT_S)
        finally:
            process.kill()
            process.wait()
            process.stdout.close()
    assert code == 0


def run(*arguments, **environment):
    environment = {**os.environ, **environment}
    command = [*MONITOR, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment, check=False)


def lines_until(process, seen):
    """Read lines of a process until one is so; return all."""
    read = []
    for line in process.stdout:
        read.append(line)
        if seen(line):
            return read
    raise AssertionError(read)


def test_a_mission_is_watched_and_stopped_and_the_terminal_is_left_as_it_was(port):
    with FleetBench(port) as _, terminal(f"udpin:127.0.0.1:{port}") as screen:
        before = screen.settings()
        screen.shows("RoSS 1-191", "source azimuth", "s STOP")
        screen.type(b"e")
        screen.shows("1-191 explore: ")
        screen.type(b"s")
        screen.shows("1-191 stop: done", "STOPPED")
        screen.type(b"q")
        assert screen.ended() == 0
        assert screen.settings() == before
        assert screen.data.rstrip().endswith(LEFT)


@pytest.mark.parametrize("number", [signal.SIGTERM, *in_soak(signal.SIGINT)])
def test_a_signal_ends_it_in_good_order(port, number):
    with speaking(port), terminal(f"udpin:127.0.0.1:{port}") as screen:
        before = screen.settings()
        screen.shows("RoSS 1-191")
        screen.process.send_signal(number)
        assert screen.ended() == 0
        assert screen.settings() == before
        assert b"Traceback" not in screen.data


@pytest.mark.parametrize("key", [b"\x03", *in_soak(b"q", b"\x04")])  # q ends a mission's monitor above
def test_keys_end_it(port, key):
    with terminal(f"udpin:127.0.0.1:{port}") as screen:
        before = screen.settings()
        screen.shows("waiting for telemetry")
        screen.type(b"\x1a")  # Ctrl-Z is only a key: a stopped program could not put the terminal right
        screen.type(key)
        assert screen.ended() == 0
        assert screen.settings() == before


def test_it_follows_the_size_of_the_terminal(port):
    with speaking(port), terminal(f"udpin:127.0.0.1:{port}") as screen:
        small = screen.shows("s STOP")
        assert len(small.splitlines()) == 24
        screen.resize(150, 50)
        large = screen.shows("isolation of each source", "o-O axis")
        assert len(large.splitlines()) == 50
        screen.resize(40, 10)
        screen.until(lambda seen: len(seen.splitlines()) == 10 and "RoSS 1-191" in seen)


@pytest.mark.soak
def test_two_payloads_are_told_apart(port):
    with FleetBench(port, payloads=2), terminal(f"udpin:127.0.0.1:{port}", "--payload", "2-191") as screen:
        screen.shows("RoSS 2-191", " 1 1-191", " 2 2-191")
        screen.type(b"1")
        screen.shows("RoSS 1-191")


@pytest.mark.soak
def test_without_colour_nothing_is_coloured_and_without_utf_8_all_is_ascii(port):
    environment = {"NO_COLOR": "1", "PYTHONIOENCODING": "ascii"}
    with speaking(port), terminal(f"udpin:127.0.0.1:{port}", **environment) as screen:
        screen.shows("RoSS 1-191", "microphones")
        assert not COLOURS.search(screen.data)
        assert screen.data.isascii()


def test_what_rides_in_tunnel_is_seen(port):
    with speaking(port, tunnelled=True):
        done = run(f"udpin:127.0.0.1:{port}", "--once", "--json")
    picture = json.loads(done.stdout)
    assert done.returncode == 0
    assert picture["standing"]["tunnelled"]
    assert len(picture["sources"]) == 3


def test_one_look_prints_the_picture(port):
    with speaking(port):
        done = run(f"udpin:127.0.0.1:{port}", "--once", COLUMNS="100")
    assert done.returncode == 0
    assert "RoSS 1-191  RUN" in done.stdout
    assert "\x1b" not in done.stdout
    assert len(done.stdout.splitlines()) == 40


def test_one_look_at_nothing_says_what_to_check(port):
    done = run(f"udpin:127.0.0.1:{port}", "--once", "--wait", "0.5")
    assert done.returncode == 2
    assert done.stdout == ""
    [line] = done.stderr.splitlines()
    assert f"nothing received on udpin:127.0.0.1:{port}" in line
    assert "Traceback" not in done.stderr


def test_one_look_at_another_payload_says_who_is_there(port):
    with speaking(port):
        done = run(f"udpin:127.0.0.1:{port}", "--once", "--wait", "4", "--payload", "7-191")
    assert done.returncode == 2
    assert "expected telemetry from 7-191, got 1-191" in done.stderr


def test_on_a_pipe_every_change_is_a_line(port):
    with FleetBench(port) as bench, lines_of(f"udpin:127.0.0.1:{port}") as process:
        lines = lines_until(process, lambda line: "sources 0" in line)
        bench.tell(silence=[1])
        lines += lines_until(process, lambda line: "no telemetry for" in line)
        bench.tell(speak=[1])
        lines += lines_until(process, lambda line: "telemetry resumed" in line)
    assert any(re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\S* 1-191 state \w+", line) for line in lines)
    assert "\x1b" not in "".join(lines)


def test_json_lines_are_sections_that_changed(port):
    with FleetBench(port), lines_of(f"udpin:127.0.0.1:{port}", "--json") as process:
        lines = lines_until(process, lambda line: '"sources"' in line)
    told = [json.loads(line) for line in lines]
    assert {"time", "payload", "section", "value"} == set().union(*told)
    assert {each["section"] for each in told} >= {"link", "standing", "pointing", "sources"}
    assert all(each["payload"] == "1-191" for each in told if each["section"] not in ("link", "advice"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--payload", "1"), "expected system-component, as in 1-191, got '1'"),
        (("--once", "--wait", "0"), "--wait"),
        (("udp:nonsense",), "udp:nonsense"),
        (("--mavlink-key", "/nowhere"), "/nowhere"),
    ],
)
def test_a_mistake_is_one_line(port, arguments, words):
    done = run(f"udpin:127.0.0.1:{port}", *arguments)
    assert done.returncode == 2
    assert words in done.stderr
    assert len(done.stderr.splitlines()) == 1
