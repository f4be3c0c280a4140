"""Others on the same network: a second payload with our component id, and one that speaks another version."""

import socket
import threading

import pytest

from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.values import DIALECT_VERSION, Information
from waiting import wait_for

pytestmark = pytest.mark.process
LOOPBACK = "127.0.0.1"
STOP = 54004
ACCEPTED = 0


class Switch:
    """Passes every datagram on to everybody else, as a router between payloads and ground stations does."""

    def __init__(self, *peers):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((LOOPBACK, 0))
        self._socket.settimeout(0.05)
        self.port = self._socket.getsockname()[1]
        self._peers = {(LOOPBACK, port) for port in peers}
        self._open = True
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def close(self):
        self._open = False
        self._thread.join()
        self._socket.close()

    def _work(self):
        while self._open:
            try:
                datagram, source = self._socket.recvfrom(2048)
            except (TimeoutError, ConnectionRefusedError):
                continue
            self._peers.add(source)
            for peer in self._peers - {source}:
                self._socket.sendto(datagram, peer)


def said(ground, words):
    """The texts that begin so; a long one comes in chunks, the first is 0."""
    return [one for one in ground.of("STATUSTEXT") if one.text.startswith(words) and not one.chunk_seq]


@pytest.fixture
def ground(ground_stations):
    return ground_stations()


@pytest.fixture
def switch(ground):
    switch = Switch(ground.port)
    yield switch
    switch.close()


@pytest.mark.soak
def test_two_payloads_with_one_component_id_go_on_and_both_say_it(ross_run, ground, switch, tmp_path):
    link = f'url = "udpout:{LOOPBACK}:{switch.port}"'
    with ross_run(tmp_path / "one", link) as one, ross_run(tmp_path / "other", link) as other:
        wait_for(lambda: len(said(ground, "RoSS: another sender uses our component id 191")) == 2)
        beats = len(ground.of("HEARTBEAT"))
        wait_for(lambda: len(ground.of("HEARTBEAT")) >= beats + 8)
        assert len(said(ground, "RoSS: another sender")) == 2, "once each"
        ground.command(STOP)
        for payload in (one, other):
            wait_for(lambda payload=payload: "stopped: stopped by command" in payload.lines())


@pytest.mark.soak
def test_payloads_with_their_own_component_ids_have_nothing_to_say(ross_run, ground, switch, tmp_path):
    link = f'url = "udpout:{LOOPBACK}:{switch.port}"'
    own = "[telemetry]\ncomponent_id = 192\n"
    with ross_run(tmp_path / "one", link) as one, ross_run(tmp_path / "other", link, more=own) as other:
        wait_for(lambda: len(ground.of("HEARTBEAT", 192)) > 3 and len(ground.of("HEARTBEAT", 191)) > 3)
        assert ground.obeyed(STOP) == ACCEPTED
        wait_for(lambda: "stopped: stopped by command" in one.lines())
        assert "stopped: stopped by command" not in other.lines(), "only one of them was meant"
        assert not said(ground, "RoSS: another sender")


def test_another_version_of_the_dialect_is_named_once(ross_run, ground, switch, tmp_path):
    stranger = Encoder(2, 191)
    told = Information(0, 0.05, 343.0, 0.0, None, None, 1.0, 3.0, 16000, 6, "9.9", "tb6600", DIALECT_VERSION + 1)
    with (
        ross_run(tmp_path, f'url = "udpout:{LOOPBACK}:{switch.port}"'),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer,
    ):
        ground.wait("HEARTBEAT")
        for _ in range(5):
            peer.sendto(stranger.encode(told), (LOOPBACK, switch.port))
            ground.rest(0.3)
        wait_for(lambda: said(ground, f"RoSS: payload 2/191: dialect {DIALECT_VERSION + 1}, expected"))
        ground.rest(1.0)
        assert len(said(ground, "RoSS: payload")) == 1
