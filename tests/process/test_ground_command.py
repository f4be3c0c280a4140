"""``ross ground`` as a process: how it begins, and what it says of mistakes."""

import asyncio
import re
import resource
import signal
import socket
import subprocess
from urllib.request import urlopen

import pytest

from emulated_scene import full
from ground_page import browser
from ground_process import ROSS, ground, link
from ports import free_port
from station_bench import Far


def mistake(*words):
    """Run it to its end, which is a mistake of the user; return what it says."""
    done = subprocess.run([*ROSS, *words], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2, done.stderr
    assert not done.stdout
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr.strip()


async def test_what_a_payload_says_reaches_the_browser():
    async def watched(url, payload):
        async with browser(url) as one:
            await one.say(type="watch", id="1-191")
            payload.say(*full(7.0))
            await one.next("payload", lambda message: len(message["sections"].get("sources", [])) == 3)
            await one.say(type="order", id="1-191", order={"kind": "stop"})
            await one.next("payload", lambda message: message["sections"].get("orders"))
            async with asyncio.timeout(20):
                while "COMMAND_LONG" not in payload.names():
                    await asyncio.sleep(0.05)

    port = free_port()
    with ground(link(port)) as (_, url), Far(port) as payload:
        await watched(url, payload)


def test_a_taken_port_is_told_in_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        told = mistake(link(), "--port", str(port))
    assert told == f"ross: --port {port}: expected a free port, got one in use; --port 0 takes any"


def test_an_address_of_another_computer_is_told():
    told = mistake(link(), "--port", "0", "--host", "192.0.2.1").splitlines()[-1]
    assert told == "ross: --host 192.0.2.1: expected an address of this computer"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--token-file", "TMP/none"), "none: No such file or directory; expected a file with a token"),
        (("--token-file", "TMP/open"), "open: expected mode 0600, got 0644: chmod 600 "),
        (("--certificate", "TMP/none"), "--certificate TMP/none: expected a PEM file, got none of that name"),
        (("--certificate", "TMP/open"), "expected a certificate and its key in PEM, without a password"),
        (("--key", "TMP/open"), "--key: expected --certificate with it, got none"),
        (("--flights", "TMP/none"), "--flights TMP/none: expected a folder, got none of that name"),
        (("--mavlink-key", "TMP/none"), "none"),
        (("--port", "99999"), "99999"),
        (("nonsense",), "nonsense"),
        (("udpin:127.0.0.1:99999",), "99999"),
    ],
)
def test_a_mistake_is_told_in_one_line(tmp_path, words, told):
    (tmp_path / "open").write_text("a token that is long enough")
    (tmp_path / "open").chmod(0o644)
    words = [word.replace("TMP", str(tmp_path)) for word in words]
    assert told.replace("TMP", str(tmp_path)) in mistake(*words)


def test_elsewhere_than_here_it_makes_a_token_and_warns_of_clear_text():
    with ground(link(), "--host", "0.0.0.0") as (process, url):  # noqa: S104
        assert re.fullmatch(r"http://\S+:\d+/\?token=[\w-]{32}", url)
        assert "CLEAR TEXT" in process.stderr.readline()
        local = re.sub(r"//[^:/]+:", "//127.0.0.1:", url)
        with pytest.raises(OSError, match="401"), urlopen(local.split("?")[0]):  # noqa: S310
            pass


def test_a_token_from_a_file_is_not_shown(tmp_path):
    token = tmp_path / "token"
    token.write_text("a token that is long enough\n")
    token.chmod(0o600)
    with ground(link(), "--token-file", str(token)) as (process, url):
        assert "token" not in url
        with pytest.raises(OSError, match="401"), urlopen(url):  # noqa: S310
            pass
        process.send_signal(signal.SIGINT)
        assert "long enough" not in process.stdout.read() + process.stderr.read()


async def test_the_log_is_written_and_among_the_flights(tmp_path):
    async def listed(url):
        async with browser(url) as one:
            told = await one.next("flights", lambda message: message["known"])
            return [each["name"] for each in told["known"]]

    port = free_port()
    with ground(link(port), "--log", str(tmp_path / "logs")) as (_, url), Far(port) as payload:
        payload.say(*full(7.0))
        (name,) = await listed(url)
    assert (tmp_path / "logs" / name).stat().st_size


def test_the_terminal_says_once_what_to_look_at_without_telemetry_and_that_the_log_has_ended_however_late(tmp_path):
    port = free_port()
    with ground(link(port), "--log", str(tmp_path)) as (process, _), Far(port) as payload:
        line = process.stderr.readline()
        assert f"nothing received on udpin:127.0.0.1:{port} for " in line
        assert "url = " in line
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
        payload.say(*full(7.0))
        assert "the log has ended: File too large" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        assert process.stderr.read() == ""


def test_a_wrong_link_is_told_also_while_the_port_of_the_page_is_taken():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        told = mistake("--port", str(taken.getsockname()[1]), "nonsense")
    assert "nonsense" in told


def test_a_second_ground_that_finds_the_port_taken_leaves_no_log(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        mistake(link(), "--port", str(taken.getsockname()[1]), "--log", str(tmp_path / "logs"))
    assert not list(tmp_path.glob("logs/*"))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as busy:
        busy.bind(("127.0.0.1", 0))
        mistake(link(busy.getsockname()[1]), "--port", "0", "--log", str(tmp_path / "logs"))
    assert not list(tmp_path.glob("logs/*"))
