"""A world in real time: it keeps up or says that it does not, its sound is whole, its truth is what was heard."""

from __future__ import annotations

import json
import math
import os
import socket
import stat

import numpy as np
import pytest
import soundfile

from clocks import FakeClock
from ross_payload.errors import ConfigError, LinkError
from ross_protocols.audio.pcm import Decoder, decode
from ross_sim.clock import BEHIND, QUANTUM, RealTimeDriver, SimClock
from ross_sim.live_world.audio_output import Fifo, PcmServer
from ross_sim.live_world.world_session import later
from ross_sim.scenario import load
from ross_sim.sitl.ground_truth import TruthWriter, Turns
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.world import Rendered
from world_truth import read_truth

RATE = 16000


def samples(n, seed=1):
    counts = np.random.default_rng(seed).integers(-(2**22), 2**22, (2, n))
    return (counts / 2**23).astype(np.float32)


def drained(connection, decoder, n):
    connection.settimeout(10)
    got = np.zeros((0, 2), np.float32)
    while len(got) < n:
        frames = decoder.feed(connection.recv(65536))
        got = np.concatenate([got, frames.reshape(-1, 2)])
    return got.T


# ---------------------------------------------------------------------------------------------------- time


def test_a_quantum_is_lived_when_it_is_over_and_what_was_sent_has_had_time_to_arrive():
    wall, clock, said = FakeClock(100.0), SimClock(), []
    real_time = RealTimeDriver(clock, wall, said.append)
    begins = []
    for _ in range(3):
        real_time.step(begins.append, lambda: None)
    assert begins == pytest.approx([0.0, QUANTUM, 2 * QUANTUM])
    assert wall.time == pytest.approx(100.0 + 3 * QUANTUM + BEHIND)
    assert (said, real_time.worst) == ([], pytest.approx(0.0, abs=1e-9))


def test_a_world_that_is_late_says_by_how_much_once_in_a_while_and_catches_up():
    wall, clock, said = FakeClock(100.0), SimClock(), []
    real_time = RealTimeDriver(clock, wall, said.append)

    def slow():
        wall.time += 0.5

    for _ in range(3):
        real_time.step(lambda begin: None, slow)
    assert len(said) == 1
    assert "0.50 s late" in said[0]
    for _ in range(200):
        real_time.step(lambda begin: None, lambda: None)
    assert real_time.worst == pytest.approx(3 * 0.5 - 2 * QUANTUM)
    assert wall.time == pytest.approx(100.0 + clock.now() + BEHIND)


# ---------------------------------------------------------------------------------------------------- sound


@pytest.mark.parametrize("form", ["s16le", "s24le", "f32le"])
def test_a_listener_hears_every_sample_from_its_connection_on(form):
    outlet = PcmServer("127.0.0.1", 0, RATE, form)
    try:
        outlet.put(samples(160))
        assert not outlet.used
        with socket.create_connection(("127.0.0.1", outlet.port), 10) as listener:
            wanted = [samples(160, seed) for seed in range(5)]
            for quantum in wanted:
                outlet.put(quantum)
            decoder = Decoder()
            got = drained(listener, decoder, 800)
        assert outlet.used
        assert (decoder.header.rate, decoder.header.channels, decoder.header.format) == (RATE, 2, form)
        np.testing.assert_allclose(got, np.concatenate(wanted, axis=1), atol=2**-16 if form == "s16le" else 0)
    finally:
        outlet.close()


def test_a_world_is_heard_over_ipv6_too():
    outlet = PcmServer("::1", 0, RATE, "s24le")
    try:
        with socket.create_connection(("::1", outlet.port), 10) as listener:
            outlet.put(samples(160))
            assert np.array_equal(drained(listener, Decoder(), 160), samples(160))
    finally:
        outlet.close()


def test_a_listener_that_leaves_hurts_no_other():
    outlet = PcmServer("127.0.0.1", 0, RATE, "s24le")
    try:
        with socket.create_connection(("127.0.0.1", outlet.port), 10) as stays:
            socket.create_connection(("127.0.0.1", outlet.port), 10).close()
            for seed in range(200):
                outlet.put(samples(160, seed))
            got = drained(stays, Decoder(), 200 * 160)
        assert np.array_equal(got[:, -160:], samples(160, 199))
        assert outlet.lost == 0
    finally:
        outlet.close()


def test_a_listener_that_does_not_read_is_hung_up_on_and_what_it_missed_is_counted():
    outlet = PcmServer("127.0.0.1", 0, RATE, "f32le")
    try:
        with socket.create_connection(("127.0.0.1", outlet.port), 10):
            for seed in range(150):
                outlet.put(samples(RATE, seed))
        assert outlet.lost >= 30 * RATE
    finally:
        outlet.close()


def test_a_taken_port_is_one_clear_line():
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(LinkError, match="cannot listen"):
        PcmServer("127.0.0.1", taken.getsockname()[1], RATE, "s24le")


def test_a_pipe_gives_every_sample_to_a_reader_that_keeps_up(tmp_path):
    outlet = Fifo(tmp_path / "pcm", RATE, "s24le")
    try:
        assert stat.S_ISFIFO((tmp_path / "pcm").stat().st_mode)
        reader = os.open(tmp_path / "pcm", os.O_RDONLY | os.O_NONBLOCK)
        wanted, got = [samples(160, seed) for seed in range(50)], b""
        for quantum in wanted:
            outlet.put(quantum)
            got += os.read(reader, 65536)
        os.close(reader)
        assert np.array_equal(decode(got, "s24le", 2).T, np.concatenate(wanted, axis=1))
        assert outlet.lost == 0
    finally:
        outlet.close()


def test_a_pipe_that_nobody_reads_loses_whole_samples_and_counts_them(tmp_path):
    outlet = Fifo(tmp_path / "pcm", RATE, "f32le")
    try:
        for _ in range(40):
            outlet.put(samples(RATE))
        held = 4096 // 8
        assert outlet.lost == 40 * RATE - 30 * RATE - held
    finally:
        outlet.close()


def test_a_file_that_is_no_pipe_is_left_alone(tmp_path):
    (tmp_path / "pcm").write_text("mine")
    with pytest.raises(ConfigError, match="not a named pipe"):
        Fifo(tmp_path / "pcm", RATE, "s24le")
    assert (tmp_path / "pcm").read_text() == "mine"


# ---------------------------------------------------------------------------------------------------- truth


def test_the_truth_is_written_in_pieces_and_read_back_whole(tmp_path):
    pieces = [samples(4000, seed) for seed in range(3)]
    headings = np.radians([0, 0, 1, 2, 2])
    values = {"target": "b", "talkers": [{"name": name, "azimuth_deg": 40, "elevation_deg": 0} for name in "ab"]}
    with ResultsFolder(tmp_path / "out") as folder, TruthWriter(folder, RATE, 2) as truth:
        for piece in pieces:
            truth.write(Rendered(np.stack([piece / 4, piece / 2], axis=1), piece, headings))
        truth.finish(values)
    read = read_truth(tmp_path / "out")
    heard = np.concatenate(pieces, axis=1)
    assert np.array_equal(read.mixture, heard[0])
    assert np.abs(read.images[1] - heard[0] / 2).max() <= 2**-23
    assert (read.names, read.target) == (("a", "b"), "b")
    assert soundfile.info(tmp_path / "out" / "image-1.wav").channels == 2
    assert json.loads((tmp_path / "out" / "truth.json").read_text())["samples"] == 12000


def test_a_turn_is_told_where_it_begins_and_ends_however_it_is_cut():
    path = np.radians([5.0] * 50 + list(np.linspace(5, 30, 40)) + [30.0] * 60)
    whole, cut = Turns(), Turns()
    whole.follow(path)
    for first in range(0, len(path) - 1, 7):
        cut.follow(path[first : first + 8])
    assert whole.points() == cut.points()
    times, angles = np.array(whole.points()).T
    np.testing.assert_allclose(np.interp(np.arange(len(path)) * QUANTUM, times, angles), np.degrees(path), atol=1e-3)
    assert len(times) < 50


def test_a_later_scenario_is_the_same_but_later():
    scenario = load("restart")
    shifted = later(scenario, 3.0)
    for before, after in zip(scenario.talkers, shifted.talkers, strict=True):
        assert shifted.start(after) == scenario.start(before) + 3.0
        assert (after.end_s or math.inf) == (before.end_s or math.inf) + 3.0
        assert after.pauses == tuple((begin + 3.0, end + 3.0) for begin, end in before.pauses)
    assert shifted.azimuths() == scenario.azimuths()
