"""One contract for everything that a voice goes to; each kind adds its maker to `sink_bench.KINDS`."""

from __future__ import annotations

import contextlib
import socket
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from ross_payload.audio.sinks import checked_options, info_of, make_sink
from ross_payload.audio.sinks.device_sink import DeviceOptions
from ross_payload.errors import ConfigError, PluginError
from sink_bench import KINDS, blocks, services, voice

pytestmark = pytest.mark.process
NO_SINK = "expected open() to return an AudioSink, got one without write"
SLOW_S = 0.5  # one call of `write`; the computer is busy, and a second would be a hang


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
        (lambda config, services: sys.exit(0), "open raised SystemExit: 0"),
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
