"""Checks of the computer itself: Python, clock, heat, priority, power, and the folders in which things are kept."""

from __future__ import annotations

import os
from collections.abc import Iterator

from ross_payload.config import Config
from ross_payload.doctor.findings import Finding, fail, ok, warn
from ross_payload.doctor.machine import Machine
from ross_payload.errors import ConfigError
from ross_payload.named_paths import nearest_there
from ross_payload.service.state_folder import is_read_only, recording_path, state_path, unusable_recordings
from ross_payload.voiceprint import VoiceStore
from ross_payload.voiceprint.model_folder import ModelFolder

GB = 1e9
PRIVATE = 0o077  # nobody else's bits
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


def state(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether parameters that are set in flight can be kept."""
    folder = state_path(config, machine.environment)
    there = nearest_there(machine.path(folder))
    if machine.may_use(there):
        yield ok("state", f"{folder} can be written")
    elif is_read_only(there):
        todo = "mount it for writing; one that is damaged, as an SD card, is mounted so by the system: see dmesg"
        yield fail("state", f"{folder} is on a file system that is mounted read-only", todo)
    else:
        todo = "run as the user of the service (sudo -u ross), or give it the folder: sudo chown ross"
        yield fail("state", f"{folder} cannot be written by this user", todo)


def recordings(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether sessions can be recorded, have room, and are read by nobody else."""
    wanted, folder = config.recording, recording_path(config, machine.environment)
    path = machine.path(folder)
    there, why = nearest_there(path), unusable_recordings(folder, path)
    if why or not machine.may_use(there):
        say = fail if wanted.always else warn
        found = why or f"recording.folder: {folder} cannot be written by this user"
        yield say("recording", found, "choose another recording.folder, or let this user use it")
        return
    if path.exists() and path.stat().st_mode & PRIVATE:
        yield warn("recording", f"{folder} can be read by others: voices are personal data", f"chmod 700 {folder}")
    system = os.statvfs(there)
    free = system.f_bavail * system.f_frsize / GB
    if free < wanted.min_free_gb + min(wanted.max_gb, 1.0):
        found = f"{free:.1f} GB free, of which {wanted.min_free_gb:g} GB are kept free (recording.min_free_gb)"
        yield warn("recording", found, "free some space: recording stops when the disk is full, the mission continues")
    else:
        yield ok("recording", f"{folder}, {free:.1f} GB free")


def voice(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether voices can be compared, and the one to look for is enrolled, whole, and read by nobody else."""
    name = config.service.target
    try:
        model = ModelFolder.default(machine.environment).in_use(config.voice_print.model)
    except ConfigError as error:
        yield fail("voice", f"voice_print.model: {error}", "ross voice-model list; ross voice-model remove NAME")
        return
    if not name:
        if config.service.autostart == "seek":
            yield fail("voice", "service.autostart = 'seek', but no service.target", "name an enrolled voice")
        else:
            yield ok("voice", "no target voice is configured")
        return
    store = VoiceStore.default(machine.environment)
    try:
        store.load(name, model)
    except ConfigError as error:
        yield fail("voice", str(error), f"as the user of the service: ross enroll {name} FILE.wav")
        return
    path = store.path(name)
    if (path.stat().st_mode | path.parent.stat().st_mode) & PRIVATE:
        found = f"the voice print of {name} can be read by others"
        yield warn("voice", found, f"chmod 700 {path.parent}; chmod 600 {path}")
    else:
        yield ok("voice", f"{name} is enrolled")
