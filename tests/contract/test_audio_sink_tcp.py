"""A voice over TCP: ports that are taken, listeners that are not there, deaf, or too many."""

from __future__ import annotations

import contextlib
import socket
from functools import partial

import numpy as np
import pytest

from ross_payload.audio.sinks import info_of
from ross_payload.errors import AudioError
from sink_bench import TcpListener, blocks, tcp, voice
from waiting import wait_for

pytestmark = pytest.mark.process


def test_a_port_in_use_is_told(tmp_path):
    rig = tcp(tmp_path, None)
    where = f"tcp:127.0.0.1:{rig.options['port']}"
    with socket.create_server(("127.0.0.1", rig.options["port"])), pytest.raises(AudioError) as error, rig.make():
        pass
    assert str(error.value) == f"{where}: cannot listen: Address already in use"


def test_an_address_that_is_not_there_is_told_and_tried_again(tmp_path):
    rig = tcp(tmp_path, None)
    rig.options["mode"] = "connect"
    where = f"tcp:127.0.0.1:{rig.options['port']}"
    with rig.make() as sink:
        every = blocks(voice(60.0))
        wait_for(lambda: sink.write(next(every)) or sink.fault)
        assert sink.fault == f"{where}: no listener: Connection refused"
        assert sink.lost > 0
        with socket.create_server(("127.0.0.1", rig.options["port"])) as server:
            rig.services.clock.ahead += 20.0
            wait_for(lambda: sink.write(next(every)) or not sink.fault)
            with server.accept()[0] as peer:
                peer.settimeout(20)
                sink.write(next(every))
                assert peer.recv(20).startswith(b'{"ross_pcm": 1')
        wait_for(lambda: sink.write(next(every)) or sink.fault)
        assert "the listener is gone" in sink.fault or "no listener" in sink.fault


def test_a_listener_that_stops_reading_is_hung_up_on_and_the_others_hear_on(tmp_path, caplog):
    caplog.set_level("INFO")
    rig = tcp(tmp_path, None)
    port = rig.options["port"]
    with rig.make() as sink, socket.socket() as deaf, contextlib.closing(TcpListener(port)) as other:
        other.begin()
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        deaf.connect(("127.0.0.1", port))
        sink.write(next(blocks(voice(0.1))))
        wait_for(lambda: sink.write(next(blocks(voice(0.1)))) or info_of(sink).listeners == 2)
        samples = voice(10.0)
        for block in blocks(samples):
            wait_for(partial(other.has_taken, block.index))  # in real time there is time for it
            sink.write(block)
        assert info_of(sink).listeners == 1
        wait_for(lambda: np.array_equal(other.samples[-len(samples) :], samples))
        assert sink.lost > 0
        assert sink.fault == ""
    assert [text for text in caplog.messages if "behind" in text]


def test_who_sends_without_end_holds_up_nobody(tmp_path):
    """However much has come, only a little of it is read with a block."""
    rig = tcp(tmp_path, None)

    def fill(peer):
        count, data = 0, bytes(1 << 16)
        with contextlib.suppress(BlockingIOError):
            while True:
                count += peer.send(data)
        return count

    with rig.make() as sink, socket.create_connection(("127.0.0.1", rig.options["port"])) as peer:
        every = blocks(voice(60.0))
        wait_for(lambda: sink.write(next(every)) or info_of(sink).listeners == 1)
        peer.setblocking(False)
        waiting = fill(peer)
        sink.write(next(every))
        assert fill(peer) < waiting / 4


def test_too_many_listeners_are_turned_away(tmp_path):
    rig = tcp(tmp_path, None)
    with rig.make() as sink, contextlib.ExitStack() as stack:
        others = [stack.enter_context(socket.create_connection(("127.0.0.1", rig.options["port"]))) for _ in range(9)]
        wait_for(lambda: sink.write(next(blocks(voice(0.1)))) or info_of(sink).listeners == 8)
        others[-1].settimeout(20)
        assert others[-1].recv(10) == b""
