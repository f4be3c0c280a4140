"""The sink ``rtp`` on real sockets, its session descriptions over HTTP, and ``ross listen`` beside them."""

import errno
import os
import socket
import sys
import threading
import time
import urllib.error
import urllib.request

import numpy as np
import pytest
import soundfile

from command_line import called
from examples import in_soak
from ports import free_port
from ross_payload.audio.sinks import SinkServices, checked_options, info_of, make_sink, sdp_server
from ross_payload.audio.sinks.sdp_server import MOST_CLIENTS, SdpServer
from ross_payload.config import Config, validated
from ross_payload.errors import AudioError, ConfigError
from ross_payload.interfaces import VoiceBlock
from ross_payload.service.live_listening import described
from ross_payload.transport.rtp.receiver import RtpReceiver
from ross_payload.transport.rtp.session_description import parsed
from voice_sender import BLOCK, CLOCK, RATE, block_at, ear, opened, talking
from waiting import wait_for


def test_what_is_written_arrives_and_the_end_is_said(tmp_path):
    ramp = np.arange(3200) / 6400
    with ear() as sock:
        port = sock.getsockname()[1]
        with opened(port, tmp_path, codec="L16") as sink:
            for index in range(0, len(ramp), BLOCK):
                sink.write(block_at(index, ramp[index : index + BLOCK]))
            session = parsed(info_of(sink).sdp, "it")
        receiver = RtpReceiver(session.media, 0.02)
        while not receiver.reception(0.0).ended:
            receiver.on_datagram(sock.recv(2048), 0.0)
    assert (session.host, session.port, session.title) == ("127.0.0.1", port, "target")
    assert sink.lost == 0
    out = receiver.read(320 + len(ramp), 0.0)
    assert receiver.reception(0.0).received == len(ramp) // 320
    np.testing.assert_allclose(out[320:], ramp, atol=1e-4)


def test_a_packet_that_is_asked_for_is_sent_once_more(tmp_path):
    with ear() as sock, opened(sock.getsockname()[1], tmp_path, codec="L16") as sink, talking(sink):
        receiver = RtpReceiver(parsed(info_of(sink).sdp, "it").media)
        lost, dropped = set(), 0
        while receiver.reception(CLOCK.now()).received < 60:
            datagram, sender = sock.recvfrom(2048)
            if (
                datagram[1] == 96
                and dropped < 5
                and datagram not in lost
                and len(lost) * 10 < receiver.reception(0).received
            ):
                lost.add(datagram)
                dropped += 1
            else:
                lost.discard(datagram)
                receiver.on_datagram(datagram, CLOCK.now(), sender)
            for report in receiver.feedback(CLOCK.now()):
                sock.sendto(report, sender)
        assert dropped == 5
        assert not lost
        wait_for(lambda: info_of(sink).packets_lost is not None)


def test_nobody_there_is_a_fault_until_somebody_is(tmp_path):
    with ear() as sock:
        port = sock.getsockname()[1]
    with opened(port, tmp_path) as sink, talking(sink):
        wait_for(lambda: sink.fault)
        assert sink.fault == f"rtp to 127.0.0.1 port {port}: no receiver at this port"
        assert info_of(sink).listeners == 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
            sock.bind(("127.0.0.1", port))
            wait_for(lambda: not sink.fault)
            assert info_of(sink).listeners == 1


class Slow(socket.socket):
    """A socket on a network that takes nothing more for now."""

    def send(self, data, flags=0):
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))


def test_a_network_that_is_too_slow_tells_nothing_of_who_listens(tmp_path, monkeypatch):
    monkeypatch.setattr(socket, "socket", Slow)
    with opened(5004, tmp_path, codec="L16") as sink, talking(sink):
        wait_for(lambda: sink.lost > 0)
        assert sink.fault == "rtp to 127.0.0.1 port 5004: the network is slower than the stream"
        info = info_of(sink)
        assert (info.listeners, info.unheard_s) == (1, 0.0)


def test_the_broadcast_of_a_network_is_refused(tmp_path):
    asked = checked_options("rtp", {"address": "127.255.255.255"}, "options")
    with pytest.raises(AudioError, match=r"rtp to 127\.255\.255\.255 port 5004: Permission denied"):
        make_sink("rtp", asked, SinkServices(CLOCK, RATE, 0, "target", tmp_path)).__enter__()


def test_what_waits_too_long_is_counted_as_lost(tmp_path):
    with ear() as sock, opened(sock.getsockname()[1], tmp_path) as sink:
        sink.write(block_at(0, np.zeros(3 * RATE)))  # more than may wait
        assert sink.lost == 3 * RATE
    sink.write(block_at(0, np.zeros(10)))  # it is closed
    assert sink.lost == 3 * RATE + 10


def test_what_cannot_be_encoded_is_said_and_the_next_attempt_works(tmp_path):
    with ear() as sock:
        with opened(sock.getsockname()[1], tmp_path) as sink:
            sink.write(VoiceBlock(np.zeros((2, 2, 400), np.float32), 0, 0.0))  # no voice at all
            with pytest.raises(AudioError, match="rtp to"):
                wait_for(lambda: sink.write(block_at(400, np.zeros(BLOCK))))
            assert sink.fault
        with sink:
            sink.write(block_at(0, np.zeros(3 * BLOCK)))
            assert len(sock.recv(2048)) > 12
            assert not sink.fault


def fetched(server, name):
    with urllib.request.urlopen(f"http://127.0.0.1:{server.port}/{name}", timeout=30) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def test_session_descriptions_are_served_as_long_as_there_are_streams():
    texts = {0: "v=0", 3: ""}
    with SdpServer(lambda: texts, 0) as server:
        assert fetched(server, "stream-0.sdp") == ("application/sdp", "v=0")
        assert fetched(server, "")[1] == "stream-0.sdp\n"
        texts.clear()
        for name in ("stream-0.sdp", "stream-3.sdp", "../etc/passwd", "%00"):
            with pytest.raises(urllib.error.HTTPError, match="404"):
                fetched(server, name)


def test_clients_that_say_nothing_hold_up_nobody():
    with SdpServer(lambda: {0: "v=0"}, 0) as server:
        silent = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(5)]
        assert fetched(server, "stream-0.sdp")[1] == "v=0"
        for each in silent:
            each.close()


def test_a_client_that_says_a_byte_now_and_then_is_hung_up_on(monkeypatch):
    monkeypatch.setattr(sdp_server, "REQUEST_TIMEOUT_S", 0.5)
    with (
        SdpServer(lambda: {0: "v=0"}, 0) as server,
        socket.create_connection(("127.0.0.1", server.port)) as slow,
        pytest.raises(OSError),
    ):
        for _ in range(100):
            slow.sendall(b"G")
            time.sleep(0.05)


def test_a_server_that_speaks_no_http_is_one_line(monkeypatch, capsys):
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        answer = threading.Thread(target=lambda: _says(listening, b"samples\n\n"), daemon=True)
        answer.start()
        code, said, complained = called(monkeypatch, capsys, "listen", f"http://127.0.0.1:{port}/a.sdp")
        answer.join()
    assert (code, said) == (2, "")
    assert "no session description" in complained
    assert complained.count("\n") == 1


def _says(listening, words):
    sock, _ = listening.accept()
    with sock:
        sock.recv(4096)
        sock.sendall(words)


def test_a_firewall_that_refuses_packets_is_no_end_of_the_stream(tmp_path):
    class Refusing:
        def recv(self, _):
            raise OSError(errno.EHOSTUNREACH, "No route to host")

    with ear() as sock, opened(sock.getsockname()[1], tmp_path, codec="L16") as sink:
        sink._answer(Refusing())
        assert "No route to host" in sink.fault
        for index in range(0, 10 * BLOCK, BLOCK):
            sink.write(block_at(index, np.zeros(BLOCK)))
        assert sock.recv(2048)


def test_so_many_clients_are_served_and_others_are_turned_away(monkeypatch):
    monkeypatch.setattr(sdp_server._Handler, "timeout", 60)
    with SdpServer(lambda: {0: "v=0"}, 0) as server:
        silent = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(MOST_CLIENTS)]
        with pytest.raises((urllib.error.URLError, ConnectionError)):
            fetched(server, "stream-0.sdp")
        for each in silent:
            each.close()
        wait_for(lambda: _is_served(server))


def _is_served(server):
    try:
        return fetched(server, "stream-0.sdp")[1] == "v=0"
    except OSError:  # those who said nothing are still there
        return False


def test_a_port_in_use_is_said_in_one_line():
    with SdpServer(dict, 0) as server, pytest.raises(AudioError, match=r"cannot listen on .*: Address already in use"):
        SdpServer(dict, server.port).__enter__()


@pytest.mark.parametrize("package", ["av", "aiortc"])
def test_an_extra_that_is_missing_is_named(monkeypatch, package):
    for module in ("audio.sinks.rtp_sink", "audio.sinks.rtp_sender"):
        monkeypatch.delitem(sys.modules, f"ross_payload.{module}", raising=False)
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ConfigError, match=f"'rtp' needs the package {package}: .*install .*'aiortc>=.*'"):
        checked_options("rtp", {"address": "192.0.2.7"}, "options")


class Streams:
    """What a payload streams."""

    def descriptions(self):
        return {1: "v=0"}


def test_a_payload_serves_descriptions_where_its_configuration_says_so(caplog):
    port = free_port()
    config = validated(Config, {"listening": {"sdp_port": port}}, "it")
    with described(Streams(), config):
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/stream-1.sdp", timeout=30) as answer:
            assert answer.read() == b"v=0"
        assert not caplog.text
        with described(Streams(), config):  # the port is in use: all else goes on
            assert f"cannot listen on 127.0.0.1 port {port}: Address already in use" in caplog.text
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(f"http://127.0.0.1:{port}/stream-1.sdp", timeout=30)
    with described(Streams(), validated(Config, {}, "it")), pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=30)


@pytest.mark.parametrize("codec", ["opus", *in_soak("L16")])
def test_a_stream_is_listened_to_by_its_session_description(tmp_path, monkeypatch, capsys, codec):
    port = free_port()
    out = tmp_path / "heard.flac"
    with (
        opened(port, tmp_path, codec=codec) as sink,
        talking(sink),
        SdpServer(lambda: {2: info_of(sink).sdp}, 0) as server,
    ):
        url = f"http://127.0.0.1:{server.port}/stream-2.sdp"
        code, said, _ = called(monkeypatch, capsys, "listen", url, "--out", str(out), "--duration", "2.5")
    assert code == 0
    assert "since the microphone, lost 0 of " in said
    samples, rate = soundfile.read(out)
    assert rate == RATE
    assert np.abs(samples[rate:]).max() > 0.1
    assert out.stat().st_mode & 0o777 == 0o600


def test_pcm_over_tcp_is_listened_to(tmp_path, monkeypatch, capsys):
    with socket.socket() as door:
        door.bind(("127.0.0.1", 0))
        port = door.getsockname()[1]
    sink = make_sink(
        "tcp", checked_options("tcp", {"port": port}, "options"), SinkServices(CLOCK, RATE, 0, "target", tmp_path)
    )
    out = tmp_path / "heard.wav"
    with sink, talking(sink):
        wait_for(lambda: _answers(port))
        code, said, _ = called(
            monkeypatch, capsys, "listen", f"tcp://127.0.0.1:{port}", "--out", str(out), "--duration", "2"
        )
    assert (code, "delay" in said) == (0, True)
    assert np.abs(soundfile.read(out)[0]).max() > 0.1


def _answers(port):
    with socket.create_connection(("127.0.0.1", port), 1):
        return True


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["nothing"], "'nothing': expected rtp://ADDRESS:PORT, a file or an http address that ends in .sdp, or tcp://"),
        (["rtp://:5004?codec=mp3"], "expected rtp://ADDRESS:PORT for Opus, or rtp://ADDRESS:PORT?codec=L16&rate=HZ"),
        (["rtp://127.0.0.1:0"], "'rtp://127.0.0.1:0': expected a port from 1 to 65535"),
        (["rtp://:5004", "--delay", "nan"], "'--delay': expected a finite number, got nan"),
        (["rtp://:5004", "--duration", "nan"], "'--duration': expected a number, got nan"),
        (["http://"], "http://: no session description: no host given"),
        (["rtp://239.1.2.3:5004"], "expected an address of this computer, got one of many"),
        (["rtp://[ff02::1]:5004"], "expected an address of this computer, got one of many"),
        (["rtp://:70000"], "expected rtp://ADDRESS:PORT, a file"),
        (["missing.sdp"], "missing.sdp: cannot be read: No such file or directory"),
        (["rtp://:5004", "--out", "x.mp3"], "--out: expected a file that ends in .wav or .flac, got x.mp3"),
        (["rtp://:5004", "--out", "none/x.wav"], "--out: there is no folder none"),
        (["rtp://192.0.2.1:5004"], "cannot listen on 192.0.2.1 port 5004: Cannot assign requested address"),
        (["tcp://127.0.0.1:1"], "tcp:127.0.0.1:1: no audio: Connection refused"),
        (["http://127.0.0.1:1/x.sdp"], "no session description: Connection refused"),
        (["http://127.0.0.1:80x/a.sdp"], "no session description: nonnumeric port: '80x'"),
        (["tcp://a..b:80"], "tcp:a..b:80: no audio"),
    ],
)
def test_what_cannot_be_listened_to_is_one_line_and_leaves_nothing(tmp_path, monkeypatch, capsys, arguments, wanted):
    monkeypatch.chdir(tmp_path)
    code, said, complained = called(
        monkeypatch, capsys, "listen", *arguments, *(["--out", "y.wav"] * ("--out" not in arguments))
    )
    assert (code, said) == (2, "")
    assert wanted in complained
    assert complained.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_silence_for_the_whole_time_leaves_no_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with ear() as sock:
        port = sock.getsockname()[1]
    began = time.monotonic()
    code, said, complained = called(
        monkeypatch, capsys, "listen", f"rtp://:{port}", "--out", "y.wav", "--duration", "1.2"
    )
    assert time.monotonic() - began >= 1.2
    assert (code, said) == (2, f"     1 s  waits on 127.0.0.1 port {port}\n")
    assert complained.startswith(f"ross: nothing came to 127.0.0.1 port {port} in ")
    assert not list(tmp_path.iterdir())
