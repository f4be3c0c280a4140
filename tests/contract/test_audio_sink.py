"""One contract for everything that a voice goes to; each kind adds its maker to `KINDS`."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import socket
import threading
import time
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile

from clocks import FakeClock, LeapingClock
from full_disk import fill
from ports import free_port
from ross_payload.audio.sinks import SinkServices, checked_options, info_of, make_sink
from ross_payload.audio.sinks.device_sink import DeviceOptions, DeviceSink
from ross_payload.errors import AudioError, ConfigError, PluginError
from ross_payload.interfaces import VoiceBlock
from ross_payload.listening.sink_runner import DirectRunner
from ross_protocols.audio.pcm import Decoder
from waiting import wait_for

pytestmark = pytest.mark.process
RATE, HOP = 16000, 256
GRID = 2.0**-23
NO_SINK = "expected open() to return an AudioSink, got one without write"
SLOW_S = 0.5  # one call of `write`; the computer is busy, and a second would be a hang


def voice(seconds, seed=0):
    counts = np.random.default_rng(seed).integers(-(2**20), 2**20, round(seconds * RATE))
    return (counts * GRID).astype(np.float32)


def blocks(samples, first=0):
    for begin in range(0, len(samples), HOP):
        yield VoiceBlock(samples[begin : begin + HOP], first + begin, 3.0 + (first + begin) / RATE)


class Rig:
    """One sink, and what has come out of it at the other end."""

    def __init__(self, kind, options, services, received):
        self.kind, self.options, self.services, self.received = kind, options, services, received
        self.listen = lambda: None
        self.wait_until_taken = lambda count: None  # in real time there is time for it

    def make(self):
        return make_sink(self.kind, checked_options(self.kind, self.options, "options"), self.services)


class TcpListener:
    """Connects, and keeps what it hears; can stop reading."""

    def __init__(self, port):
        self.samples = np.zeros(0, np.float32)
        self._decoder = Decoder()
        self._socket = socket.create_connection(("127.0.0.1", port), 20)
        self._thread = threading.Thread(target=self._read, daemon=True)

    def begin(self):
        self._thread.start()

    def has_taken(self, count):
        return len(self.samples) >= count

    def _read(self):
        with contextlib.suppress(OSError):
            while data := self._socket.recv(65536):
                frames = self._decoder.feed(data)
                if frames.size:
                    self.samples = np.concatenate([self.samples, frames[:, 0]])

    def close(self):
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


def file(tmp_path, stack, suffix):
    path = tmp_path / "folder" / f"voice{suffix}"
    rig = Rig("file", {"path": str(path)}, services(tmp_path), lambda: soundfile.read(path, dtype="float32")[0])
    rig.path = path
    return rig


def flac(tmp_path, stack):
    return file(tmp_path, stack, ".flac")


def wav(tmp_path, stack):
    return file(tmp_path, stack, ".wav")


def tcp(tmp_path, stack):
    port = free_port(socket.SOCK_STREAM)
    listeners = []
    rig = Rig("tcp", {"port": port}, services(tmp_path), lambda: listeners[0].samples)

    def listen():
        listeners.append(TcpListener(port))
        stack.callback(listeners[-1].close)
        listeners[-1].begin()

    rig.listen = listen
    rig.wait_until_taken = lambda count: wait_for(lambda: len(rig.received()) >= count)
    return rig


def services(folder):
    return SinkServices(LeapingClock(), RATE, 0, "target", folder)


KINDS = {"flac": flac, "wav": wav, "tcp": tcp}


@pytest.fixture(params=KINDS)
def rig(request, tmp_path):
    with contextlib.ExitStack() as stack:
        yield KINDS[request.param](tmp_path, stack)


def test_every_sample_gets_out_once_and_in_order(rig):
    samples = voice(2.0)
    with rig.make() as sink:
        rig.listen()
        for block in blocks(samples):
            sink.write(block)
            assert sink.fault == ""
            rig.wait_until_taken(block.index + len(block.samples))
    assert np.array_equal(rig.received(), samples)
    assert sink.lost == 0


def test_no_call_blocks_while_nobody_takes_anything(rig):
    with rig.make() as sink:
        longest = 0.0
        for block in blocks(voice(3.0)):
            begin = time.monotonic()
            sink.write(block)
            longest = max(longest, time.monotonic() - begin)
    assert longest < SLOW_S


def test_it_tells_where_the_voice_goes(rig):
    with rig.make() as sink:
        info = info_of(sink)
    assert info.address
    assert info.codec


def test_it_is_closed_twice_without_harm(rig):
    sink = rig.make()
    with sink:
        sink.write(next(blocks(voice(0.1))))
    sink.__exit__(None, None, None)
    assert sink.fault == ""


def test_it_can_be_opened_again(rig):
    sink = rig.make()
    for _ in range(2):
        with sink:
            sink.write(next(blocks(voice(0.1))))
            assert sink.fault == ""


def test_making_one_opens_nothing(rig, tmp_path):
    rig.make()
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    if "port" in rig.options:
        with socket.create_server(("127.0.0.1", rig.options["port"])):
            pass


def test_a_full_disk_is_a_fault_and_what_is_not_written_is_counted(tmp_path):
    rig = flac(tmp_path, None)
    with rig.make() as sink:
        for block in blocks(voice(1.0)):
            sink.write(block)
        fill(rig.path)
        with pytest.raises(AudioError, match=f"^{rig.path}: cannot be written: No space left on device$"):
            for block in blocks(voice(2.0), RATE):
                sink.write(block)
        assert sink.fault == f"{rig.path}: cannot be written: No space left on device"
    assert len(rig.received()) > RATE / 2


@pytest.mark.parametrize("suffix", [".flac", ".wav"])
def test_after_a_full_disk_it_goes_on_in_another_file_when_there_is_room(tmp_path, monkeypatch, caplog, suffix):
    caplog.set_level("INFO")
    rig, clock, free = file(tmp_path, None, suffix), FakeClock(), [2**40]
    monkeypatch.setattr(
        "ross_payload.audio.sinks.file_sink.os.statvfs",
        lambda path: SimpleNamespace(f_bavail=free[0], f_frsize=1),
    )
    runner, samples = DirectRunner("stream 0", rig.make, clock), voice(12.0)
    for block in blocks(samples):
        if block.index == 4 * RATE:
            fill(rig.path)
            free[0] = 1000
        free[0] = 2**40 if block.index > 8 * RATE else free[0]
        runner.write(block)
        clock.sleep(HOP / RATE)
    lost = runner.lost
    runner.close()
    second = rig.path.with_stem("voice-2")
    assert sorted(path.name for path in rig.path.parent.iterdir()) == sorted([rig.path.name, second.name])
    first, rest = rig.received(), soundfile.read(second, dtype="float32")[0]
    assert np.array_equal(rest, samples[-len(rest) :]), "its first sample is the first that there was room for"
    assert np.array_equal(first, samples[: len(first)])
    assert 3.5 * RATE < len(first) <= 4.3 * RATE
    assert 2 * RATE - HOP <= len(rest) <= 4 * RATE, "every 2 s it is tried again"
    waited = len(samples) - len(first) - len(rest) - lost  # to be encoded, when the disk was full
    assert 0 <= waited < 5000
    said = [each.getMessage() for each in caplog.records if each.getMessage().startswith("stream 0")]
    assert said[:2] == [
        f"stream 0: {rig.path}: cannot be {done}: No space left on device" for done in ("written", "made")
    ]
    assert re.fullmatch(rf"stream 0: works again after \d\.\d s; {lost} samples are missing", said[2])
    assert len(said) == 3


def test_a_disk_that_takes_nothing_at_all_is_not_filled_with_empty_files(tmp_path, monkeypatch):
    def write(track, samples):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    rig = wav(tmp_path, None)
    monkeypatch.setattr("ross_payload.audio.track_files.WavTrack.write", write)
    with rig.make() as sink, pytest.raises(AudioError, match="Input/output error"):
        sink.write(next(blocks(voice(0.1))))
    assert not list(rig.path.parent.iterdir())


def test_a_file_is_told_as_it_was_named_not_where_it_lies(tmp_path):
    options = checked_options("file", {"path": "heard.flac"}, "options")
    for name in ("heard.flac", "heard-2.flac"):
        with make_sink("file", options, services(tmp_path)) as sink:
            assert info_of(sink).address == name
        assert (tmp_path / name).exists()


def test_a_folder_that_cannot_be_made_is_told_by_name(tmp_path):
    (tmp_path / "folder").write_text("in the way")
    with (
        pytest.raises(AudioError, match=r"folder/voice\.flac: cannot be made: File exists"),
        flac(tmp_path, None).make(),
    ):
        pass


def test_a_file_that_is_there_is_kept_and_another_name_taken(tmp_path):
    for number in range(3):
        with flac(tmp_path, None).make() as sink:
            sink.write(next(blocks(voice(0.1, number))))
            assert info_of(sink).address.endswith(("voice.flac", "voice-2.flac", "voice-3.flac")[number])
    assert len(list((tmp_path / "folder").iterdir())) == 3
    assert np.array_equal(flac(tmp_path, None).received(), next(blocks(voice(0.1, 0))).samples)


def test_a_file_that_is_named_without_a_folder_lies_with_the_recordings(tmp_path):
    rig = Rig("file", {"path": "take.wav"}, services(tmp_path / "recordings"), None)
    with rig.make():
        pass
    assert (tmp_path / "recordings" / "take.wav").stat().st_mode & 0o777 == 0o600


def test_a_gap_in_what_is_heard_is_a_gap_in_the_file(tmp_path):
    rig = flac(tmp_path, None)
    with rig.make() as sink:
        sink.write(VoiceBlock(np.full(10, 0.5, np.float32), 1000, 0.0))
        sink.write(VoiceBlock(np.full(10, 0.5, np.float32), 1100, 0.0))
    assert np.flatnonzero(rig.received()).tolist() == [*range(10), *range(100, 110)]


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


def test_too_many_listeners_are_turned_away(tmp_path):
    rig = tcp(tmp_path, None)
    with rig.make() as sink, contextlib.ExitStack() as stack:
        others = [stack.enter_context(socket.create_connection(("127.0.0.1", rig.options["port"]))) for _ in range(9)]
        wait_for(lambda: sink.write(next(blocks(voice(0.1)))) or info_of(sink).listeners == 8)
        others[-1].settimeout(20)
        assert others[-1].recv(10) == b""


@pytest.mark.parametrize(
    ("kind", "options", "said"),
    [
        ("file", {}, "options: path: expected a value, got none"),
        ("file", {"path": "a.mp3"}, "options: path: expected a name that ends in .flac or .wav, got 'a.mp3'"),
        ("tcp", {"port": 0}, "options: port: expected a number greater than or equal to 1, got 0"),
        ("tcp", {"port": 5, "codec": "mp3"}, "options: codec: expected 's16le', 's24le' or 'f32le', got 'mp3'"),
        ("device", {"latency_ms": 0}, "options: latency_ms: expected a number greater than 0, got 0"),
        ("fiel", {}, "sink 'fiel' is unknown; there are: device, file, rtp, tcp; did you mean 'file'?"),
    ],
)
def test_a_mistake_in_the_options_is_one_line(kind, options, said):
    with pytest.raises(ConfigError) as error:
        checked_options(kind, options, "options")
    assert str(error.value) == said


@pytest.mark.parametrize(
    ("opened", "said"),
    [
        (lambda config, services: None, NO_SINK),
        (lambda config, services: 1 / 0, "open raised ZeroDivisionError: division by zero"),
        (
            lambda config, services: SimpleNamespace(write=print),
            NO_SINK,
        ),
    ],
)
def test_a_plug_in_that_is_no_sink_is_one_line(monkeypatch, tmp_path, opened, said):
    plugin = SimpleNamespace(Config=DeviceOptions, open=opened)
    monkeypatch.setattr("ross_payload.plugins.load", lambda group, name: plugin)
    with pytest.raises(PluginError, match=r"sink 'theirs': ") as error:
        make_sink("theirs", DeviceOptions(), services(tmp_path))
    assert said in str(error.value)


def test_a_plug_in_without_config_is_one_line(monkeypatch):
    monkeypatch.setattr("ross_payload.plugins.load", lambda group, name: SimpleNamespace(open=print))
    with pytest.raises(PluginError, match="expected an object with Config, a Table, and open"):
        checked_options("theirs", {}, "options")


# ------------------------------------------------------------------------------------------------ sound outputs


class FakeOutput:
    """What the device sink uses of the module sounddevice, and the card behind it, which plays when it is told to."""

    PortAudioError = type("PortAudioError", (Exception,), {})

    def __init__(self):
        self.names = ["HDA Analog", "USB Headphones"]
        self.default = SimpleNamespace(device=[-1, 0])
        self.streams = []

    def query_hostapis(self):
        return [{"name": "ALSA"}]

    def query_devices(self):
        common = {"hostapi": 0, "max_input_channels": 0, "max_output_channels": 2, "default_samplerate": 48000.0}
        return [{"name": name, **common} for name in self.names]

    def OutputStream(self, **settings):  # noqa: N802 - its name
        stream = SimpleNamespace(active=False, played=[], **settings)
        stream.start = lambda: setattr(stream, "active", True)
        stream.close = lambda ignore_errors=True: setattr(stream, "active", False)
        self.streams.append(stream)
        return stream

    def play(self, n):
        """Let the card take so many samples; return them."""
        stream = self.streams[-1]
        out = np.full((n, stream.channels), 9.0, np.float32)
        stream.callback(out, n, None, None)
        assert np.array_equal(out[:, 0], out[:, 1])
        return out[:, 0]

    def unplug(self):
        self.names = []
        for stream in self.streams:
            stream.active = False


class AtOnce:
    def __init__(self, call):
        call()

    def join(self, timeout):
        pass


@pytest.fixture
def card():
    return FakeOutput()


@pytest.fixture
def headphones(card, tmp_path):
    return DeviceSink(DeviceOptions(device="usb", latency_ms=100), services(tmp_path), card, AtOnce)


def test_what_is_written_is_played_once_enough_waits(card, headphones):
    samples = voice(0.5)
    with headphones:
        assert card.streams[-1].device == 1
        headphones.write(VoiceBlock(samples[:HOP], 0, 0.0))
        assert not card.play(100).any()
        for block in blocks(samples[HOP : 8 * HOP], HOP):
            headphones.write(block)
        played = np.concatenate([card.play(128) for _ in range(4)])
    assert np.array_equal(played, samples[:512])
    assert headphones.lost == 0
    assert info_of(headphones).address == "USB Headphones"


def test_a_voice_that_comes_too_late_is_silence_and_counted(card, headphones):
    with headphones:
        for block in blocks(voice(0.128)):
            headphones.write(block)
        card.play(2000)
        late = card.play(100)
    assert not late[-52:].any()
    assert headphones.lost == 52


@pytest.mark.parametrize("share", [0.997, 1.003])
def test_a_card_with_another_crystal_neither_runs_dry_nor_falls_behind(card, headphones, share):
    samples, played = 0.5 * np.sin(2 * np.pi * 200 / RATE * np.arange(60 * RATE)).astype(np.float32), []
    with headphones:
        for block in blocks(samples):
            headphones.write(block)
            taken = round((block.index + HOP) * share) - sum(map(len, played))
            played.append(card.play(taken))
    assert headphones.lost == 0
    heard = np.concatenate(played)[RATE:]
    assert np.abs(np.diff(heard)).max() < 1.1 * 0.5 * 2 * np.pi * 200 / RATE  # no click


def test_what_a_card_did_not_take_in_time_is_left_out_instead_of_a_delay(card, headphones):
    samples, stopped, after = voice(3.0), RATE // 2, None
    with headphones:
        for block in blocks(samples):
            headphones.write(block)
            if block.index < RATE or block.index >= RATE + stopped:
                after = card.play(HOP)
        waiting = headphones._ring.waiting
        assert waiting <= 0.1 * RATE + HOP
        assert np.isin(after, samples[-waiting - 2 * HOP :]).all(), "it plays what was written lately"
        assert headphones.lost == pytest.approx(stopped, abs=2 * HOP)


def test_what_waits_while_a_card_is_opened_is_no_delay(card, headphones):
    samples = voice(1.0)
    with headphones:
        for block in blocks(samples):
            headphones.write(block)
        wanted = round(0.1 * RATE)
        assert np.array_equal(card.play(HOP), samples[-wanted:][:HOP])
        assert headphones.lost == len(samples) - wanted


def test_a_device_that_is_unplugged_is_a_fault_and_opened_again_when_it_is_back(card, headphones):
    with headphones:
        every = blocks(voice(60.0))
        headphones.write(next(every))
        card.unplug()
        headphones.write(next(every))
        assert headphones.fault == "the sound output 'USB Headphones' was disconnected"
        assert headphones.lost == HOP
        card.names = ["USB Headphones"]
        headphones.write(next(every))
        assert headphones.fault  # not tried again at once
        headphones._clock.ahead += 5.0
        headphones.write(next(every))
        assert headphones.fault == ""
        headphones.write(next(every))
        assert headphones.lost == 3 * HOP
        assert len(card.streams) == 2


def test_a_device_that_is_not_there_is_told_with_those_that_are(card, tmp_path):
    sink = DeviceSink(DeviceOptions(device="bluetooth"), services(tmp_path), card)
    expected = "device: no sound output named 'bluetooth'; there are: 'HDA Analog' (ALSA, 2 channels), 'USB Headphones'"
    with pytest.raises(AudioError) as error, sink:
        pass
    assert str(error.value).startswith(expected)


def test_silence_before_a_device_was_unplugged_stays_counted(card, headphones):
    with headphones:
        every = blocks(voice(60.0))
        while headphones._ring.waiting < 0.1 * RATE:
            headphones.write(next(every))
        card.play(2 * headphones._ring.waiting)
        silent = headphones.lost
        assert silent > 0
        card.unplug()
        headphones.write(next(every))
        assert headphones.lost == silent + HOP
