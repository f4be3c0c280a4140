"""TCP links of the ground side over real sockets: both ways, lost and found again, never flooded."""

import asyncio
import contextlib
import socket

from ports import free_port
from ross_payload.ground.links.link import MAX_PEERS
from ross_payload.ground.station import Station
from ross_protocols.mavlink.codec import Decoder, Encoder
from station_bench import AUDIO, BEAT, FRAME, known
from waiting import wait_for_async


class Server:
    """A TCP server that says a frame to whoever connects, and keeps what it hears."""

    def __init__(self, port: int) -> None:
        self._port = port
        self.heard = bytearray()
        self._writers: list[asyncio.StreamWriter] = []

    async def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._writers.append(writer)
        writer.write(FRAME)
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(1000):
                self.heard += data

    async def __aenter__(self) -> "Server":
        self._server = await asyncio.start_server(self._meet, "127.0.0.1", self._port)
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()
        for writer in self._writers:
            writer.transport.abort()
        await self._server.wait_closed()
        await asyncio.sleep(0.05)


async def test_a_tcp_client_goes_both_ways_and_finds_a_server_again_within_seconds() -> None:
    port = free_port()
    async with Station([f"tcp:127.0.0.1:{port}"]) as station:
        await wait_for_async(lambda: station.links()[0].error == "Connection refused")
        for life in (1, 2, 3):
            async with Server(port) as server:
                began = asyncio.get_running_loop().time()
                await wait_for_async(lambda life=life: station.links()[0].frames == life)
                assert asyncio.get_running_loop().time() - began < 10.0, "3 s, on a computer that is busy"
                await wait_for_async(lambda server=server: Decoder().feed(bytes(server.heard)))
                assert station.links()[0].up
                assert station.links()[0].error == ""
            await wait_for_async(lambda: not station.links()[0].up)
            assert station.links()[0].error


async def test_a_tcp_server_hears_several_clients_and_answers_each() -> None:
    port = free_port()
    async with Station([f"tcpin:127.0.0.1:{port}"]) as station:
        clients = [await asyncio.open_connection("127.0.0.1", port) for _ in range(3)]
        for number, (_, writer) in enumerate(clients):
            frame = Encoder(1, 191 + number).encode(AUDIO)
            writer.write(frame[:10])
            await asyncio.sleep(0.01)
            writer.write(frame[10:])
        await wait_for_async(lambda: len(station.fleet.payloads) == 3)
        for reader, _ in clients:
            assert Decoder().feed(await reader.read(21))[0].name == "HEARTBEAT"
        for _, writer in clients:
            writer.close()
            await writer.wait_closed()
        await wait_for_async(lambda: station.links()[0].peers == 0)
        assert station.links()[0].up


async def test_a_tcp_server_takes_so_many_clients_and_no_more() -> None:
    port = free_port()
    async with Station([f"tcpin:127.0.0.1:{port}"]) as station:
        clients = [await asyncio.open_connection("127.0.0.1", port) for _ in range(MAX_PEERS + 5)]
        await wait_for_async(lambda: station.links()[0].peers == MAX_PEERS)
        with contextlib.suppress(ConnectionError):
            assert await clients[-1][0].read() == b"", "it is sent away"
        clients[0][1].write(FRAME)
        await wait_for_async(lambda: known(station))
        for _, writer in clients:
            writer.transport.abort()


async def test_a_client_that_reads_nothing_does_not_fill_the_memory() -> None:
    port = free_port()
    async with Station([f"tcpin:127.0.0.1:{port}"]) as station:
        with socket.create_connection(("127.0.0.1", port)):
            await wait_for_async(lambda: station.links()[0].peers == 1)
            server = station._links[0]._port
            (client,) = server._clients.values()  # type: ignore[union-attr]
            while server.counts.sent < 100_000 and not server.counts.dropped:  # type: ignore[union-attr]
                server.send(bytes(1000))  # type: ignore[union-attr]
            station.send(BEAT)
            assert 0 < len(client.stream.waiting) <= 1000
