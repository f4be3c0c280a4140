"""A mission that computes without a pause delays no heartbeat: the pump has a thread, and real-time priority."""

import threading
import time

import numpy as np

from ross_payload.clock import SystemClock
from ross_payload.config import Config, Link
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.mavlink import Router
from ross_payload.pointing import Pointing
from ross_payload.telemetry.component import Telemetry
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Decoder

PERIOD_S = 1.0
BEATS = 4


class Port:
    """Notes when a heartbeat passes."""

    def __init__(self):
        self.counts, self.beats, self._decoder = Counts(), [], Decoder()

    def send(self, frame):
        self.beats += [time.monotonic() for packet in self._decoder.feed(frame) if packet.name == "HEARTBEAT"]

    def receive(self):
        return []

    def close(self):
        pass


def test_a_computing_mission_delays_no_heartbeat():
    port, clock = Port(), SystemClock()
    with Router(clock, 1) as links:
        links.attach(Link(url="udpout:127.0.0.1:14550"), port)
        with Telemetry(Config(), clock, links) as telemetry:
            end = time.monotonic() + 30.0

            def mission():
                block = AudioBlock(np.zeros((2, 160), np.float32), 16000, 1.0)
                pointing = Pointing(joint=0.01, base=0.5, offset=-0.5, earth=True)
                telemetry.on_input(Input(block, 0.0, pointing, settled=False, attitude=Attitude(0.5, known=True)))
                matrix = np.eye(200)
                while len(port.beats) < BEATS and time.monotonic() < end:
                    matrix = matrix @ matrix

            thread = threading.Thread(target=mission)
            thread.start()
            thread.join()
    assert len(port.beats) >= BEATS
    assert max(np.diff(port.beats)) < 1.5 * PERIOD_S
