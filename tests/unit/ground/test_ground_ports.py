"""Links of the ground side that cannot be, and noise, floods and frames without an end on those that can."""

import asyncio
import random
import socket

import pytest

from ports import free_port
from ross_payload.ground.errors import GroundError
from ross_payload.ground.station import Station
from station_bench import AUDIO, FRAME, Far, known, opened
from waiting import wait_for_async

NOISE = random.Random(7).randbytes(100_000)  # noqa: S311  nobody shall be surprised


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("udp:127.0.0.1:14550", "expected udpin:, udpout:, tcp: or tcpin:host:port, or serial:device:baud"),
        ("udpin:127.0.0.1:99999", "expected a port from 1 to 65535, got '99999'"),
        ("udpin:192.0.2.1:14550", "cannot be opened: Cannot assign requested address"),
        ("tcpin:192.0.2.1:5760", "cannot be opened: Cannot assign requested address"),
    ],
)
async def test_a_link_that_cannot_be_is_one_clear_line(url: str, says: str) -> None:
    with pytest.raises(GroundError) as error:
        await opened(url)
    assert error.value.exit_code == 2
    assert error.value.message.startswith(f"link '{url}'")
    assert says in error.value.message
    assert "\n" not in error.value.message


@pytest.mark.parametrize(("kind", "sort"), [("udpin", socket.SOCK_DGRAM), ("tcpin", socket.SOCK_STREAM)])
async def test_a_port_in_use_says_which_and_what_to_do_and_leaves_nothing_open(kind: str, sort: int) -> None:
    first, taken = free_port(), free_port()
    with socket.socket(socket.AF_INET, sort) as sock:
        sock.bind(("127.0.0.1", taken))
        if sort == socket.SOCK_STREAM:
            sock.listen()
        with pytest.raises(GroundError, match=f"'{kind}:127.0.0.1:{taken}' .* in use; another program listens there"):
            await opened(f"udpin:127.0.0.1:{first}", f"{kind}:127.0.0.1:{taken}")
    await opened(f"udpin:127.0.0.1:{first}")


async def test_what_stands_behind_a_frame_that_never_ends_is_heard_after_a_silence() -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"]) as station:
        with Far(port) as payload:
            payload.throw(b"\xfd\xff\x00" + payload.encoder.encode(AUDIO))
            await wait_for_async(lambda: known(station))


@pytest.mark.parametrize("kind", ["udpin", "tcpin"])
async def test_a_hundred_thousand_random_bytes_do_no_harm(kind: str) -> None:
    port = free_port()
    async with Station([f"{kind}:127.0.0.1:{port}"]) as station:
        sort = socket.SOCK_DGRAM if kind == "udpin" else socket.SOCK_STREAM
        with socket.socket(socket.AF_INET, sort) as sock:
            sock.connect(("127.0.0.1", port))
            sock.setblocking(False)
            for begin in range(0, len(NOISE), 1000):
                await asyncio.get_running_loop().sock_sendall(sock, NOISE[begin : begin + 1000])
                await asyncio.sleep(0)
            await wait_for_async(lambda: station.links()[0].bytes == len(NOISE))
            await asyncio.sleep(0.3)
            await asyncio.get_running_loop().sock_sendall(sock, FRAME)
            await wait_for_async(lambda: known(station) == ["1-191"])
        (link,) = station.links()
        assert link.skipped > 90_000
        assert link.frames == 1


async def test_a_flood_lets_others_have_their_turn() -> None:
    port, quiet = free_port(), free_port()
    async with Station([f"tcpin:127.0.0.1:{port}", f"udpin:127.0.0.1:{quiet}"]) as station:
        _, writer = await asyncio.open_connection("127.0.0.1", port)
        flood = asyncio.create_task(_flood(writer))
        with Far(quiet) as payload:
            for number in range(20):
                payload.say(AUDIO)
                began = asyncio.get_running_loop().time()
                await wait_for_async(lambda number=number: station.links()[1].frames == number + 1)
                assert asyncio.get_running_loop().time() - began < 1.0
        assert station.links()[0].bytes > 100_000
        flood.cancel()
        writer.transport.abort()
        await asyncio.sleep(0.05)


async def _flood(writer: asyncio.StreamWriter) -> None:
    """Send what looks like the beginning of frames all the time."""
    while True:
        writer.write(b"\xfe" * 8192)
        await writer.drain()
