"""A peer that does not stop talking: the payload hears every sample and says once a second that it is there."""

import math
import os
import socket
import subprocess
import sys
import threading
import time
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from examples import in_soak
from ross_protocols.audio.pcm import Header, encode, encode_header
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Audio, Heartbeat
from waiting import wait_for

pytestmark = pytest.mark.alone
ACCEPTED = 0  # MAV_RESULT
STOP = 54004
FLOOD = 30_000  # frames/s
RATE, PIECE = 16000, 320  # [Hz], samples
ENDLESS = """
import signal, socket, sys, time
over = []
signal.signal(signal.SIGTERM, lambda number, frame: over.append(number))
frames, (host, port) = open(sys.argv[1], "rb").read().split(b"|||"), sys.argv[2].split(":")
rate = float(sys.argv[4])
count, burst = float(sys.argv[3]) * rate, 50
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
    begin, sent = time.monotonic(), 0
    while sent < count and not over:
        for _ in range(burst):
            sock.sendto(frames[sent % len(frames)], (host, int(port)))
            sent += 1
        time.sleep(max(begin + sent / rate - time.monotonic(), 0))
    print(sent / (time.monotonic() - begin))
"""


class Microphones:
    """Two channels of noise over TCP, in real time."""

    def __init__(self):
        samples = np.random.default_rng(0).normal(0, 0.01, (RATE, 2)).astype(np.float32)
        header = Header(RATE, 2)
        self._pieces = [encode(samples[at : at + PIECE], header.format) for at in range(0, RATE, PIECE)]
        self._header = encode_header(header)
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = self._server.getsockname()[1]
        self._thread = threading.Thread(target=self._play)
        self._thread.start()

    def _play(self):
        payload, _ = self._server.accept()
        with payload:
            begin, count = time.monotonic(), 0
            try:
                payload.sendall(self._header)
                while True:
                    payload.sendall(self._pieces[count % len(self._pieces)])
                    count += 1
                    time.sleep(max(begin + count * PIECE / RATE - time.monotonic(), 0))
            except OSError:
                return  # the payload is gone

    def close(self):
        self._server.close()
        self._thread.join()


class Listener:
    """A ground station that notes when it hears what."""

    def __init__(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.05)
        self.port = self._socket.getsockname()[1]
        self._decoder = Decoder()
        self.beats, self.audio = [], []

    def listen(self):
        try:
            packets = self._decoder.feed(self._socket.recv(2048))
        except TimeoutError:
            return
        self.beats += [time.monotonic() for packet in packets if isinstance(packet.value, Heartbeat)]
        self.audio += [packet.value for packet in packets if isinstance(packet.value, Audio)]

    def close(self):
        self._socket.close()


def chatter():
    """A second of what a peer may say: half of it asks for an answer."""
    encoder = Encoder(9, 1)
    ask = {"param1": 54001, **{f"param{index}": 0 for index in range(2, 8)}}
    kinds = [
        common.MAVLink_attitude_message(1, 0.1, 0.2, 0.3, 0, 0, 0),
        common.MAVLink_param_request_list_message(1, 191),
        common.MAVLink_global_position_int_message(1, 2, 3, 4, 5, 6, 7, 8, 9),
        common.MAVLink_command_long_message(1, 191, 512, 0, **ask),
    ]
    return b"|||".join(encoder.encode(kinds[index % len(kinds)]) for index in range(1024))


def preferred(pid):
    """Let a process go before others, as its service does, where we may."""
    if os.geteuid() == 0:
        for task in Path(f"/proc/{pid}/task").iterdir():
            os.setpriority(os.PRIO_PROCESS, int(task.name), -5)


@pytest.fixture
def microphones():
    microphones = Microphones()
    yield microphones
    microphones.close()


@pytest.fixture
def ground():
    ground = Listener()
    yield ground
    ground.close()


def flooded(payload, ground, port, frames, seconds):
    """Flood; return how many messages came a second, the longest time without a heartbeat, and the samples lost."""
    preferred(payload.process.pid)
    command = [sys.executable, "-c", ENDLESS, frames, f"127.0.0.1:{port}", str(seconds), "5000"]
    until_heard(ground, 1)
    lost, begun = ground.audio[-1].lost, time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as peer:
        while peer.poll() is None:
            ground.listen()
        rate = float(peer.communicate()[0])
    until_heard(ground, len(ground.audio) + 2)
    beats = [begun, *(beat for beat in ground.beats if beat > begun)]
    gap = max(later - sooner for sooner, later in pairwise(beats))
    return rate, gap, ground.audio[-1].lost - lost


def until_heard(ground, count):
    def heard():
        ground.listen()
        return len(ground.audio) >= count

    wait_for(heard, what="what is heard of the microphones")


@pytest.fixture
def endure(ross_run, free_port, microphones, ground, tmp_path):
    """Let a payload endure a flood of so many seconds; see `flooded`."""

    def run(seconds):
        port, frames = free_port(), tmp_path / "frames"
        frames.write_bytes(chatter())
        links = [f'url = "udpout:127.0.0.1:{ground.port}"', f'url = "udpin:127.0.0.1:{port}"']
        with ross_run(tmp_path, *links, source=f"tcp:127.0.0.1:{microphones.port}") as payload:
            rate, gap, lost = flooded(payload, ground, port, frames, seconds)
        print(f"{rate:.0f} messages/s for {seconds} s: {gap:.2f} s between heartbeats, {lost} samples lost")  # noqa: T201
        return rate, gap, lost

    return run


@pytest.mark.soak
def test_a_flood_costs_no_sample_and_no_heartbeat(endure):
    rate, gap, lost = endure(10)
    assert rate > 4900
    assert lost == 0
    assert gap < 1.5


class Pilot:
    """A ground station that stops, and arms again."""

    def __init__(self, port):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._socket.settimeout(0.02)
        self._encoder, self._decoder = Encoder(255, 190), Decoder()

    def close(self):
        self._socket.close()

    def answered(self, number, patience, again=math.inf):
        """Give a command, and once more every ``again`` [s] until it is answered, as a ground station does.

        How long until it is accepted [s], or None after ``patience`` [s].
        """
        begin, sent = time.monotonic(), 0
        while (passed := time.monotonic() - begin) < patience:
            if passed >= (sent and sent * again):
                asked = common.MAVLink_command_long_message(1, 191, number, sent, *[0.0] * 7)
                self._socket.send(self._encoder.encode(asked))
                sent += 1
            try:
                packets = self._decoder.feed(self._socket.recv(2048))
            except OSError:
                continue
            acks = [packet.message for packet in packets if packet.name == "COMMAND_ACK"]
            if any(ack.command == number and ack.result == ACCEPTED for ack in acks):
                return time.monotonic() - begin
        return None


@pytest.fixture
def stopped(ross_run, free_port, tmp_path):
    """Stop a payload so many times while somebody floods a link with 30,000 frames/s.

    How long until each stop was accepted [s], and at what rate the frames came [1/s].
    """

    def run(count, on_the_same_link, **again):
        flooded_port, other, frames = free_port(), free_port(), tmp_path / "frames"
        frames.write_bytes(chatter())
        links = [f'url = "udpin:127.0.0.1:{port}"' for port in (flooded_port, other)]
        seconds = 2 + count * 0.3
        command = [sys.executable, "-c", ENDLESS, frames, f"127.0.0.1:{flooded_port}", str(seconds), str(FLOOD)]
        with ross_run(tmp_path, *links) as payload:
            preferred(payload.process.pid)
            pilot = Pilot(flooded_port if on_the_same_link else other)
            with closing(pilot), subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as peer:
                time.sleep(1.0)  # let the buffers fill
                times = []
                for _ in range(count):
                    times.append(pilot.answered(STOP, **{"patience": 1.0} | again))
                    time.sleep(0.1)
                peer.terminate()
                rate = float(peer.communicate()[0])
        heard = sorted(passed for passed in times if passed is not None)
        where = "on the same link" if on_the_same_link else "on another link"
        told = f"median {1e3 * heard[len(heard) // 2]:.0f}, max {1e3 * heard[-1]:.0f} ms" if heard else "none"
        print(f"{rate:.0f} frames/s, stop {where}: {len(heard)} of {count}, {told}")  # noqa: T201
        return times, rate

    return run


@pytest.mark.parametrize("on_the_same_link", [*in_soak(False), True], ids=["other", "same"])
def test_stops_are_heard_through_a_flood(stopped, on_the_same_link):
    """A stop is given until it is answered: the system may drop a datagram while the payload waits for a processor."""
    times, rate = stopped(3, on_the_same_link, patience=5.0, again=0.2)
    assert rate > 2500, "this computer is too busy to flood"
    assert None not in times


@pytest.mark.soak
@pytest.mark.parametrize("on_the_same_link", [False, True], ids=["other", "same"])
def test_a_hundred_stops_are_heard_through_a_flood(stopped, on_the_same_link):
    times, rate = stopped(100, on_the_same_link, patience=5.0, again=0.5)
    assert rate > 0.9 * FLOOD
    assert None not in times
    assert max(times) < 1.5, "one that is lost comes again after 0.5 s"
