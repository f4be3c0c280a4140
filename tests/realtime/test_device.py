"""`ross device` and `ross hub`: devices in processes of their own, turned by the drivers over real wires."""

import json
import math
import signal
import subprocess
import time

import pytest

from device_bench import device, driver, ross
from examples import in_soak
from ports import free_port
from processes import ROSS
from waiting import wait_for

pytest.importorskip("can")

KINDS = {"gimbal": {}, "servo": {}, "drive": {}, "grbl": {}, "stepper": {"ahead_ms": 100.0}}
QUIET = ("stepper",)  # its pulses run out where others keep the processors
VEHICLE = {"turn_vehicle": True, "resolution_deg": 0.5}


@pytest.mark.parametrize("kind", [pytest.param(one, marks=pytest.mark.alone if one in QUIET else ()) for one in KINDS])
def test_a_driver_turns_a_device_in_another_process_to_where_it_says(kind, tmp_path):
    with device(tmp_path, kind) as process, driver(process.told, **KINDS[kind]) as one:
        one.ready()
        start = math.radians(process.ask("status")["angle_deg"])
        one.turn(one.actuator.state().angle + 0.3)

        def there():
            return abs(math.radians(process.ask("status")["angle_deg"]) - start - 0.3) < 0.005

        wait_for(there)
        assert process.ask("status")["complaints"] == []


@pytest.mark.parametrize("mode", [*in_soak("hold"), "offboard"])  # "hold" is of PX4: here it is an ArduCopter
def test_an_autopilot_in_another_process_turns_its_vehicle_until_the_pilot_objects(mode, tmp_path):
    option = ("--option", f"px4_mode={mode}")
    with device(tmp_path, "vehicle", *option) as process, driver(process.told, **VEHICLE, px4_mode=mode) as one:
        one.until(lambda: "it may be turned" in one.actuator.identity)  # Offboard is granted a second after its stream
        one.ready()
        one.turn(0.3)
        wait_for(lambda: abs(process.ask("status")["angle_deg"] - math.degrees(0.3)) < 1.0)
        one.actuator.command(-2.0)
        one.until(lambda: one.actuator.state().rate < -0.3)
        process.ask("mode")
        one.until(lambda: "the flight mode is" in one.actuator.state().fault)
        assert process.ask("status")["complaints"] == []


@pytest.mark.parametrize("kind", ["servo", "drive"])
def test_nodes_meet_on_a_hub(kind, tmp_path):
    with ross(tmp_path, "hub", "--listen", "tcp:127.0.0.1:0", "--json") as hub:
        wire = f"{hub.told['hub']}:bus1"
        with device(tmp_path, kind, "--wire", wire) as process, driver(process.told, **KINDS[kind]) as one:
            one.ready()
            one.turn(one.actuator.state().angle + 0.2)
            assert process.told["wire"] == wire


def test_a_device_joins_the_bus_that_the_file_of_the_payload_names(tmp_path):
    with ross(tmp_path, "hub", "--listen", "tcp:127.0.0.1:0", "--json") as hub:
        wire = f"{hub.told['hub']}:bus1"
        file = tmp_path / "ross.toml"
        file.write_text(f'[actuator]\nkind = "canopen_drive"\noptions = {{ port = "{wire}" }}\n')
        with device(tmp_path, "drive", "--config", str(file)) as process:
            assert process.told["wire"] == wire
        with device(tmp_path, "drive", "--config", str(file), "--wire", f"{hub.told['hub']}:bus2") as process:
            assert process.told["wire"] == f"{hub.told['hub']}:bus2"


def test_a_device_serves_the_port_at_which_the_file_of_the_payload_looks_for_it(tmp_path):
    port, link = free_port(), f"udpin:127.0.0.1:{free_port()}"
    files = {
        "servo": f'[actuator]\nkind = "dronecan_servo"\noptions = {{ port = "can:tcp:127.0.0.1:{port}" }}\n',
        "gimbal": f'[actuator]\nkind = "mavlink_gimbal"\n[[links]]\nurl = "{link}"\nrole = "autopilot"\n',
    }
    wires = {"servo": f"can:tcp:127.0.0.1:{port}", "gimbal": link}
    for kind, text in files.items():
        (tmp_path / f"{kind}.toml").write_text(text)
        with device(tmp_path, kind, "--config", str(tmp_path / f"{kind}.toml")) as process:
            assert process.told["wire"] == wires[kind]


def test_a_bare_gimbal_is_managed_over_tcp(tmp_path):

    wire = f"tcpin:127.0.0.1:{free_port()}"
    with device(tmp_path, "gimbal", "--option", "role=manager", "--wire", wire) as process:
        assert process.told["wire"] == wire.replace("tcpin", "tcp")
        with driver(process.told, role="manager") as one:
            one.ready()
            one.turn(-0.3)
            assert process.ask("status")["angle_deg"] == pytest.approx(math.degrees(-0.3), abs=0.2)


def test_faults_happen_on_command_and_are_told(tmp_path):
    with device(tmp_path, "gimbal") as process, driver(process.told) as one:
        one.ready()
        assert process.ask("status")["faults"] == []
        assert process.ask("stuck")["faults"] == ["stuck"]
        one.actuator.command(1.0)
        one.until(lambda: "does not follow" in one.actuator.state().fault)
        assert process.ask("stuck off")["faults"] == []
        assert "expected FAULT" in process.ask("be nice please")["error"]
        assert "expected one of corrupt, dup" in process.ask("explode")["error"]
        assert process.ask("reboot")["faults"] == []


def test_faults_happen_at_their_time(tmp_path):
    with device(tmp_path, "gimbal", "--fault", "stall at 0.2 for 1000", "--fault", "silent at 0.1 for 0.2") as process:
        end = time.monotonic() + 20
        while (told := process.ask("status"))["time_s"] < 0.4:
            assert time.monotonic() < end
        assert told["faults"] == ["stall"]


def test_a_killed_payload_leaves_a_still_gimbal(tmp_path):
    with device(tmp_path, "gimbal") as process, driver(process.told, pump=False) as one:

        def polled():
            one.poll()
            return one.actuator.state()

        one.until(lambda: polled().settled)
        one.actuator.command(3.0)
        one.until(lambda: polled().angle > 0.3)

        def stands():  # nobody polls: as if killed
            before = process.ask("status")["angle_deg"]
            time.sleep(0.5)
            return process.ask("status")["angle_deg"] == pytest.approx(before, abs=0.05)

        wait_for(stands)
        assert math.degrees(0.2) < process.ask("status")["angle_deg"] < math.degrees(1.5)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("command", [["device", "servo"], ["hub", "--listen", "tcp:127.0.0.1:0"]])
def test_a_signal_ends_it_with_code_0(command, number):
    started = [*ROSS, *command, "--json"]
    with subprocess.Popen(started, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        json.loads(process.stdout.readline())
        process.send_signal(number)
        _, err = process.communicate(timeout=30)
    assert (process.returncode, err) == (0, "")


BAD = {
    "expected can:": ["device", "servo", "--wire", "pulses:tcp:127.0.0.1:0"],
    "expected tcp:HOST:PORT": ["device", "servo", "--wire", "can:tcp:127.0.0.1"],
    "expected udpin:": ["device", "gimbal", "--wire", "can:tcp:127.0.0.1:0"],
    "cannot listen": ["device", "stepper", "--wire", "pulses:tcp:192.0.2.1:0"],
    "cannot join the bus": ["device", "servo", "--wire", "can:socketcand:127.0.0.1:1"],
    'expected "FAULT at SECONDS"': ["device", "gimbal", "--fault", "stall soon"],
    "fault: expected one of ": ["device", "gimbal", "--fault", "rust at 3"],
    "expected KEY=VALUE": ["device", "gimbal", "--option", "role"],
    "expected 'discover', 'client' or 'manager', got 'boss'": ["device", "gimbal", "--option", "role=boss"],
    "expected one of them": ["device", "gimbal", "--option", "role=client", "--config", "x.toml"],
    "--listen": ["hub", "--listen", "29536"],
    "expected an IPv4 host": ["hub", "--listen", "tcp:[::1]:0"],
    "cannot listen:": ["hub", "--listen", "tcp:192.0.2.1:0"],
}


@pytest.mark.parametrize("words", BAD)
def test_what_a_device_cannot_be_is_one_line_and_exit_code_2(run, words):
    code, out, err = run(*BAD[words])
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
