"""The sound cards that PortAudio sees, and how one is found by a part of its name."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any, Literal

from ross_payload.config.array_presets import fitting
from ross_payload.errors import AudioError, ConfigError
from ross_payload.plugins import install_line

MODULE = "sounddevice"
Way = Literal["input", "output"]
NAMES = {"input": ("audio.source", "microphones"), "output": ("device", "sound output")}  # in messages


@dataclass(frozen=True, slots=True)
class Device:
    """One device that can record, or play."""

    number: int  # PortAudio's, which changes when devices come and go
    name: str
    host_api: str
    channels: int
    default_rate: float  # [Hz]
    preset: str  # that fits its name, or empty

    def __str__(self) -> str:
        return f"'{self.name}' ({self.host_api}, {self.channels} channels)"


def portaudio() -> Any:
    """Import the binding to PortAudio.

    Raises
    ------
    ConfigError
        When the binding is not installed.
    AudioError
        When the system has no PortAudio.
    """
    try:
        return importlib.import_module(MODULE)
    except ModuleNotFoundError as error:
        raise ConfigError(f"sound cards need the package {MODULE}: {install_line('capture')}") from error
    except OSError as error:
        raise AudioError("sound cards need the library PortAudio: apt install libportaudio2") from error


def devices(module: Any, way: Way = "input") -> list[Device]:
    """Return every device that can record, or play."""
    hosts = [host["name"] for host in module.query_hostapis()]
    return [
        Device(
            number=number,
            name=found["name"],
            host_api=hosts[found["hostapi"]],
            channels=found[f"max_{way}_channels"],
            default_rate=found["default_samplerate"],
            preset=fitting(found["name"], found[f"max_{way}_channels"]),
        )
        for number, found in enumerate(module.query_devices())
        if found.get(f"max_{way}_channels", 0) > 0
    ]


def device_named(module: Any, name: str, way: Way = "input") -> Device:
    """Find one device that records or plays.

    It goes by ``default``, its whole name, or a part of it that no other has; the case does not matter.

    Raises
    ------
    AudioError
        When there is none, or more than one; lists them.
    """
    there, key, what = devices(module, way), *NAMES[way]
    if name == "default":
        number = module.default.device[way == "output"]
        chosen = [device for device in there if device.number == number] or there[:1]
    else:
        wanted = name.lower()
        chosen = [device for device in there if device.name.lower() == wanted]
        chosen = chosen or [device for device in there if wanted in device.name.lower()]
    if not chosen:
        raise AudioError(f"{key}: no {what} named '{name}'; there are: {_listed(there)}")
    if len(chosen) > 1:
        raise AudioError(
            f"{key}: '{name}' matches more than one device: {_listed(chosen)}; use a longer part of the name"
        )
    return chosen[0]


def _listed(there: list[Device]) -> str:
    return ", ".join(map(str, there)) or "none at all"
