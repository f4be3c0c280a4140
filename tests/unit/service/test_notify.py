"""The service manager is a real datagram socket here; only the clock is made."""

import os
import signal
import socket
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ross_payload.events import State, StateChanged
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.notify import Manager, Watchdog, hearing_signals, on_signal
from ross_payload.pointing import Pointing
from ross_sim.clock import SimClock
from waiting import wait_for


@pytest.fixture(params=["path", "abstract"])
def systemd(request, tmp_path):
    """A listening manager and its address as in $NOTIFY_SOCKET."""
    name = str(tmp_path / "notify") if request.param == "path" else f"@ross-{os.getpid()}-{id(tmp_path)}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as wire:
        wire.bind(name.replace("@", "\0"))
        wire.setblocking(False)
        yield wire, name


def words(wire):
    found = []
    while True:
        try:
            found.append(wire.recv(4096).decode())
        except BlockingIOError:
            return found


def test_every_word_is_one_datagram_of_assignments(systemd):
    wire, name = systemd
    manager = Manager.of({"NOTIFY_SOCKET": name})
    assert manager.ready("idle")
    assert manager.status("exploring")
    assert manager.alive()
    assert manager.stopping("asked to")
    assert words(wire) == [
        "READY=1\nSTATUS=idle",
        "STATUS=exploring",
        "WATCHDOG=1",
        "STOPPING=1\nSTATUS=asked to",
    ]


def test_a_line_break_in_a_status_makes_no_assignment(systemd):
    wire, name = systemd
    Manager(name).status("late\nREADY=1")
    assert words(wire) == ["STATUS=late READY=1"]


def test_nobody_is_told_outside_systemd():
    manager = Manager.of({})
    assert not manager.ready("idle")
    assert manager.period is None


def test_a_manager_that_is_gone_costs_nothing_but_the_word(tmp_path):
    assert not Manager(str(tmp_path / "gone")).alive()


@pytest.mark.parametrize(
    ("environment", "period"),
    [
        ({"WATCHDOG_USEC": "30000000"}, 30.0),
        ({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": "{own}"}, 30.0),
        ({"WATCHDOG_USEC": "30000000", "WATCHDOG_PID": "1"}, None),  # meant for another process
        ({"WATCHDOG_USEC": "0"}, None),
        ({"WATCHDOG_USEC": "soon"}, None),
    ],
)
def test_the_period_is_the_manager_s_and_meant_for_this_process(environment, period):
    told = {name: value.format(own=os.getpid()) for name, value in environment.items()}
    assert Manager.of(told).period == period


def hop():
    block = AudioBlock(np.zeros((2, 160), np.float32), index=0, time=0.0)
    return Input(block, 0.0, Pointing(), settled=True, attitude=Attitude(0.0))


def pings(wire):
    return words(wire).count("WATCHDOG=1")


def test_it_pings_four_times_in_a_period_while_everybody_makes_progress(systemd):
    wire, name = systemd
    clock = SimClock()
    watchdog = Watchdog(Manager(name, period=20.0), clock, {"pump": 1.0, "mission": 60.0})
    clock.every(0.5, lambda: watchdog.mark("pump"))
    clock.every(0.5, lambda: watchdog.on_input(hop()))
    watchdog.start()
    clock.sleep(20.5)
    assert pings(wire) == 4


def test_a_mission_that_separates_for_long_is_alive_until_its_patience_ends(systemd):
    wire, name = systemd
    clock = SimClock()
    watchdog = Watchdog(Manager(name, period=20.0), clock, {"pump": 1.0, "mission": 60.0})
    clock.every(0.5, lambda: watchdog.mark("pump"))
    watchdog.start()
    clock.sleep(59.0)
    assert pings(wire) == 11
    clock.sleep(60.0)
    said = words(wire)
    assert said.count("WATCHDOG=1") == 1  # at 60 s, just in time
    assert "STATUS=no progress: mission" in said


def test_a_pump_whose_work_has_died_is_not_covered_by_a_mission_that_lives(systemd):
    wire, name = systemd
    clock = SimClock()
    watchdog = Watchdog(Manager(name, period=20.0), clock, {"pump": 1.0, "mission": 60.0})
    clock.every(0.5, lambda: watchdog.on_input(hop()))
    watchdog.start()
    clock.sleep(30.0)
    assert pings(wire) == 0
    assert watchdog.late() == ("pump",)


def test_the_manager_hears_what_the_mission_does(systemd):
    wire, name = systemd
    watchdog = Watchdog(Manager(name), SimClock(), {"mission": 60.0})
    watchdog.on_event(StateChanged(1.0, State.EXPLORE_TURN, "rotation 2 of 12"), hop())
    assert words(wire) == ["STATUS=explore turn: rotation 2 of 12"]


def test_without_a_watchdog_nothing_is_polled():
    assert Watchdog(Manager("", period=None), SimClock(), {"mission": 60.0}).start() is None


def functions(thread):
    """The functions that a thread is in, the innermost first."""
    frame = sys._current_frames()[thread.ident]
    while frame is not None:
        yield frame.f_code.co_name
        frame = frame.f_back


def test_a_signal_that_another_thread_was_given_is_heard_at_once():
    heard = threading.Event()

    def waits():
        inner, *outer = functions(threading.main_thread())
        return inner == "wait" and "hearing_signals" in outer

    def work():
        wait_for(waits)
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)
        return heard.wait(10.0)

    with ThreadPoolExecutor(max_workers=1) as pool, on_signal(lambda _: heard.set()):
        assert hearing_signals(pool.submit(work))
