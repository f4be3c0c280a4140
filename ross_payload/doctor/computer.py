"""Checks of the computer itself: Python, clock, heat, priority, power."""

from __future__ import annotations

from collections.abc import Iterator

from ross_payload.config import Config
from ross_payload.doctor.finding import Finding, ok, warn
from ross_payload.doctor.machine import Machine

HOT = 75.0  # [deg Celsius]; a Raspberry Pi slows down from 80
NOW = {0: "under-voltage", 1: "frequency capped", 2: "throttled", 3: "soft temperature limit"}
EARLIER = 16  # bits of what has happened since boot stand so much higher


def python(config: Config, machine: Machine) -> Iterator[Finding]:
    """Python and the word length of the system."""
    version = ".".join(map(str, machine.python))
    if machine.bits == 64:
        yield ok("python", f"{version}, 64 bit")
    else:
        yield warn("python", f"{version}, {machine.bits} bit", "install a 64-bit system: nothing else is tested")


def clock(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether the time of day is right: recordings and signatures carry it."""
    synchronised = machine.run(("timedatectl", "show", "--property=NTPSynchronized", "--value"))
    if synchronised == "yes":
        yield ok("clock", "synchronised")
    elif synchronised == "no":
        todo = "connect a network once, or fit an RTC; signed links refuse times that run backwards"
        yield warn("clock", "not synchronised: the date may be wrong", todo)
    else:
        yield warn("clock", "cannot tell whether it is synchronised (no timedatectl)", "compare `date` with a watch")


def heat(config: Config, machine: Machine) -> Iterator[Finding]:
    """Temperature of the processor, where the kernel tells it."""
    zones = machine.names("/sys/class/thermal", "thermal_zone*/temp")
    readings = [int(text) / 1000 for zone in zones if (text := machine.text(zone)).lstrip("-").isdecimal()]
    if not readings:
        yield ok("temperature", "not available on this computer")
    elif max(readings) < HOT:
        yield ok("temperature", f"{max(readings):.0f} deg C")
    else:
        yield warn(
            "temperature", f"{max(readings):.0f} deg C", "fit a heat sink or a fan: the processor slows down when hot"
        )


def priority(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether pulses, which every other program can delay, may go before other programs."""
    if config.actuator.kind != "tb6600":
        return
    if machine.may_hurry():
        yield ok("priority", "real-time priority is allowed")
    else:
        found = "no right to real-time priority: beside busy programs pulses run out, and the position is lost"
        yield warn("priority", found, "run as the service, whose unit gives the right; by hand `ulimit -r 20` first")


def power(config: Config, machine: Machine) -> Iterator[Finding]:
    """What a Raspberry Pi says about its supply and its speed."""
    if not machine.is_pi:
        return
    text = (machine.run(("vcgencmd", "get_throttled")) or "").partition("=")[2]
    if not text.startswith("0x"):
        todo = "sudo usermod -aG video USER, then log in again"
        yield warn("power", "vcgencmd gives no answer", todo)
        return
    bits = int(text, 16)
    now = [name for bit, name in NOW.items() if bits >> bit & 1]
    earlier = [name for bit, name in NOW.items() if bits >> (bit + EARLIER) & 1 and name not in now]
    words = [f"{', '.join(now)} now"] * bool(now) + [f"{', '.join(earlier)} since boot"] * bool(earlier)
    if words:
        yield warn("power", "; ".join(words), "use a supply of 5.1 V with enough current, and cool it")
    else:
        yield ok("power", "never throttled since boot")
