"""``ross ground`` as a process: how soon it ends, and serves a browser while somebody holds its connections open."""

import asyncio
import resource
import signal
import socket
import time
from contextlib import ExitStack
from urllib.request import urlopen

import pytest

from examples import in_soak
from ground_page import browser
from ground_process import ground, link


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
async def test_it_ends_at_once_and_cleanly_also_while_somebody_watches(number):
    async def watched(url, process):
        async with browser(url) as one:
            await one.next("hello")
            start = time.monotonic()
            process.send_signal(number)
            assert await asyncio.to_thread(process.wait, 30) == 0
            return time.monotonic() - start

    with ground(link()) as (process, url):
        lasted = await watched(url, process)
        assert process.stderr.read() == ""
    assert lasted < 5.0  # 0.2 s on a computer with nothing else to do


HALF_OPEN = 1300  # more than there are descriptors


@pytest.fixture
def many_descriptors():
    """Let this process, which plays the attacker, open as many sockets as it needs."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    if before[1] < HALF_OPEN + 500:
        pytest.skip(f"needs {HALF_OPEN + 500} descriptors, has {before[1]}")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(before[0], HALF_OPEN + 500), before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


@pytest.mark.parametrize("descriptors", [(1024, 1024), *in_soak((256, 256), (256, 4096))])
def test_half_open_requests_keep_no_new_browser_out_and_fill_no_log(descriptors, many_descriptors):
    """Each has sent half a header; in 1024 descriptors they used to find room for themselves alone."""
    with ground(link(), descriptors=descriptors) as (process, url), ExitStack() as held:
        place = "127.0.0.1", int(url.rstrip("/").rpartition(":")[2])
        begin = time.monotonic()
        for _ in range(HALF_OPEN):
            half = held.enter_context(socket.socket())
            half.settimeout(20)
            half.connect(place)
            half.send(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: ")
        waited = []
        for _ in range(3):
            start = time.monotonic()
            with urlopen(url, timeout=20) as answer:  # noqa: S310
                assert answer.status == 200
            waited.append(time.monotonic() - start)
        lasted = time.monotonic() - begin
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
    assert max(waited) < 2.0
    assert "Traceback" not in told
    assert told.count("\n") <= 1 + lasted
