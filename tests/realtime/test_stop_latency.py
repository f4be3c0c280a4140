"""From a stop to the first step that comes later: measured on the pulses themselves, whoever gives the stop.

Edges carry the time at which they are due, so that nothing here depends on when the far end looks. A move starts from
rest and accelerates at a known rate, a stop decelerates at the same: when it began follows from the steps alone.
"""

import math
import signal
import socket
import threading
import time
from contextlib import ExitStack, contextmanager, nullcontext, suppress

import numpy as np
import pytest

from pulse_rig import CANCEL, HOME, REARM, SEPARATING, STOP, Rig, busy_loops, deceleration_began, rises
from ross_payload.actuators.registry import open_actuator
from ross_payload.actuators.tb6600.pulse_segments import RecordingPulses
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.errors import ActuatorFault
from ross_payload.interfaces import Services
from ross_sim.clock import SimClock
from ross_sim.study.rows.promptness_rows import StopRow
from waiting import wait_for

pytestmark = pytest.mark.alone
WANTED = 0.050  # [s]
BESIDE = 0.050  # [s] that two busy loops may add
BUSY_COMPUTER = 0.150  # [s] that the test grants a computer which does much else
ACCEPTED = 0  # MAV_RESULT
COMMANDS = {STOP: "`MAV_CMD_ROSS_STOP` over UDP", CANCEL: "`MAV_CMD_ROSS_CANCEL` over UDP"}
ENDS = {
    signal.SIGTERM: "SIGTERM",
    signal.SIGUSR1: "a periodic call of the pump raises",
}  # in a process that breaks on request
STREAM = """
[[listening.streams]]
sink = "tcp"
what = "mixture"
options = {{ port = {port} }}
"""
BREAKING = """
import signal
import time
from pathlib import Path
from ross_payload import cli
from ross_payload.mavlink import Router

poll, broken = Router.poll, []
def dying(links):
    if broken:
        Path("died").write_text(str(time.monotonic()))
        raise ZeroDivisionError
    poll(links)
Router.poll = dying
signal.signal(signal.SIGUSR1, lambda number, frame: broken.append(number))
cli.main()
"""


def test_the_beginning_of_a_deceleration_is_found_in_the_steps_of_a_whole_move():
    clock, config = SimClock(), Config.model_validate({"actuator": {"kind": "tb6600"}})
    port = RecordingPulses(clock.now)
    with open_actuator(config, Services(clock, lambda url: port)) as actuator:
        actuator.poll(clock.now())
        actuator.command(math.radians(90))
        for _ in range(200):
            clock.sleep(0.010)
            actuator.poll(clock.now())
    steps = rises(port.sent, 0.0)
    assert steps.size == 800
    assert deceleration_began(steps) == pytest.approx((steps[0] + steps[-1]) / 2, abs=1e-9)  # the move is symmetric


@pytest.fixture
def rig(noise, tmp_path, process, ground_station, free_port):
    """Make a rig whose payload is started in some way."""
    (tmp_path / "noise.wav").hardlink_to(noise)

    def make(before=("-m", "ross_payload.cli"), ahead_ms=40, more=""):
        def start():
            return process(["run", "ross.toml"], tmp_path, "payload", before)

        return Rig(tmp_path, start, ground_station, free_port(), ahead_ms, more=more)

    return make


@pytest.fixture
def judge(capsys, written):
    """Print the figures [ms] of what did not run out, keep them, and hold them against what is wanted."""

    def look(latencies, what, beside, moments):
        written("stops.csv", rows_of(what, beside, moments, latencies))
        whole = np.array([latency for latency in latencies if latency is not None])
        median, high, most = np.percentile(whole, [50, 95, 100]) * 1e3
        with capsys.disabled():
            count = f"{whole.size} of {len(latencies)}"
            print(f"{what}, beside {beside}: {count}, median {median:.1f}, p95 {high:.1f}, max {most:.1f} ms")  # noqa: T201
        assert most < WANTED * 1e3
        assert whole.size > 0.9 * len(latencies)

    return look


def rows_of(stop, beside, moments, latencies, *, answers=None, ahead_ms=40):
    """What was measured, in ms."""
    told = [None] * len(latencies) if answers is None else [round(answer * 1e3, 3) for answer in answers]
    found = [None if latency is None else round(latency * 1e3, 3) for latency in latencies]
    each = zip(moments, found, told, strict=True)
    return [StopRow(stop, beside, ahead_ms, round(float(after), 3), late, answer) for after, late, answer in each]


def test_a_command_decelerates_soon(rig):
    latencies = {}
    with rig() as payload:
        for command in (STOP, CANCEL):
            payload.turn(0.3)
            latencies[command] = payload.latency(lambda command=command: payload.ground.command(command))
    assert all(latency is None or latency < BUSY_COMPUTER for latency in latencies.values()), latencies


def acknowledged_stops(payload, moments):
    """Stops in the middle of moves; how long until each is accepted and until the steps come later, both in s."""
    answers, latencies = [], []

    def stop():
        given = time.monotonic()
        assert payload.ground.order(STOP) == ACCEPTED
        answers.append(time.monotonic() - given)

    for after in moments:
        payload.turn(after)
        latencies.append(payload.latency(stop))
    return answers, latencies


@pytest.fixture
def listeners(free_port):
    """Streams in a configuration, and a context in which somebody takes each of them."""
    ports = [free_port() for _ in range(3)]

    @contextmanager
    def listening():
        with ExitStack() as stack:
            for port in ports:
                taken = threading.Thread(target=drained, args=(stack, port), daemon=True)
                taken.start()
            yield

    def drained(stack, port):
        connection = stack.enter_context(wait_for(lambda: connected(port)))
        with suppress(OSError):
            while connection.recv(65536):
                pass

    return "".join(STREAM.format(port=port) for port in ports), listening


def connected(port):
    with suppress(OSError):
        return socket.create_connection(("127.0.0.1", port), 20)


def test_a_stop_beside_two_busy_loops_and_three_listeners_decelerates_as_soon(rig, listeners):
    more, listening = listeners
    with rig(more=more) as payload, listening(), busy_loops():
        wait_for(lambda: [stream.listeners for stream in payload.ground.streams.values()] == [1, 1, 1])
        answers, latencies = acknowledged_stops(payload, [0.3])
    assert max(answers) < 2.0  # an acknowledgement waits for the disk, at most so long
    assert latencies[0] is None or latencies[0] < BUSY_COMPUTER + 0.1


@pytest.mark.soak
@pytest.mark.parametrize("streams", [False, True])
def test_20_stops_beside_two_busy_loops_with_and_without_three_listeners(rig, listeners, streams, capsys):
    more, listening = listeners
    with rig(more=more if streams else "") as payload, listening() if streams else nullcontext(), busy_loops():
        answers, latencies = acknowledged_stops(payload, np.random.default_rng(5).uniform(0.1, 0.7, 20))
    whole = np.array([latency for latency in latencies if latency is not None])
    with capsys.disabled():
        what = f"three listeners: {streams}, {whole.size} of {len(latencies)}"
        print(f"{what}, median {np.median(whole) * 1e3:.1f}, max {whole.max() * 1e3:.1f} ms")  # noqa: T201
    assert len(answers) == 20
    assert whole.size >= 18
    assert whole.max() < 0.040 + BESIDE


@pytest.mark.soak
@pytest.mark.parametrize("ahead_ms", [40, 100])
def test_76_stops_beside_two_busy_loops_are_accepted_and_decelerate(rig, written, capsys, ahead_ms):
    moments = np.random.default_rng(5).uniform(0.1, 0.7, 76)
    with rig(ahead_ms=ahead_ms) as payload, busy_loops():
        answers, latencies = acknowledged_stops(payload, moments)
    written(
        "stops.csv", rows_of(COMMANDS[STOP], "two busy loops", moments, latencies, answers=answers, ahead_ms=ahead_ms)
    )
    whole = np.array([latency for latency in latencies if latency is not None])
    with capsys.disabled():
        for name, times in (("accepted", np.array(answers)), ("braking", whole)):
            median, high, most = np.percentile(times, [50, 95, 100]) * 1e3
            what = f"{ahead_ms} ms ahead, {name}: {times.size} of {len(latencies)}"
            print(f"{what}, median {median:.1f}, p95 {high:.1f}, max {most:.1f} ms")  # noqa: T201
    assert len(answers) == 76
    assert whole.size > 0.9 * len(latencies)
    assert whole.max() < ahead_ms * 1e-3 + BESIDE


@pytest.mark.parametrize("number", ENDS, ids=ENDS.get)
def test_an_end_of_the_process_decelerates_soon(rig, number):
    assert ended(rig, number, 0.3) < BUSY_COMPUTER


def ended(rig, number, after):
    """The latency of a signal in the middle of a move, or of the death that it brings [s]."""
    died = pytest.raises(AssertionError, match="periodic call failed") if number == signal.SIGUSR1 else nullcontext()
    with died, rig(("-c", BREAKING)) as payload:
        # one that has died before has left its stop and an unknown zero
        assert (payload.ground.order(REARM), payload.ground.order(HOME)) == (ACCEPTED, ACCEPTED)
        payload.turn(after)
        given = time.monotonic()
        payload.process.send_signal(number)
        payload.process.wait(30)
    told = payload.folder / "died"
    return payload.bench.began(payload.began) - (float(told.read_text()) if told.exists() else given)


def test_another_thread_decelerates_soon():
    assert all(latency < BUSY_COMPUTER for latency in stopped_by_a_thread([0.4]) if latency is not None)


def stopped_by_a_thread(moments):
    """Latencies of `Guard.stop` in the middle of moves, in this process."""
    clock, port, config = SystemClock(), RecordingPulses(time.monotonic), Config.model_validate(
        {"actuator": {"kind": "tb6600"}})  # fmt: skip
    latencies = []
    with open_actuator(config, Services(clock, lambda url: port)) as actuator, ExitStack() as stack:
        stack.callback(clock.every(0.010, lambda: actuator.poll(clock.now())))
        wait_for(lambda: actuator.state().healthy)
        for after in moments:
            began = clock.now()
            actuator.command(-math.copysign(math.radians(180), actuator.state().angle))
            time.sleep(after)
            given = []
            thread = threading.Thread(target=lambda given=given: (given.append(clock.now()), actuator.stop()))
            thread.start()
            thread.join()
            wait_for(lambda: actuator.state().rate == 0)
            time.sleep(0.2)
            latencies.append(deceleration_began(rises(port.sent, began)) - given[0])
            try:
                actuator.rearm()
            except ActuatorFault:  # the steps ran out
                latencies[-1] = None
                actuator.home()
                time.sleep(0.5)
                actuator.rearm()
    return latencies


@pytest.mark.soak
@pytest.mark.parametrize("before", [("-m", "ross_payload.cli"), ("-c", SEPARATING)], ids=["idle", "separating"])
@pytest.mark.parametrize("command", [STOP, CANCEL])
def test_fifty_commands_decelerate_within_50_ms(rig, command, before, judge):
    latencies, moments = [], np.random.default_rng(1).uniform(0.1, 0.7, 50)
    with rig(before) as payload:
        for after in moments:
            payload.turn(after)
            latencies.append(payload.latency(lambda: payload.ground.command(command)))
    judge(latencies, COMMANDS[command], "a separation without a pause" if before[0] == "-c" else "nothing", moments)


@pytest.mark.soak
@pytest.mark.parametrize("number", ENDS, ids=ENDS.get)
def test_thirty_ends_of_a_process_decelerate_within_50_ms(rig, judge, number):
    moments = np.random.default_rng(2).uniform(0.1, 0.7, 30)
    judge([ended(rig, number, after) for after in moments], ENDS[number], "nothing", moments)


@pytest.mark.soak
def test_fifty_stops_by_another_thread_decelerate_within_50_ms(judge):
    moments = np.random.default_rng(3).uniform(0.1, 1.1, 50)
    judge(stopped_by_a_thread(moments), "`Guard.stop` on another thread", "nothing", moments)
