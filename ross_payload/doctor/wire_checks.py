"""Checks of what is plugged in: serial ports, their console, CAN, links and keys."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

from ross_payload.actuators.registry import checked_options
from ross_payload.actuators.wires.serial import group_name
from ross_payload.config import Config, Link
from ross_payload.doctor.findings import Finding, fail, ok, warn
from ross_payload.doctor.machine import Machine
from ross_payload.errors import ConfigError, RossError
from ross_payload.named_paths import expanded
from ross_payload.plugins import EXTRA_OF, install_line
from ross_payload.transport.link_url import LOOPBACK, Serial, Tcp, Udp, parse
from ross_payload.transport.signing import read_key
from ross_payload.transport.tcp import open_listeners
from ross_payload.transport.udp import open_udp

CAN = re.compile(r"(?<![A-Za-z0-9])((?:v|sl)?can[0-9]+)(?![A-Za-z0-9])")
DEVICES = ("serial/by-id/*", "ttyUSB*", "ttyACM*", "ttyAMA*", "serial[0-9]", "ross-*")
ADAPTER = re.compile(r"can:\w+:(/dev/.+?)(?::[0-9]+)?")  # a CAN adapter that is a serial port
PI5_DEBUG = "ttyAMA10"  # UART of a Raspberry Pi 5 on its debug connector, to which /dev/serial0 leads there
IFF_UP = 1
LOCAL = (LOOPBACK, "localhost", "::1")


def extras(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether the packages that the configuration needs are installed."""
    needed = {
        "sounddevice": config.audio.source.startswith("device:"),
        "serial": bool(serial_devices(config)),
        "can": any(re.match("can:(?!tcp:)", text) for text in _wires(config)) or bool(can_interfaces(config)),
        "lgpio": any(text.startswith("pulses:lgpio:") for text in _texts(config.actuator.options)),
    }
    for package, asked in needed.items():
        if asked and find_spec(package) is None:
            todo = install_line(EXTRA_OF[package])
            yield fail("packages", f"{package} is missing", todo)
        elif asked:
            yield ok("packages", f"{package} is installed")


def serial(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether every serial port that is named exists, is ours to use, and has no console on it."""
    for device in serial_devices(config):
        path = machine.path(device)
        if not path.exists():
            there = ", ".join(machine.names("/dev", *DEVICES)) or "none"
            yield fail("serial", f"{device} does not exist; there are: {there}", "plug it in, or name one of these")
        elif not machine.may_use(path):
            group = group_name(path.stat().st_gid)
            todo = f"sudo usermod -aG {group} USER for the user that runs it, then log in again"
            yield fail("serial", f"{device} cannot be read and written by this user", todo)
        elif path.resolve().name == PI5_DEBUG:
            todo = "for these take /dev/ttyAMA0, with dtparam=uart0=on in config.txt"
            yield warn("serial", f"{device} is a Raspberry Pi 5's debug connector, not its pins 8 and 10", todo)
        else:
            yield ok("serial", f"{device} is there")
        yield from _console(device, machine)


def can(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether every CAN interface that is named is up."""
    for name in can_interfaces(config):
        flags = machine.text(f"/sys/class/net/{name}/flags")
        if not flags:
            there = ", ".join(path.rpartition("/")[2] for path in machine.names("/sys/class/net", "*can*")) or "none"
            todo = "fit the adapter and its dtoverlay; see docs/how-to/raspberry-pi"
            yield fail("can", f"{name} does not exist; there are: {there}", todo)
        elif not int(flags, 16) & IFF_UP:
            todo = f"sudo ip link set {name} up type can bitrate 1000000, or 80-can.network for every boot"
            yield fail("can", f"{name} is down", todo)
        else:
            yield ok("can", f"{name} is up")


def links(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether every link can be opened: address, free port, key; and who may talk to it."""
    if not config.links:
        yield warn("links", "none: no telemetry is sent and no commands are received", "add [[links]]")
    for link in config.links:
        try:
            address = parse(link.url)
        except ConfigError as error:
            yield fail("links", str(error), "see docs/reference/configuration")
            continue
        if not isinstance(address, Serial) and address.listen:
            yield from _listener(link, address)
        elif not isinstance(address, Serial):
            yield ok("links", f"{link.url} is a valid address")
        yield from _key(link, machine)


def identity(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether the MAVLink ids and roles fit together."""
    telemetry, autopilots = config.telemetry, [link for link in config.links if link.role == "autopilot"]
    if telemetry.system_id == 0 and not autopilots:
        todo = "give a link the role 'autopilot', or name the vehicle's number"
        yield fail("identity", "telemetry.system_id = 0 waits for an autopilot, but no link has that role", todo)
    elif config.mount.source == "autopilot" and not autopilots:
        todo = "give a link the role 'autopilot', or use mount.source = 'fixed'"
        yield fail("identity", "mount.source = 'autopilot', but no link has that role", todo)
    elif telemetry.system_id == 255:
        yield warn("identity", "telemetry.system_id = 255 is a ground station's", "use the vehicle's, usually 1")
    elif not 191 <= telemetry.component_id <= 194:
        found = f"telemetry.component_id = {telemetry.component_id} is not an onboard computer's"
        yield warn("identity", found, "use 191 to 194")
    else:
        yield ok("identity", f"system {telemetry.system_id or 'of the autopilot'}, component {telemetry.component_id}")


def serial_devices(config: Config) -> list[str]:
    """Return the serial devices that links, the actuator and [dronecan] name, CAN adapters among them."""
    found = []
    for url in [link.url for link in config.links] + _wires(config):
        if adapter := ADAPTER.fullmatch(url):
            found.append(adapter[1])
        elif url.startswith("serial:") and not url.startswith("serial:tcp:"):
            found.append(url.removeprefix("serial:").rpartition(":")[0] or url.removeprefix("serial:"))
        elif url.startswith("/dev/"):
            found.append(url)
    return list(dict.fromkeys(found))


def can_interfaces(config: Config) -> list[str]:
    """Return the CAN interfaces of this computer that the actuator's options and [dronecan] name."""
    here = [text for text in _wires(config) if "socketcand:" not in text]  # channels of a server are elsewhere
    return list(dict.fromkeys(name for text in here for name in CAN.findall(text)))


def _wires(config: Config) -> list[str]:
    """Return every text that may name a wire: the actuator's options, its port if that is a default, [dronecan]."""
    try:
        port = getattr(checked_options(config), "port", "")
    except RossError:  # the check of the actuator says so
        port = ""
    return [*_texts(config.actuator.options), port, config.dronecan.port]


def _texts(options: Any) -> Iterator[str]:
    if isinstance(options, str):
        yield options
    elif isinstance(options, dict):
        for value in options.values():
            yield from _texts(value)


def _console(device: str, machine: Machine) -> Iterator[Finding]:
    """A login console on the port that the autopilot is on answers it with passwords."""
    name = machine.path(device).resolve().name
    consoles = re.findall(r"console=(\w+)", machine.text("/proc/cmdline"))
    names = {machine.path(f"/dev/{console}").resolve().name for console in consoles}
    if name in names or machine.run(("systemctl", "is-active", f"serial-getty@{name}.service")) == "active":
        todo = "sudo raspi-config nonint do_serial_cons 1, then restart; or take console=... out of cmdline.txt"
        yield fail("console", f"{device} is the system's console", todo)


def _listener(link: Link, address: Udp | Tcp) -> Iterator[Finding]:
    try:
        for sock in open_listeners(address) if isinstance(address, Tcp) else [open_udp(address)]:
            sock.close()
    except OSError as error:
        todo = "another program uses it, perhaps ross.service itself: sudo ss -lptun"
        yield fail("links", f"{link.url} cannot be opened: {error.strerror}", todo)
        return
    if address.host in LOCAL or link.key_file:
        yield ok("links", f"{link.url} is free")
    else:
        todo = "sign it (key_file), or listen on 127.0.0.1 behind a router"
        yield warn("links", f"{link.url} is free, but anyone on this network can command the payload", todo)


def _key(link: Link, machine: Machine) -> Iterator[Finding]:
    if not link.key_file:
        return
    path = machine.path(expanded(link.key_file))
    try:
        read_key(path)
    except ConfigError as error:
        made = "" if os.path.lexists(path) else f"head -c 32 /dev/urandom > {link.key_file}; "
        todo = f"{made}chmod 600 {link.key_file}; chown to the service's user; the same file at the ground station"
        yield fail("keys", str(error), todo)
    else:
        yield ok("keys", f"{link.key_file} is readable by this user only")
