"""What the doctor finds wrong with ports, buses, links and keys; ports, files and permissions are real."""

import socket

import pytest

from doctor_bench import DEVICE, config, machine, put, said
from ross_payload.doctor import wire_checks
from ross_payload.doctor.findings import Verdict


def test_a_serial_port_that_is_not_there_lists_those_that_are(tmp_path):
    put(tmp_path, "/dev/ttyACM0")
    verdict, text = said(wire_checks.serial(config(links=[{"url": DEVICE}]), machine(tmp_path)))
    assert verdict is Verdict.FAIL
    assert "there are: /dev/ttyACM0" in text


def test_a_serial_port_of_others_names_the_group(tmp_path):
    put(tmp_path, "/dev/ttyUSB0")
    strange = machine(tmp_path, may_use=lambda path: path.name != "ttyUSB0")
    verdict, text = said(wire_checks.serial(config(links=[{"url": DEVICE}]), strange))
    assert verdict is Verdict.FAIL
    assert "usermod -aG" in text


def test_a_serial_port_in_the_options_of_the_actuator_is_checked_too(tmp_path):
    turns = config(actuator={"kind": "x", "options": {"wire": {"port": "serial:/dev/ross-grbl:115200"}}})
    assert "/dev/ross-grbl does not exist" in said(wire_checks.serial(turns, machine(tmp_path)))[1]


def test_a_console_on_the_port_is_found_through_its_other_name(tmp_path):
    put(tmp_path, "/dev/ttyAMA0")
    (tmp_path / "dev" / "serial0").symlink_to("ttyAMA0")
    put(tmp_path, "/proc/cmdline", "console=tty1 console=serial0,115200 root=/dev/mmcblk0p2\n")
    verdict, text = said(wire_checks.serial(config(links=[{"url": "serial:/dev/ttyAMA0:auto"}]), machine(tmp_path)))
    assert verdict is Verdict.FAIL
    assert "console" in text


def test_the_port_that_is_not_on_the_pins_of_a_raspberry_pi_5_is_named(tmp_path):
    put(tmp_path, "/dev/ttyAMA10")
    put(tmp_path, "/dev/ttyAMA0")
    (tmp_path / "dev" / "serial0").symlink_to("ttyAMA10")
    verdict, text = said(wire_checks.serial(config(links=[{"url": "serial:/dev/serial0:921600"}]), machine(tmp_path)))
    assert verdict is Verdict.WARN
    assert "/dev/ttyAMA0" in text
    pins = config(links=[{"url": "serial:/dev/ttyAMA0:921600"}])
    assert said(wire_checks.serial(pins, machine(tmp_path)))[0] is Verdict.OK


def test_a_login_on_the_port_is_found(tmp_path):
    put(tmp_path, "/dev/ttyUSB0")
    busy = machine(tmp_path, {"systemctl": "active"})
    assert said(wire_checks.serial(config(links=[{"url": DEVICE}]), busy))[0] is Verdict.FAIL
    assert said(wire_checks.serial(config(links=[{"url": DEVICE}]), machine(tmp_path)))[0] is Verdict.OK


@pytest.mark.parametrize(
    ("flags", "verdict", "words"),
    [("0x40081\n", Verdict.OK, "up"), ("0x40080\n", Verdict.FAIL, "down"), (None, Verdict.FAIL, "there are: none")],
)
def test_a_can_interface_must_be_up(tmp_path, flags, verdict, words):
    if flags:
        put(tmp_path, "/sys/class/net/can0/flags", flags)
    servo = config(actuator={"kind": "servo", "options": {"port": "socketcan:can0"}})
    found = said(wire_checks.can(servo, machine(tmp_path)))
    assert found[0] is verdict
    assert words in found[1]


def test_words_that_hold_can_are_no_interface():
    turns = config(actuator={"kind": "x", "options": {"name": "canopen", "port": "scan0", "bus": "vcan1"}})
    assert wire_checks.can_interfaces(turns) == ["vcan1"]


def test_the_bus_of_our_own_node_is_looked_at():
    assert wire_checks.can_interfaces(config(dronecan={"port": "can:socketcan:can3"})) == ["can3"]


@pytest.mark.parametrize(
    ("kind", "port", "devices", "interfaces"),
    [
        ("grbl", "serial:tcp:127.0.0.1:3333", [], []),
        ("dronecan_servo", "can:socketcand:127.0.0.1:29536:can0", [], []),
        ("dronecan_servo", "can:slcan:/dev/ttyACM0:1000000", ["/dev/ttyACM0"], []),
        ("canopen_drive", "can:socketcan:can1", [], ["can1"]),
    ],
)
def test_only_what_is_on_this_computer_is_looked_for(kind, port, devices, interfaces):
    turns = config(actuator={"kind": kind, "options": {"port": port}})
    assert wire_checks.serial_devices(turns) == devices
    assert wire_checks.can_interfaces(turns) == interfaces


def test_a_port_that_is_left_out_is_looked_at_as_well():
    assert wire_checks.can_interfaces(config(actuator={"kind": "dronecan_servo"})) == ["can0"]
    assert wire_checks.serial_devices(config(actuator={"kind": "grbl"})) == ["/dev/ttyUSB0"]


def test_a_port_that_another_program_has_is_found(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        link = {"url": f"udpin:127.0.0.1:{other.getsockname()[1]}"}
        verdict, text = said(wire_checks.links(config(links=[link]), machine(tmp_path)))
    assert verdict is Verdict.FAIL
    assert "in use" in text
    assert said(wire_checks.links(config(links=[link]), machine(tmp_path)))[0] is Verdict.OK


def test_a_tcp_port_that_is_served_already_is_found(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        link = {"url": f"tcpin:127.0.0.1:{other.getsockname()[1]}"}
        assert said(wire_checks.links(config(links=[link]), machine(tmp_path)))[0] is Verdict.FAIL


def test_a_listener_for_everybody_without_a_key_is_warned_of(tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))
        link = {"url": f"udpin:0.0.0.0:{free.getsockname()[1]}"}
    verdict, text = said(wire_checks.links(config(links=[link]), machine(tmp_path)))
    assert verdict is Verdict.WARN
    assert "anyone on this network can command the payload" in text


def test_no_link_and_no_address_are_found(tmp_path):
    assert said(wire_checks.links(config(), machine(tmp_path)))[0] is Verdict.WARN
    assert said(wire_checks.links(config(links=[{"url": "carrier:pigeon"}]), machine(tmp_path)))[0] is Verdict.FAIL


@pytest.mark.parametrize(
    ("content", "mode", "verdict"),
    [(b"k" * 32, 0o600, Verdict.OK), (b"k" * 32, 0o644, Verdict.FAIL), (b"k", 0o600, Verdict.FAIL)],
)
def test_a_key_is_whole_and_ours_alone(tmp_path, content, mode, verdict):
    path = put(tmp_path, "/etc/ross/key")
    path.write_bytes(content)
    path.chmod(mode)
    link = {"url": "udpout:127.0.0.1:14550", "key_file": "/etc/ross/key"}
    assert said(wire_checks.links(config(links=[link]), machine(tmp_path)))[0] is verdict


def test_a_key_below_the_home_folder_is_looked_at_there(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", "/home/ann")
    path = put(tmp_path, "/home/ann/key")
    path.write_bytes(b"k" * 32)
    path.chmod(0o600)
    link = {"url": "udpout:127.0.0.1:14550", "key_file": "~/key"}
    assert said(wire_checks.links(config(links=[link]), machine(tmp_path)))[0] is Verdict.OK


def test_a_key_that_is_missing_is_found(tmp_path):
    link = {"url": "udpout:127.0.0.1:14550", "key_file": "/etc/ross/key"}
    (finding,) = (each for each in wire_checks.links(config(links=[link]), machine(tmp_path)) if each.check == "keys")
    assert "No such file" in finding.found
    assert finding.todo.startswith("head -c 32 /dev/urandom > /etc/ross/key; chmod 600 /etc/ross/key;")


def test_a_key_that_is_there_is_not_to_be_made_again(tmp_path):
    path = put(tmp_path, "/etc/ross/key")
    path.write_bytes(b"k" * 32)
    path.chmod(0o644)
    link = {"url": "udpout:127.0.0.1:14550", "key_file": "/etc/ross/key"}
    (finding,) = (each for each in wire_checks.links(config(links=[link]), machine(tmp_path)) if each.check == "keys")
    assert finding.todo.startswith("chmod 600 /etc/ross/key;")


@pytest.mark.parametrize(
    ("tables", "verdict"),
    [
        ({}, Verdict.OK),
        ({"telemetry": {"system_id": 0}}, Verdict.FAIL),
        ({"telemetry": {"system_id": 0}, "links": [{"url": DEVICE, "role": "autopilot"}]}, Verdict.OK),
        ({"mount": {"source": "autopilot"}}, Verdict.FAIL),
        ({"telemetry": {"system_id": 255}}, Verdict.WARN),
    ],
)
def test_ids_and_roles_must_fit(tmp_path, tables, verdict):
    assert said(wire_checks.identity(config(**tables), machine(tmp_path)))[0] is verdict


def test_an_extra_that_is_not_asked_for_is_not_looked_for(tmp_path):
    assert not list(wire_checks.extras(config(audio={"source": "tcp:127.0.0.1:1"}), machine(tmp_path)))


def test_pins_ask_for_the_library_that_drives_them(tmp_path):
    pins = {"kind": "tb6600", "options": {"port": "pulses:lgpio:0:23,24,25"}}
    finding = said(wire_checks.extras(config(audio={"source": "tcp:127.0.0.1:1"}, actuator=pins), machine(tmp_path)))
    assert finding[1].startswith("lgpio is ")
