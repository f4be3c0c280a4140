"""A real socket in a real folder; whoever polls it is the pump."""

import json
import os
import socket
import subprocess
import sys
import threading

import pytest

from processes import ROSS
from ross_payload.events import State, StateChanged
from ross_payload.health import AudioHealth, AudioTrouble, RecordingStatus
from ross_payload.service.condition import Condition
from ross_payload.service.health_command import in_words
from ross_payload.service.health_socket import CLIENTS, NAME, HealthSocket, asked

WELL = {"late": [], "state": "idle"}


@pytest.fixture
def polled():
    """Poll a socket in the background, as the pump does, until the end of the test."""
    over, threads = threading.Event(), []

    def begin(wire):
        def pump():
            while not over.wait(0.001):
                wire.poll()

        threads.append(threading.Thread(target=pump))
        threads[-1].start()
        return wire

    yield begin
    over.set()
    for thread in threads:
        thread.join()


def test_who_connects_is_told(tmp_path, polled):
    with HealthSocket(tmp_path, lambda: WELL) as wire:
        polled(wire)
        assert asked(tmp_path) == WELL
        assert asked(tmp_path) == WELL


def test_a_folder_deeper_than_an_address_is_long_will_do(tmp_path, polled):
    folder = tmp_path.joinpath(*["deep" * 10] * 5)
    folder.mkdir(parents=True)
    assert len(str(folder)) > 107
    with HealthSocket(folder, lambda: WELL) as wire:
        polled(wire)
        assert asked(folder) == WELL


def test_a_pump_that_hangs_answers_nobody(tmp_path):
    with HealthSocket(tmp_path, lambda: WELL), pytest.raises(OSError, match="timed out"):
        asked(tmp_path, patience=0.05)


def test_only_its_owner_may_ask_and_nothing_is_left(tmp_path):
    with HealthSocket(tmp_path, lambda: WELL):
        assert (tmp_path / NAME).stat().st_mode & 0o777 == 0o600
    assert not list(tmp_path.iterdir())


def test_what_a_killed_payload_left_is_replaced(tmp_path, polled):
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(tmp_path / NAME))
    with pytest.raises(ConnectionRefusedError):
        asked(tmp_path)
    with HealthSocket(tmp_path, lambda: WELL) as wire:
        polled(wire)
        assert asked(tmp_path) == WELL


def test_a_folder_that_is_gone_costs_nothing_but_the_answers(tmp_path, caplog):
    with HealthSocket(tmp_path / "gone", lambda: WELL) as wire:
        wire.poll()
    assert "`ross health` gets no answer" in caplog.text


def test_those_who_say_nothing_and_those_who_leave_hold_up_nobody(tmp_path):
    with HealthSocket(tmp_path, lambda: WELL) as wire:
        idle = [socket.socket(socket.AF_UNIX) for _ in range(CLIENTS)]
        for number, client in enumerate(idle):
            client.connect(str(tmp_path / NAME))
            if number % 2:
                client.close()
        wire.poll()
        assert json.loads(idle[0].recv(1000)) == WELL
        for client in idle:
            client.close()


def test_the_condition_is_told_in_words_that_the_log_has():
    trouble = AudioTrouble.DEAD_2 | AudioTrouble.LOST
    condition = Condition(lambda: ("mission",), lambda: AudioHealth(trouble), RecordingStatus, lambda: ())
    condition.on_event(StateChanged(0.0, State.EXPLORE_TURN, "rotation 1"), None)
    values = condition.values()
    assert values["late"] == ["mission"]
    assert values["microphones"] == ["dead 2", "lost"]
    assert in_words(values) == "no progress: mission; explore turn: rotation 1; microphones: dead 2, lost"


def test_nobody_there_is_one_line_and_exit_code_1(tmp_path):
    environment = os.environ | {"STATE_DIRECTORY": str(tmp_path)}
    command = [*ROSS, "health"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == f"ross: no payload answers at {tmp_path / NAME}: No such file or directory\n"


ASKING = """
import sys
from ross_payload.cli import main
sys.argv = ["ross", "health", "--json"]
try:
    main()
except SystemExit:
    heavy = {"numpy", "scipy", "pydantic", "pymavlink"}
    assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""


def test_to_ask_loads_nothing_heavy():
    """A container asks every half minute."""
    done = subprocess.run([sys.executable, "-c", ASKING], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
