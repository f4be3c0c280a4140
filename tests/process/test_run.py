"""``ross run`` as its user starts it: a file, a process, signals."""

import json
import os
import select
import shutil
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import soundfile
from pymavlink import mavutil

import waiting
from ports import free_port
from processes import ROSS, program
from ross_payload.service.health_socket import asked

RATE = 16000


def noisy(folder, seconds=2):
    """Write two seconds of noise into a folder, and with more of them also a long file; return the folder."""
    noise = np.random.default_rng(0).normal(0, 0.01, (RATE * seconds, 2))
    soundfile.write(folder / "noise.wav", noise[: 2 * RATE], RATE, subtype="PCM_24")
    if seconds > 2:
        soundfile.write(folder / "long.wav", noise, RATE, subtype="PCM_24")
    return folder


@pytest.fixture(scope="module")
def sounds(tmp_path_factory):
    return noisy(tmp_path_factory.mktemp("sounds"), seconds=60)


@pytest.fixture
def folder(sounds, tmp_path):
    for sound in sounds.iterdir():
        (tmp_path / sound.name).symlink_to(sound)
    return tmp_path


def written(folder, more="", source="file:noise.wav", links=""):
    text = f"""
[audio]
source = "{source}"
[actuator]
kind = "tb6600"
[service]
state_dir = "state"
log_format = "json"
{more}
{links}
"""
    path = folder / "ross.toml"
    path.write_text(text)
    return path


def run(folder, path, **options):
    return subprocess.run(
        [*ROSS, "run", path], cwd=folder, capture_output=True, text=True, timeout=120, check=False, **options
    )


def log(stderr):
    return [json.loads(line) for line in stderr.splitlines() if line.startswith("{")]


def wait_for(process, words, timeout=60):
    """Read the log until a line holds these words."""
    end = time.monotonic() + timeout
    while time.monotonic() < end:
        line = process.stderr.readline()
        if words in line:
            return
        assert line, "the payload ended"
    raise AssertionError(f"'{words}' never came")


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A payload that heard two seconds of noise to their end, and its folder."""
    folder = noisy(tmp_path_factory.mktemp("ended"))
    return run(folder, written(folder)), folder


def test_the_end_of_a_recording_is_no_fault(ended):
    done, _ = ended
    assert done.returncode == 0, done.stderr
    assert any("end" in line["message"] for line in log(done.stderr))
    assert not [line for line in log(done.stderr) if line["level"] in ("warning", "error", "critical")]


def test_nothing_is_asked_of_the_motor_at_start(ended):
    done, _ = ended
    assert log(done.stderr)
    assert not [line for line in log(done.stderr) if "turning" in line["message"]]


def test_what_must_last_is_in_the_state_folder_for_its_owner_alone(ended):
    _, folder = ended
    assert (folder / "state").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_signal_is_an_orderly_end(folder, number):
    with subprocess.Popen(
        [*ROSS, "run", written(folder, source="file:long.wav")],
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        wait_for(process, "idle")
        process.send_signal(number)
        rest = process.stderr.read()
    assert process.returncode == 0, rest
    assert "shut down" in rest


@pytest.mark.parametrize(
    ("more", "links", "source", "words"),
    [
        ('[service]\nstate_dir = "x"', "", "file:noise.wav", "not TOML"),
        ("", "[[links]]\nurl = 'udpin:nowhere'", "file:noise.wav", "udpin:nowhere"),
        ("", "", "file:missing.wav", "missing.wav"),
        ("", "", "tape:1", "tape"),
        ('target = "nobody-enrolled"', "", "file:noise.wav", "nobody-enrolled"),
        ("", "[mount]\nsource = 'autopilot'", "file:noise.wav", "autopilot"),
        ("", "[actuator.options]\nport = 'gpio:9'", "file:noise.wav", "gpio"),
    ],
)
def test_a_mistake_gets_one_line_and_exit_code_2(folder, more, links, source, words):
    done = run(folder, written(folder, more, source, links))
    assert done.returncode == 2, done.stderr
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("ross: ")
    assert words in last
    assert "Traceback" not in done.stderr


def test_a_shell_asks_it_how_it_is_while_it_runs(folder):
    path = written(folder, source="file:long.wav")

    def asked():
        command = [*ROSS, "health", path]
        told = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        return told.returncode, told.stdout

    assert asked() == (1, "")
    with program([*ROSS, "run", path], folder):
        waiting.wait_for(lambda: asked() == (0, "idle\n"))
    assert asked() == (1, "")


def test_a_terminal_that_takes_no_more_lines_holds_up_neither_the_payload_nor_its_end(folder):
    """As after Ctrl-S, or when an SSH connection hangs: nobody reads what it logs."""
    path = written(folder, source="file:long.wav")
    reads, writes = os.pipe()
    os.set_blocking(writes, False)
    with suppress(BlockingIOError):
        while True:
            os.write(writes, bytes(select.PIPE_BUF))
    os.set_blocking(writes, True)
    with subprocess.Popen([*ROSS, "run", path], cwd=folder, stderr=writes) as process:
        try:
            os.close(writes)
            waiting.wait_for(lambda: state_told(folder / "state") == "idle")
            process.terminate()
            assert process.wait(20) == 0
        finally:
            process.kill()
            os.close(reads)


def state_told(state):
    """Return the state that the payload of a state folder tells; None when there is none."""
    try:
        return asked(state)["state"]
    except (OSError, ValueError):
        return None


def test_a_port_in_use_is_named(folder):
    other = mavutil.mavudp("127.0.0.1:0", input=True)
    try:
        port = other.port.getsockname()[1]
        done = run(folder, written(folder, links=f"[[links]]\nurl = 'udpin:127.0.0.1:{port}'"))
    finally:
        other.close()
    assert done.returncode == 2
    assert str(port) in done.stderr


def test_a_ground_station_sees_it_and_its_order_is_obeyed(folder):
    """A client that is not ours: pymavlink's mavutil."""
    port = free_port()
    path = written(
        folder,
        source="file:long.wav",
        links=f"[[links]]\nurl = 'udpin:127.0.0.1:{port}'",
    )
    with subprocess.Popen([*ROSS, "run", path], cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        try:
            wait_for(process, "idle")
            ground = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255)
            ground.mav.heartbeat_send(6, 8, 0, 0, 4)
            beat = ground.recv_match(type="HEARTBEAT", blocking=True, timeout=20)
            assert (beat.get_srcComponent(), beat.type) == (191, 18)
            ground.mav.command_long_send(1, 191, 54004, 0, *[0] * 7)  # MAV_CMD_ROSS_STOP
            ack = ground.recv_match(type="COMMAND_ACK", blocking=True, timeout=20)
            if ack.result == mavutil.mavlink.MAV_RESULT_IN_PROGRESS:  # the disk has not saved the stop yet
                ack = ground.recv_match(type="COMMAND_ACK", blocking=True, timeout=20)
            assert (ack.command, ack.result) == (54004, 0)
            ground.close()
        finally:
            process.terminate()
        assert "stopped" in process.stderr.read()
    assert process.returncode == 0


def commanded(folder, number, *parameters, links):
    """Start the payload, give one command, return its answer and the log."""
    port = int(links.rpartition(":")[2].strip("'"))
    path = written(folder, source="file:long.wav", links=f"[[links]]\n{links}")
    with subprocess.Popen([*ROSS, "run", path], cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        try:
            wait_for(process, "ross 0")
            ground = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=255)
            ground.mav.command_long_send(1, 191, number, 0, *parameters, *[0] * (7 - len(parameters)))
            ack = ground.recv_match(type="COMMAND_ACK", condition="COMMAND_ACK.result!=5", blocking=True, timeout=20)
            ground.close()
        finally:
            process.terminate()
        return ack.result, process.stderr.read()


def test_a_second_payload_on_the_same_state_folder_is_refused_and_the_first_goes_on(folder):
    path = written(folder, source="file:long.wav")
    with subprocess.Popen([*ROSS, "run", path], cwd=folder, stderr=subprocess.PIPE, text=True) as process:
        try:
            wait_for(process, "ross 0")
            second = run(folder, path)
            assert second.returncode == 2
            assert second.stderr == (
                "ross: service.state_dir: expected a folder that no other payload uses, got state: "
                "stop the other one, or name another folder\n"
            )
            assert (folder / "state" / "health").is_socket()
        finally:
            process.kill()
    assert run(folder, written(folder)).returncode == 0, "a killed payload leaves no lock"


def test_a_stop_outlives_a_restart_until_armed_again(folder):
    links = f"url = 'udpin:127.0.0.1:{free_port()}'"
    assert commanded(folder, 54004, links=links)[0] == 0  # stop
    assert (folder / "state" / "stopped").exists()
    result, said = commanded(folder, 54006, links=links)  # park
    assert result != 0
    assert "turning" not in said
    assert commanded(folder, 54009, links=links)[0] == 0  # re-arm
    assert not (folder / "state" / "stopped").exists()


LEAPS = ((1_795_180_000, 1_795_180_001, 2_095_180_002, 2_095_180_003), "the date has leapt ahead by 3472 days")
WRONG = (
    (2_095_180_000, 2_095_180_001),
    "nobody confirms the date that the autopilot tells: the clock of this computer is",
)


@pytest.mark.parametrize(("dates", "why"), [LEAPS, WRONG])
def test_an_autopilot_whose_date_is_years_ahead_has_no_recording_deleted(folder, dates, why):
    port, kept = free_port(), folder / "state" / "recordings" / "0001-20261120T120000Z"
    shutil.copytree(Path(__file__).parent.parent / "data" / "session-0.1.0", kept)
    link = f"[[links]]\nurl = 'udpin:127.0.0.1:{port}'\nrole = 'autopilot'"
    path = written(folder, source="file:long.wav", links=link)
    with program([*ROSS, "run", path], folder) as (_, log):
        waiting.wait_for(lambda: "idle" in log.read_text())
        autopilot = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=1, source_component=1)
        for boot, unix in enumerate(dates, 1):
            autopilot.mav.heartbeat_send(2, 3, 0, 0, 3)
            autopilot.mav.system_time_send(unix * 1_000_000, boot * 1000)
        autopilot.mav.command_long_send(1, 191, 54008, 0, 1, *[0] * 6)  # MAV_CMD_ROSS_RECORD
        waiting.wait_for(lambda: [each for each in kept.parent.glob("0002-2036*/*.wav") if each.stat().st_size > 4096])
        autopilot.close()
        assert kept.exists()
        assert why in log.read_text()
