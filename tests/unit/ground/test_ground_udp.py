"""UDP links of the ground side over real sockets: everybody is heard and answered, strangers displace nobody."""

import asyncio
import contextlib

from clocks import LeapingClock
from ports import free_port
from ross_payload.ground.links.link import MAX_PEERS
from ross_payload.ground.station import Station
from station_bench import AUDIO, BEAT, Far, known
from waiting import wait_for_async


async def test_a_udp_listener_hears_everybody_and_answers_each() -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"]) as station:
        with Far(port) as one, Far(port, component=192) as other:
            one.say(AUDIO)
            other.say(AUDIO)
            await wait_for_async(lambda: known(station) == ["1-191", "1-192"])
            await wait_for_async(lambda: "HEARTBEAT" in one.names() and "HEARTBEAT" in other.names())
        (link,) = station.links()
    assert link.up
    assert link.peers == 2
    assert [str(who) for who in link.senders] == ["1-191", "1-192"]


async def test_a_udp_caller_speaks_first_and_hears_that_address_only() -> None:
    port = free_port()
    with Far(0, bind=port) as payload, Far(0) as stranger:
        async with Station([f"udpout:127.0.0.1:{port}"]) as station:
            await wait_for_async(lambda: "HEARTBEAT" in payload.names())
            payload._sock.settimeout(0)
            caller = await wait_for_async(lambda: _source_of(station))
            stranger._to = payload._to = caller
            stranger.say(AUDIO)
            payload.say(AUDIO)
            await wait_for_async(lambda: station.links()[0].frames)
            await asyncio.sleep(0.2)
            assert station.links()[0].frames == 1


def _source_of(station: Station) -> tuple[str, int]:
    where: tuple[str, int] = station._links[0]._port._socket.getsockname()  # type: ignore[union-attr]
    return where


async def test_a_udp_caller_says_that_nobody_listens_and_is_heard_when_somebody_does() -> None:
    port = free_port()
    async with Station([f"udpout:127.0.0.1:{port}"]) as station:
        await wait_for_async(lambda: station.links()[0].error == "Connection refused")
        assert not station.links()[0].up
        with Far(0, bind=port) as payload:
            await wait_for_async(payload.names)
            payload._to = _source_of(station)
            payload.say(AUDIO)
            await wait_for_async(lambda: station.links()[0].up)
        assert station.links()[0].error == ""


async def test_frames_cut_anywhere_are_put_together_per_sender() -> None:
    port = free_port()
    async with Station([f"udpin:127.0.0.1:{port}"]) as station:
        with Far(port) as one, Far(port, component=192) as other:
            frames = [far.encoder.encode(AUDIO) for far in (one, other)]
            for cut in (slice(0, 9), slice(9, 15), slice(15, None)):
                one.throw(frames[0][cut])
                other.throw(frames[1][cut])
            await wait_for_async(lambda: len(station.fleet.payloads) == 2)
        assert station.links()[0].bad == 0


async def test_strangers_neither_fill_the_memory_nor_displace_a_payload() -> None:
    port, clock = free_port(), LeapingClock()
    async with Station([f"udpin:127.0.0.1:{port}"], now=clock.now) as station:
        with Far(port) as payload, contextlib.ExitStack() as stack:
            payload.say(AUDIO)
            await wait_for_async(lambda: known(station))
            for _ in range(MAX_PEERS + 50):
                stack.enter_context(Far(port)).throw(b"\xfd\xff\x00")
                await asyncio.sleep(0)
            payload.say(AUDIO)
            await wait_for_async(lambda: station.links()[0].frames == 2)
            await wait_for_async(lambda: station.links()[0].peers == MAX_PEERS)
            payload.heard.clear()
            await wait_for_async(lambda: "HEARTBEAT" in payload.names())


async def test_when_all_peers_are_good_a_newcomer_waits_until_one_is_silent() -> None:
    port, clock = free_port(), LeapingClock()
    async with Station([f"udpin:127.0.0.1:{port}"], now=clock.now) as station:
        with Far(port) as late, contextlib.ExitStack() as stack:
            for number in range(MAX_PEERS):
                stack.enter_context(Far(port, component=number + 10)).say(BEAT)
                await asyncio.sleep(0)
            await wait_for_async(lambda: station.links()[0].peers == MAX_PEERS)
            late.say(AUDIO)
            await wait_for_async(lambda: station.links()[0].strangers == 1)
            clock.ahead += 60.0
            late.say(AUDIO)
            await wait_for_async(lambda: known(station))
        assert station.links()[0].peers == MAX_PEERS


async def test_hosts_may_be_ipv6() -> None:
    port, stream = free_port(), free_port()
    ears = [f"udpin:[::1]:{port}", f"tcpin:[::1]:{stream}"]
    mouths = [f"udpout:[::1]:{port}", f"tcp:[::1]:{stream}"]
    async with Station(ears) as station, Station(mouths, system_id=1, component_id=191) as other:
        await wait_for_async(lambda: all(link.frames for link in (*station.links(), *other.links())))
