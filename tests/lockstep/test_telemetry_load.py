"""A whole mission over a line of 57,600 baud: it stays usable, and costs little."""

import os
import pty
import time
import tty
from collections import Counter
from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest

from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.config import Link
from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE
from ross_payload.health import AudioHealth
from ross_payload.mavlink import Router
from ross_payload.telemetry.component import Telemetry
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.tunnel import unwrap
from ross_sim.clock import SimClock
from ross_sim.sitl.mission_session import perform
from ross_sim.sitl.talker_selection import directed, talkers_of
from short_mission import SOON, brief

pytestmark = pytest.mark.lockstep

BYTES = 5760  # a second
URL = "serial:/dev/ttyRadio:57600"


class Capture:
    """Keeps what a mission hears and says."""

    def __init__(self):
        self.story = []

    def on_input(self, heard):
        self.story.append((None, heard))

    def on_event(self, event, heard):
        self.story.append((event, heard))

    def close(self):
        pass


class Line:
    """A serial line: counts what it carries, and brings what the ground says."""

    def __init__(self, clock):
        self.counts = Counts(baud=BYTES * 10)
        self.clock = clock
        self.frames = []
        self.arriving = []
        self.mavlink = ross.MAVLink(None, srcSystem=255, srcComponent=190)

    def send(self, frame):
        self.frames.append((self.clock.now(), frame))

    def receive(self):
        arrived, self.arriving = self.arriving, []
        return arrived

    def close(self):
        pass

    def call(self, message):
        self.arriving.append(message.pack(self.mavlink))
        self.mavlink.seq = (self.mavlink.seq + 1) % 256

    def load(self, seconds):
        """The busiest stretch of so many seconds, as a share of what the line can carry."""
        times = np.array([time for time, _ in self.frames])
        carried = np.concatenate([[0], np.cumsum([len(frame) for _, frame in self.frames])])
        ends = np.searchsorted(times, times + seconds)
        return max(carried[ends] - carried[:-1]) / seconds / BYTES

    def packets(self):
        """Everything that came down, with its time; what rode in a TUNNEL is taken out."""
        decoder = Decoder()
        for time_, frame in self.frames:
            for packet in decoder.feed(frame):
                yield time_, (unwrap(packet.message) or packet) if packet.name == "TUNNEL" else packet


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    five = brief("five-talkers", tmp_path_factory.mktemp("five"), explore=SOON)
    scenario = directed(five, {"actuator": None, "separator": "duet", "paper": False, "informed": False,
        "seed": None, "speech": None, "target": None, "urls": ()})  # fmt: skip
    capture = Capture()
    perform(scenario, talkers_of(scenario, None, None), capture, None, None)
    return scenario.payload, capture.story


def others():
    """CPU time of all other threads [s]."""
    return time.process_time() - time.thread_time()


def told(mission, role="ground", ask=None):
    """The line after the mission, and how many CPU seconds telemetry and links took; ``ask`` asks each second."""
    config, story = mission
    clock = SimClock()
    line = Line(clock)
    with Parameters(config) as parameters, Router(clock, 1) as links:
        links.attach(Link(url=URL, role=role), line)
        telemetry = Telemetry(
            config, clock, links, give=lambda order: None, parameters=parameters, health=lambda: AudioHealth(rate=16e3)
        )
        clock.every(0.01, links.poll)
        if ask is not None:
            clock.every(1.0, lambda: ask(line))
        with telemetry:
            started = time.process_time()
            for event, heard in story:
                if event is None:
                    telemetry.on_input(heard)
                    clock.advance()
                else:
                    telemetry.on_event(event, heard)
            used = time.process_time() - started
    return line, used / clock.now()


@pytest.mark.parametrize("role", ["ground", "autopilot"])
def test_a_mission_leaves_a_slow_line_half_empty(mission, role):
    line, cpu = told(mission, role)
    assert line.load(1.0) < 0.6
    assert line.load(10.0) < 0.3
    counts = Counter(packet.name for _, packet in line.packets())
    assert counts.keys() >= {
        "HEARTBEAT", "STATUSTEXT", "NAMED_VALUE_FLOAT", "DEBUG_FLOAT_ARRAY", "ROSS_STATUS", "ROSS_SOURCE",
        "ROSS_ALIGNMENT", "ROSS_SEPARATION", "ROSS_INFORMATION", "ROSS_AUDIO", "ROSS_DENSITY", "ROSS_ISOLATION",
    }  # fmt: skip
    statuses = [when for when, packet in line.packets() if packet.name == "ROSS_STATUS"]
    assert max(after - before for before, after in pairwise(statuses)) < 0.5
    assert cpu < 0.03


def test_a_peer_that_asks_for_everything_gets_no_more_than_the_budget(mission):
    def ask(line):
        for number in range(54001, 54009):
            line.call(ross.MAVLink_command_long_message(1, 191, 511, 0, number, 20_000, 0, 0, 0, 0, 0))
        line.call(ross.MAVLink_param_request_list_message(1, 191))

    line, _ = told(mission, ask=ask)
    assert line.load(10.0) < 0.6
    names = Counter(packet.name for _, packet in line.packets())
    beats = [when for when, packet in line.packets() if packet.name == "HEARTBEAT"]
    statuses = [when for when, packet in line.packets() if packet.name == "ROSS_STATUS"]
    assert max(after - before for before, after in pairwise(beats)) < 1.5
    assert max(after - before for before, after in pairwise(statuses)) < 1.5
    assert names["COMMAND_ACK"] > 100, "whoever commands is answered"
    assert names["PARAM_VALUE"] > 10 * len(TABLE)


@pytest.mark.soak
def test_in_real_time_three_links_and_their_telemetry_take_less_than_5_percent_of_a_core(mission):
    """The pump and its waking up, with a serial line and two UDP ports; the thread that feeds it does not count."""
    config, story = mission
    far, near = pty.openpty()
    tty.setraw(near)
    os.set_blocking(far, False)
    wanted = (
        Link(url=f"serial:{os.ttyname(near)}:57600", role="autopilot"),
        Link(url="udpout:127.0.0.1:9"),
        Link(url=f"udpin:127.0.0.1:{free_port()}"),
    )
    clock = SystemClock()
    started, begun = others(), clock.now()
    with Router.open(wanted, clock) as links, Telemetry(config, clock, links, health=AudioHealth) as telemetry:
        cancel = clock.every(0.01, links.poll)
        for event, heard in story:
            if event is not None:
                telemetry.on_event(event, heard)
                continue
            telemetry.on_input(heard)
            clock.sleep(begun + heard.block.time - clock.now())
            with suppress(BlockingIOError):
                os.read(far, 65536)
        cancel()
        sent = [link.sent for link in links.status()]
    lasted = clock.now() - begun
    used = (others() - started) / lasted
    os.close(far)
    os.close(near)
    assert min(sent) > 10 * lasted
    assert used < 0.05, f"{used:.2%}"
