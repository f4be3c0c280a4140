"""Checks of what is kept: the state folder, recordings, the enrolled voice."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from ross_payload.config import Config
from ross_payload.doctor.finding import Finding, fail, ok, warn
from ross_payload.doctor.machine import Machine
from ross_payload.errors import ConfigError
from ross_payload.service.folders import state_path
from ross_payload.voiceprint import VoiceStore

GB = 1e9
PRIVATE = 0o077  # nobody else's bits


def state(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether parameters that are set in flight can be kept."""
    folder = state_path(config, machine.environment)
    there = _nearest(machine.path(folder))
    if machine.may_use(there):
        yield ok("state", f"{folder} can be written")
    else:
        todo = "run as the user of the service (sudo -u ross), or give it the folder: sudo chown ross"
        yield fail("state", f"{folder} cannot be written by this user", todo)


def recordings(config: Config, machine: Machine) -> Iterator[Finding]:
    """Whether sessions can be recorded, have room, and are read by nobody else."""
    wanted, folder = config.recording, recording_folder(config, machine)
    path = machine.path(folder)
    there = _nearest(path)
    if not machine.may_use(there):
        say = fail if wanted.always else warn
        yield say("recording", f"{folder} cannot be written by this user", "choose another recording.folder")
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
    """Whether the voice to look for is enrolled, whole, and read by nobody else."""
    name = config.service.target
    if not name:
        if config.service.autostart == "seek":
            yield fail("voice", "service.autostart = 'seek', but no service.target", "name an enrolled voice")
        else:
            yield ok("voice", "no target voice is configured")
        return
    store = VoiceStore.default(machine.environment)
    try:
        store.load(name)
    except ConfigError as error:
        yield fail("voice", str(error), f"as the user of the service: ross enroll {name} FILE.wav")
        return
    path = store.path(name)
    if (path.stat().st_mode | path.parent.stat().st_mode) & PRIVATE:
        found = f"the voice print of {name} can be read by others"
        yield warn("voice", found, f"chmod 700 {path.parent}; chmod 600 {path}")
    else:
        yield ok("voice", f"{name} is enrolled")


def recording_folder(config: Config, machine: Machine) -> Path:
    """Return where sessions are recorded."""
    folder = config.recording.folder
    return Path(folder).expanduser() if folder else state_path(config, machine.environment) / "recordings"


def _nearest(path: Path) -> Path:
    """Return the folder, or the nearest one above it that exists."""
    return next(each for each in (path, *path.parents) if each.exists())
