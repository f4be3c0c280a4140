"""One contract for everything that can be heard with; each kind adds its maker to `KINDS`."""

from __future__ import annotations

import contextlib
import socket
import sys
import threading
import time

import numpy as np
import pytest
import soundfile

from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.file_source import FileSource
from ross_payload.audio.live_source import LiveSource, SourceStatus, Watched
from ross_payload.audio.open_source import open_source
from ross_payload.audio.pcm_client import PcmClient
from ross_payload.clock import SystemClock
from ross_payload.config import Audio, Config, validated
from ross_payload.errors import AudioEnded, AudioError
from ross_payload.interfaces import AudioFlag
from ross_protocols.audio.pcm import Header, encode, encode_header
from ross_sim.clock import SimClock
from ross_sim.scenario import Scenario
from ross_sim.sitl.world import World

RATE, HOP = 16000, 160
LATE = 0.6  # [s] after its capture within which a sample is given


class Still:
    """A far end that does not turn."""

    port = None

    def advance(self, now):
        pass

    def angle(self):
        return 0.0


class Server:
    """Sends counted samples over TCP in real time, to one client after another; can be told to hang up."""

    def __init__(self, header=None):
        self._header = encode_header(Header(RATE, 2)) if header is None else header
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self._hang_up = threading.Event()
        self._over = False
        self._thread = threading.Thread(target=self._serve, name="server")
        self._thread.start()

    def hang_up(self):
        self._hang_up.set()

    def close(self):
        self._over = True
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join()

    def _serve(self):
        with contextlib.suppress(OSError):
            while not self._over:
                peer, _ = self._listener.accept()
                with peer, contextlib.suppress(OSError):
                    self._send(peer)
                self._hang_up.clear()

    def _send(self, peer):
        peer.sendall(self._header)
        begin, count = time.monotonic(), 0
        while not self._over and not self._hang_up.is_set():
            due = round((time.monotonic() - begin) * RATE)
            numbers = np.arange(count, due, dtype=np.float64) / 2**23
            peer.sendall(encode(np.stack([numbers, -numbers], axis=1).astype(np.float32), "s24le"))
            count = due
            time.sleep(0.01)


def simulated(stack, tmp_path, request):
    world = World(validated(Scenario, {"title": "t", "talkers": []}, "t"), [], Still(), SimClock(), 1, cache=tmp_path)
    return world.source, world.clock


def file(stack, tmp_path, request):
    samples = np.random.default_rng(1).standard_normal((3 * RATE, 2)) * 0.1
    soundfile.write(tmp_path / "take.flac", samples, RATE, subtype="PCM_24")
    return made(f"file:{tmp_path / 'take.flac'}", SimClock())


def tcp(stack, tmp_path, request):
    server = Server()
    stack.callback(server.close)
    return made(f"tcp:{server.address}", SystemClock())


def card(stack, tmp_path, request):
    module = request.getfixturevalue("make_card")(ppm=50, jitter=0.01)
    request.getfixturevalue("monkeypatch").setitem(sys.modules, "sounddevice", module)
    return made("device:card", module.clock)


def made(source, clock):
    """A source that is registered by name, as a configuration opens it."""
    return open_source(validated(Config, {"audio": {"source": source, "buffer_s": 5.0}}, "test"), clock), clock


KINDS = {"simulated": simulated, "file": file, "tcp": tcp, "card": card}  # what is simulated is registered nowhere


def pytest_generate_tests(metafunc):
    """Take every kind; with --audio-source that of a plug-in, live, which gives some sound."""
    if "kind" in metafunc.fixturenames:
        theirs = metafunc.config.getoption("--audio-source")
        metafunc.parametrize("kind", [theirs] if theirs else list(KINDS), ids=lambda kind: kind.partition(":")[0])


@pytest.fixture
def rig(kind, request, tmp_path):
    with rigged(kind, request, tmp_path) as rig:
        yield rig


@contextlib.contextmanager
def rigged(kind, request, tmp_path):
    with contextlib.ExitStack() as stack:
        yield KINDS[kind](stack, tmp_path, request) if kind in KINDS else made(kind, SystemClock())


def test_blocks_are_two_rows_of_float32_on_the_24_bit_grid(rig):
    source, _ = rig
    with source:
        samples = source.read(HOP).samples
    counts = samples.astype(np.float64) * 2**23
    assert samples.shape == (2, HOP)
    assert samples.dtype == np.float32
    assert np.array_equal(counts, np.rint(counts))


def test_blocks_of_any_size_are_consecutive(rig):
    source, _ = rig
    with source:
        blocks = [source.read(n) for n in (160, 77, 1, 320, 160, 1000, 160)]
    assert [block.index for block in blocks] == [0, 160, 237, 238, 558, 718, 1718]
    assert [block.samples.shape[1] for block in blocks] == [160, 77, 1, 320, 160, 1000, 160]


def test_time_grows_by_the_samples_that_were_read(rig):
    source, _ = rig
    with source:
        times = np.array([source.read(HOP).time for _ in range(100)])
    assert np.diff(times) == pytest.approx(HOP / RATE, rel=0.011)


def test_a_block_is_given_soon_after_it_was_heard_and_not_before(rig):
    source, clock = rig
    with source:
        late = [clock.now() - source.read(HOP).time - HOP / RATE for _ in range(50)]
    assert min(late) > -0.012
    assert min(late) < LATE


def test_a_reader_that_was_busy_gets_what_was_heard_meanwhile(rig):
    source, clock = rig
    with source:
        before = source.read(HOP)
        clock.sleep(0.5)
        after = source.read(HOP)
    assert after.index == before.index + HOP
    assert after.time == pytest.approx(before.time + HOP / RATE, abs=0.001)
    assert not after.flags


def test_it_is_closed_twice_without_harm(rig):
    source, _ = rig
    with source:
        source.read(HOP)
    source.__exit__(None, None, None)
    assert status_of(source).trouble == ""


def test_what_is_lost_is_counted_and_nothing_is_wrong_while_it_is_heard(rig):
    source, _ = rig
    with source:
        for _ in range(500):  # the computer may be busy
            block = source.read(HOP)
            status = status_of(source)
            assert status.lost or not block.flags & AudioFlag.MISSING
            if not block.flags and not status.trouble:
                return
    raise AssertionError(status)


def status_of(source):
    return source.status() if isinstance(source, Watched) else SourceStatus()


def test_making_one_opens_nothing(kind, request, tmp_path):
    before = set(threading.enumerate())
    with rigged(kind, request, tmp_path) as (source, _):
        begun = {thread.name for thread in set(threading.enumerate()) - before}
        assert begun <= {"server"}
        assert source.rate == RATE


def test_the_rate_is_the_configurations(rig):
    assert rig[0].rate == RATE


def test_reading_needs_an_open_source(rig):
    source, _ = rig
    with pytest.raises(AudioError, match="not open"):
        source.read(HOP)
    with source:
        source.read(HOP)
    with pytest.raises(AudioError, match="not open"):
        source.read(HOP)


def test_a_source_is_opened_only_once(rig):
    source, _ = rig
    with source:
        source.read(HOP)
    with pytest.raises(AudioError, match="only once"), source:
        pass


def test_a_file_ends_cleanly_with_every_whole_hop_read(tmp_path):
    samples = np.random.default_rng(1).integers(-(2**22), 2**22, (2, 1000)) / 2**23
    soundfile.write(tmp_path / "take.wav", samples.T, RATE, subtype="PCM_24")
    source = FileSource(tmp_path / "take.wav", RATE, ChannelMap.of(Audio()), SimClock())
    heard = []
    with source, pytest.raises(AudioEnded, match=r"end of file after 0\.06 s"):
        while True:
            heard.append(source.read(HOP).samples)
    assert np.array_equal(np.concatenate(heard, axis=1), samples[:, :960].astype(np.float32))


@pytest.mark.parametrize(
    ("rate", "channels", "said"),
    [
        (8000, 2, r"expected 16000 Hz \(audio.rate_hz\), got 8000 Hz"),
        (16000, 1, r"expected at least 2 channels \(audio.channels\), got 1"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(tmp_path, rate, channels, said):
    soundfile.write(tmp_path / "take.wav", np.zeros((100, channels)), rate)
    with (
        pytest.raises(AudioError, match=said),
        FileSource(tmp_path / "take.wav", RATE, ChannelMap.of(Audio()), SimClock()),
    ):
        pass


def test_a_file_that_is_missing_or_no_audio_is_refused(tmp_path):
    (tmp_path / "text.wav").write_text("not audio")
    for name, said in (
        ("none.wav", "no such file"),
        (".", "expected an audio file, got a folder"),
        ("text.wav", "expected audio that libsndfile can read"),
    ):
        source = FileSource(tmp_path / name, RATE, ChannelMap.of(Audio()), SimClock())
        with pytest.raises(AudioError, match=said), source:
            pass


def test_a_server_that_hangs_up_is_connected_to_again():
    server = Server()
    wiring = ChannelMap.of(Audio())
    source = LiveSource(PcmClient(server.address, RATE, wiring), RATE, wiring, 5.0, SystemClock())
    with contextlib.closing(server), source:
        source.read(HOP)
        server.hang_up()
        for _ in range(2000):
            heard = source.read(HOP).samples.any()
            if heard and source.status().reopened and not source.status().trouble:
                return
        raise AssertionError(source.status())


@pytest.mark.parametrize(
    ("header", "said"),
    [
        (b"GET / HTTP/1.1\n", "PCM header: expected a line like"),
        (encode_header(Header(48000, 2)), r"expected 16000 Hz \(audio.rate_hz\), got 48000 Hz"),
        (encode_header(Header(RATE, 1)), r"expected at least 2 channels \(audio.channels\), got 1"),
        (encode_header(Header(RATE, 2)).replace(b": 1,", b": 2,"), "PCM header: expected version 1, got 2"),
    ],
)
def test_a_server_that_does_not_fit_gets_one_clear_line(header, said):
    server = Server(header)
    wiring = ChannelMap.of(Audio())
    source = LiveSource(PcmClient(server.address, RATE, wiring), RATE, wiring, 5.0, SystemClock())
    with contextlib.closing(server), pytest.raises(AudioError, match=said), source:
        pass


def test_a_server_that_is_not_there_gets_one_clear_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
    wiring = ChannelMap.of(Audio())
    with (
        pytest.raises(AudioError, match=f"tcp:{address}: no audio: Connection refused"),
        LiveSource(PcmClient(address, RATE, wiring), RATE, wiring, 5.0, SystemClock()),
    ):
        pass
