"""An hour of live listening, from the microphones to the ground: with --rows, the rows of measured-live.md.

Time is simulated: a mixture that was rendered before, live separation, the listening stage, and streams to a file, over
TCP and over RTP through a network that loses packets. Every minute the mission explores, turns and listens.
"""

import contextlib
import gc
import heapq
import os
import resource
import socket
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import soundfile
from threadpoolctl import threadpool_limits

from clocks import FakeClock
from listening_bench import HOP, RATE, TARGET, Bench
from lossy_network import Network, voiced
from ross_payload.audio.sinks import SinkInfo, SinkServices, checked_options, make_sink
from ross_payload.events import State, StateChanged
from ross_payload.interfaces import AudioBlock
from ross_payload.listening.sink_runner import DirectRunner
from ross_payload.plugin_checks import load_separator
from ross_payload.pointing import Pointing
from ross_payload.transport.rtp.receiver import RtpReceiver
from ross_payload.transport.rtp.session_description import Media
from ross_protocols.audio.pcm import Decoder
from ross_sim.study.rows.long_run_rows import ListeningMinute

MINUTES = 60
LOOP_S = 40  # after which the mixture begins again, not in step with the mission
EXPLORED_S, TURNED_S = 36.0, 2.0  # of every minute
DELAYS = (-1.5, 0.4, 1.9)  # of the voices between the microphones [samples]
NETWORK = Network(loss=0.02, jitter=0.02)
PACKET = 320  # samples
GROWTH_MB = 8.0
DRIFT_S = 0.005
WALL = 1.7e9  # time of day at the beginning [s]


def mixture():
    """Three voices and noise at both microphones, (2, n)."""
    n = LOOP_S * RATE
    rng, frequencies, heard = np.random.default_rng(0), np.fft.rfftfreq(n, 1), np.zeros((2, n))
    for number, delay in enumerate(DELAYS):
        spectrum = np.fft.rfft(np.roll(voiced(LOOP_S, RATE, seed=number), 9000 * number))
        heard += np.stack([np.fft.irfft(spectrum * np.exp(2j * np.pi * frequencies * late), n) for late in (0, delay)])
    return (0.2 * heard + 1e-3 * rng.standard_normal((2, n))).astype(np.float32)


class Air:
    """A sink that sends over a simulated network, and who receives it on the ground."""

    def __init__(self, clock):
        from ross_payload.audio.sinks.rtp_sender import RtpSender

        self._clock, self._rng, self._order = clock, np.random.default_rng(1), count()
        self._sender = RtpSender(RATE, Media.of("opus", RATE), 48000)
        self.receiver = RtpReceiver(Media.of("opus", RATE))
        self._wire = []
        self.samples = self.sent = self.again = self.dropped = 0
        self.loss = NETWORK.loss
        self.fault, self.lost, self.info = "", 0, SinkInfo("127.0.0.1", 5004, "opus", RATE)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def write(self, block):
        self.samples += len(block.samples)
        for packet in self._sender.packets(block):
            self.sent += 1
            self._transmit("out", packet)

    def pass_time(self, until):
        """Let what is under way arrive, and play what came."""
        now = self._clock.now()
        if (report := self._sender.report(now, WALL + now)) is not None:
            self._transmit("report", report)
        while self._wire and self._wire[0][0] < until:
            when, _, way, packet = heapq.heappop(self._wire)
            if way != "back":
                self.receiver.on_datagram(packet, when, "payload")
            else:
                for each in self._sender.on_report(packet, when):
                    self.again += 1
                    self._transmit("out", each)
        self.receiver.read(HOP, until)
        for report in self.receiver.feedback(until):
            self._transmit("back", report)

    def _transmit(self, way, packet):
        if self._rng.random() < self.loss:
            self.dropped += way == "out"
        else:
            late = NETWORK.delay + NETWORK.jitter * self._rng.random()
            heapq.heappush(self._wire, (self._clock.now() + late, next(self._order), way, packet))


class Chain(Bench):
    """A stage with the separator that is shipped, and sinks that are real but for the network."""

    def __init__(self, folder):
        self.clock, self.sinks = FakeClock(), {}
        self._folder = folder
        self._sound = mixture()
        super().__init__(dict.fromkeys(range(3), TARGET), separator=load_separator("auto").live(1))

    def _open(self, settings):
        def make():
            if settings.number == 2:
                sink = Air(self.clock)
            else:
                kind, options = (("file", {"path": "heard.flac"}), ("tcp", {"port": self.port}))[settings.number]
                services = SinkServices(self.clock, RATE, settings.number, "target", self._folder, live=False)
                sink = make_sink(kind, checked_options(kind, options, kind), services)
            self.sinks[settings.number] = sink
            return sink

        return DirectRunner(f"stream {settings.number}", make, self.clock)

    port = 0

    def hear_hop(self, *, settled):
        at = self.index % self._sound.shape[1]
        self.clock.time = (self.index + HOP) / RATE
        block = AudioBlock(self._sound[:, at : at + HOP], self.index, self.index / RATE)
        self.stage.hear(block, Pointing(joint=self.heading), settled=settled)
        self.index += HOP


class TcpListener:
    """Takes what comes whenever it is asked to, and counts it."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port), 20)
        self._socket.setblocking(False)
        self._decoder, self.samples = Decoder(), 0

    def take(self):
        with contextlib.suppress(BlockingIOError):
            while data := self._socket.recv(1 << 16):
                self.samples += len(self._decoder.feed(data))

    def close(self):
        self._socket.close()


def resident_mb():
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def minute(chain, listener, number):
    """Explore, turn to another heading and listen there; how old is what the ground plays, on average [s]."""
    chain.say(StateChanged(0.0, State.EXPLORE_LISTEN))
    chain.know()
    ages = []
    for hop in range(60 * RATE // HOP):
        now = hop * HOP / RATE
        turning = EXPLORED_S <= now < EXPLORED_S + TURNED_S
        if turning:
            chain.heading += (0.004, -0.004)[number % 2]
        elif now == EXPLORED_S + TURNED_S:
            chain.listen_to(number % 3)
        chain.hear_hop(settled=not turning)
        air = chain.sinks[2]
        air.pass_time(chain.clock.now())
        if listener is not None:
            listener.take()
        if now > EXPLORED_S and (age := air.receiver.total_delay(WALL + chain.clock.now())) is not None:
            ages.append(age)
    return float(np.mean(ages))


@pytest.mark.soak
@threadpool_limits.wrap(limits=1)
def test_an_hour_grows_no_memory_loses_no_count_and_no_time(tmp_path, free_port, written):
    Chain.port = free_port()
    chain, spent = Chain(tmp_path), resource.getrusage(resource.RUSAGE_SELF).ru_utime
    while not chain.sinks:
        chain.hear_hop(settled=True)
    before = chain.sinks[2].samples
    listener = TcpListener(Chain.port)
    rows, separated = [], []
    for number in range(MINUTES):
        age = minute(chain, listener, number)
        rows.append(ListeningMinute(number + 1, round(resident_mb(), 1), round(age, 4)))
        separated.append(chain.status(0).separated)
    written("listening.csv", rows)
    chain.sinks[2].loss = 0.0  # that a packet is lost is known when a later one comes
    chain.stage.finish()
    listener.take()
    listener.close()
    air, heard = chain.sinks[2], chain.index
    air.pass_time(chain.clock.now() + 1.0)
    reception = air.receiver.reception(chain.clock.now() + 1.0)
    spent = resource.getrusage(resource.RUSAGE_SELF).ru_utime - spent
    packets = f"{air.sent} packets, {air.dropped} dropped, {air.again} sent once more"
    print(f"{packets}, {reception}; {spent / 60 / MINUTES:.3f} s/s")  # noqa: T201
    assert all(separated)
    assert rows[-1].memory_mb < rows[9].memory_mb + GROWTH_MB
    assert air.samples == heard
    assert air.sent == heard // PACKET
    assert reception.received + reception.lost == air.sent
    assert air.dropped - air.again <= reception.lost <= air.dropped
    ages = [row.age_s for row in rows]
    assert abs(np.mean(ages[-5:]) - np.mean(ages[5:10])) < DRIFT_S
    assert soundfile.info(tmp_path / "heard.flac").frames == heard
    assert listener.samples == heard - before
    assert chain.sinks[0].lost == chain.sinks[1].lost == 0
