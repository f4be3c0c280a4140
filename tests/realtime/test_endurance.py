"""The payload lives long: tasks, links and microphones come and go, nothing grows, and every lost sample is counted."""

import json
import os
import socket
import subprocess
import threading
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common
from ross_sim.study.rows.long_run_rows import PayloadRun
from waiting import wait_for

LOOPBACK = "127.0.0.1"
RATE = 16000
MINUTES = float(os.environ.get("ROSS_SOAK_MINUTES", "60"))
UNPLUGGED = 0.15  # of the days
HEARD_OUT = 0.4  # of the days: a separation
WARM = 8 * 60.0  # [s] until the histories that are bounded are full
WINDOW = 120  # looks, one a second
RECORD, TURN, STOP, CANCEL, REARM, HOME = 54008, 54003, 54004, 54005, 54009, 54010
EXPLORE, LISTEN = 54000, 54001
CONFIG = """
[audio]
source = "tcp:{host}:{pcm}"
[actuator]
kind = "tb6600"
options = {{ port = "{wire}", ahead_ms = 100 }}
[explore]
unit_s = 0.5
min_rotations = 2
max_rotations = 2
[exploit]
check_s = 1.0
run_s = 2.0
[service]
state_dir = "state"
log_format = "json"
[[links]]
url = "udpin:{host}:{udp}"
[[links]]
url = "tcpin:{host}:{tcp}"
"""


class Relay:
    """Stands between world and payload: a sound card that can be unplugged."""

    def __init__(self, there):
        self._there = there
        self._listener = socket.create_server((LOOPBACK, 0))
        self.port = self._listener.getsockname()[1]
        self._sockets = []
        self._last = None  # when something was carried last
        self.missing = 0.0  # between two connections [s]
        self._plugged, self._over = threading.Event(), threading.Event()
        self._plugged.set()
        self._thread = threading.Thread(target=self._serve, name="relay")

    def _serve(self):
        while not self._over.is_set():
            try:
                near = self._listener.accept()[0]
            except OSError:
                return
            if self._plugged.is_set():
                self._carry(near)
            near.close()

    def _carry(self, near):
        with socket.create_connection(self._there) as far:
            self._sockets = [near, far]
            try:
                data = far.recv(65536)
                self.missing += 0.0 if self._last is None else time.monotonic() - self._last
                while data:
                    near.sendall(data)
                    self._last = time.monotonic()
                    data = far.recv(65536)
            except OSError:
                return

    def unplug(self, seconds):
        """Vanish; whoever knocks meanwhile is turned away."""
        self._plugged.clear()
        self._hang_up()
        time.sleep(seconds)
        self._plugged.set()

    def _hang_up(self):
        for each in self._sockets:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                continue

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *reason):
        self._over.set()
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._hang_up()
        self._thread.join(10)


class Watch:
    """Looks at a process once a second."""

    def __init__(self, pid):
        self._root = Path(f"/proc/{pid}")
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, name="watch")
        self.rows = []  # time [s], resident [MB], threads, descriptors, CPU of all and of the pump [s]

    def _look(self):
        while not self._over.wait(1.0):
            fields = dict(line.split(":", 1) for line in (self._root / "status").read_text().splitlines())
            resident, threads = int(fields["VmRSS"].split()[0]) / 1024, int(fields["Threads"])
            cpu = [(urgent, spent) for urgent, spent in map(cpu_of, self._root.glob("task/*/stat"))]
            pump = sum(spent for urgent, spent in cpu if urgent)
            files = len(list((self._root / "fd").iterdir()))
            row = time.monotonic(), resident, threads, files, cpu_of(self._root / "stat")[1], pump
            self.rows.append(row)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *reason):
        self._over.set()
        self._thread.join(10)

    def columns(self, since=0.0):
        """The columns of the table from ``since`` [s] after its beginning on."""
        table = np.array(self.rows)
        return table[table[:, 0] >= table[0, 0] + since].T


def cpu_of(stat):
    """Whether a thread is urgent, and its CPU time [s]."""
    try:
        words = stat.read_text().rpartition(")")[2].split()
    except OSError:  # it has just ended
        return False, 0.0
    return words[38] == "2", (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


@pytest.fixture
def bench(tmp_path, process, ground_station, free_port):
    """A world, a payload, a ground station, and somebody who watches."""
    with ExitStack() as stack:
        world = ["world", "demo", "--json", "--pcm", f"tcp:{LOOPBACK}:0"]
        told = json.loads(
            stack.enter_context(process(world, tmp_path, "world", stdout=subprocess.PIPE)).stdout.readline()
        )
        relay = stack.enter_context(Relay((LOOPBACK, int(told["pcm"].rpartition(":")[2]))))
        ports = {"udp": free_port(), "tcp": free_port()}
        config = CONFIG.format(host=LOOPBACK, pcm=relay.port, wire=told["wire"], **ports)
        (tmp_path / "ross.toml").write_text(config)
        payload = stack.enter_context(process(["run", "ross.toml"], tmp_path, "payload"))
        ground = stack.enter_context(ground_station(ports["udp"]))
        wait_for(lambda: "ROSS_AUDIO" in ground.latest and ground.latest["ROSS_AUDIO"].level[0] > -100)
        yield relay, ground, stack.enter_context(Watch(payload.pid)), ports


def peers_come_and_go(ports):
    """A TCP client that resets its connection, and a UDP peer that says one word and leaves."""
    beat = Encoder(254, 190).encode(common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    with socket.create_connection((LOOPBACK, ports["tcp"])) as client:
        client.sendall(beat)
        client.recv(100)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\x00\x00\x00\x00\x00\x00\x00")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.sendto(beat, (LOOPBACK, ports["udp"]))


def armed(ground):
    """Arm again after a stop, or after a fault: a computer that is too busy loses the motor's position."""
    if ground.order(REARM) != 0:
        ground.order(HOME)
        ground.order(REARM)


def day(ground, rng, ports, longest=4.0):
    """Some of what a day brings, in any order; return how the tasks ended. ``longest`` [s] nothing is asked."""
    heading = rng.uniform(-170, 170)
    ends = [ground.order(RECORD, 1), ground.order(EXPLORE)]
    if rng.random() < HEARD_OUT:
        ends.append(ground.order(LISTEN, 1, 0))
    ground.order(LISTEN, 1, 0, wait=0)
    peers_come_and_go(ports)
    time.sleep(rng.uniform(0.5, longest))
    ends.append(ground.order(CANCEL))
    time.sleep(0.3)  # until the task is over
    ends += [ground.order(TURN, heading), ground.order(RECORD, 0)]
    ground.order(TURN, heading - 180, wait=0)
    time.sleep(rng.uniform(0.2, 1.0))
    ends.append(ground.order(STOP))
    armed(ground)
    return ends


@pytest.mark.soak
def test_a_short_life_leaves_nothing_behind_and_counts_what_it_did_not_hear(bench):
    relay, ground, watch, ports = bench
    wait_for(lambda: len(watch.rows) >= 1)
    lost = ground.latest["ROSS_AUDIO"].lost
    before = watch.columns()
    relay.unplug(1.0)
    ends = day(ground, np.random.default_rng(0), ports, longest=1.0)
    assert ends[0] == ends[-1] == 0

    def as_before():
        _, _, threads, files, _, _ = watch.columns()
        more = threads[-1] - before[2][-1]
        return more <= 1 and files[-1] == before[3][-1]  # the first stop has begun the thread that saves it

    wait_for(as_before, what=lambda: f"as many files as before: {before[3][-1]}, not {watch.columns()[3][-1]}")
    wait_for(lambda: ground.latest["ROSS_AUDIO"].reopened >= 1 and ground.latest["ROSS_AUDIO"].waiting < 1.0)
    assert 0.8 * RATE < ground.latest["ROSS_AUDIO"].lost - lost < 6 * RATE


@pytest.mark.soak
@pytest.mark.timeout(MINUTES * 60 + 600)
def test_an_hour_of_tasks_links_and_microphones_that_come_and_go_grows_nothing(bench, capsys, written):
    relay, ground, watch, ports = bench
    rng, end, ends, outages = np.random.default_rng(1), time.monotonic() + MINUTES * 60, [], 0
    while time.monotonic() < end:
        ends += day(ground, rng, ports)
        if rng.random() < UNPLUGGED:
            relay.unplug(rng.uniform(0.5, 5.0))
            outages += 1
    time.sleep(5.0)
    audio = ground.latest["ROSS_AUDIO"]
    run = PayloadRun(
        **account(watch.columns(WARM)),
        orders=len(ends),
        accepted=ends.count(0),
        unplugged=outages,
        reopened=audio.reopened,
        missing_s=round(relay.missing, 2),
        lost_s=round(audio.lost / RATE, 2),
        silence_s=round(ground.silence, 2),
    )
    written("endurance.csv", [run])
    with capsys.disabled():
        print(run)  # noqa: T201
    assert run.growth_mb < 15.0
    assert run.threads_first == run.threads_last
    assert run.files_last <= run.files_first + 1  # the microphones may have been unplugged in the first minutes alone
    assert run.pump < 0.06  # motor, links, telemetry
    assert run.silence_s < 2.0  # a heartbeat late by a second at most, whatever else the computer does
    assert run.reopened == run.unplugged
    assert run.lost_s == pytest.approx(run.missing_s, abs=0.1 * outages)


def account(columns):
    """Growth [MB], shares of a core, and how threads, descriptors and memory [MB] were at the ends.

    What a separation works with comes and goes, and the allocator gives some of it back late: growth is how much higher
    the lowest of the last third is than that of the first. A recording opens some files: of the descriptors the lowest
    number within two minutes counts. While the microphones are unplugged there is one fewer.
    """
    clock, resident, threads, files, cpu, pump = columns
    seconds = clock[-1] - clock[0]
    third = max(len(resident) // 3, 1)
    return {
        "minutes": round(float(seconds / 60), 1),
        "growth_mb": round(float(resident[-third:].min() - resident[:third].min()), 2),
        "least_mb": round(float(resident.min()), 1),
        "most_mb": round(float(resident.max()), 1),
        "threads_first": int(threads[0]),
        "threads_last": int(threads[-1]),
        "files_first": int(files[:WINDOW].min()),
        "files_last": int(files[-WINDOW:].min()),
        "cpu": round(float((cpu[-1] - cpu[0]) / seconds), 4),
        "pump": round(float((pump[-1] - pump[0]) / seconds), 4),
    }
