"""What a session folder says about itself: session.json, config.json, memory.npz."""

from __future__ import annotations

import math
import platform
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Literal

from ross_payload.atomic_files import json_text, write_whole
from ross_payload.bounded_files import parsed_json, read_bounded
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.json_values import are_finite
from ross_payload.sessions.npz_memory import VOICE_FILE, packed, packed_voice
from ross_payload.voiceprint import EmbeddingPrint

MANIFEST = "session.json"
FORMAT = "ross-session"
VERSION = 1
PACKAGES = ("ross-payload", "numpy", "scipy", "pymavlink", "pydantic")
Kind = Literal["mission", "session"]


@dataclass(frozen=True, slots=True)
class Beginning:
    """What a replay must know before the first Input."""

    kind: Kind  # one mission, as of `ross sitl`, or a session that obeys orders, as of `ross run`
    config: Config  # in force
    lower: float  # guarded travel of the joint [rad], -inf when continuous
    upper: float  # [rad]
    voice: str = ""  # name of the voice that is sought; its print stays where it is
    memory: Any = None  # what the session knew from earlier tasks: a frozen dataclass
    yaw: float = 0.0  # from which [informed] counts its azimuths in one mission [rad]
    synthetic: EmbeddingPrint | None = None  # the print of a talker that no person is: it is kept with the session


@dataclass(frozen=True, slots=True)
class Manifest:
    """The content of session.json."""

    version: int
    kind: str
    voice: str
    yaw: float  # [rad]
    lower: float  # [rad]
    upper: float  # [rad]
    started: str  # UTC, empty: the clock was not set
    versions: dict[str, str]
    end: str | None  # why it ended, None: it was cut off


def versions() -> dict[str, str]:
    """Versions of what shapes a result."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # a source tree that was never installed
            found[name] = "unknown"
    return found


def write(folder: Path, begin: Beginning, started: str) -> None:
    """Write everything that is known at the beginning; session.json comes first: it makes the folder ours."""
    write_manifest(folder, begin, started)
    write_whole(folder / "config.json", json_text(begin.config.model_dump(mode="json")).encode())
    if begin.memory is not None:
        write_whole(folder / "memory.npz", packed(begin.memory))
    if begin.synthetic is not None:
        write_whole(folder / VOICE_FILE, packed_voice(begin.synthetic))


def write_manifest(folder: Path, begin: Beginning, started: str, end: str | None = None) -> None:
    """Write session.json; ``end``: why the session has come to its end."""
    travel = (begin.lower, begin.upper)
    values = {
        "format": FORMAT,
        "version": VERSION,
        "kind": begin.kind,
        "voice": begin.voice,
        "informed_yaw_rad": begin.yaw,
        "travel_rad": [angle if math.isfinite(angle) else None for angle in travel],
        "started": started,
        "versions": versions(),
        "end": end,
    }
    write_whole(folder / MANIFEST, json_text(values).encode())


def is_session(folder: Path) -> bool:
    """Whether a folder is a session of ours, of any version, and no link to one."""
    try:
        return not folder.is_symlink() and _values(folder)["format"] == FORMAT
    except ConfigError:
        return False


def damage(folder: Path) -> str:
    """Tell why session.json is no JSON that anybody could read; '' when it is, or when there is none."""
    try:
        parsed_json(read_bounded(folder / MANIFEST))
    except (FileNotFoundError, NotADirectoryError, PermissionError):
        return ""
    except OSError as error:
        return error.strerror or "cannot be read"
    except ValueError as error:
        return f"damaged: {error}"
    return ""


def read(folder: Path) -> Manifest:
    """Read session.json, also of another version as far as it says the same.

    Raises
    ------
    ConfigError
        When the folder is no session, or says too little to be read.
    """
    values = _values(folder)
    try:
        lower, upper = values["travel_rad"]
        return Manifest(
            version=int(values["version"]),
            kind=str(values["kind"]),
            voice=str(values["voice"]),
            yaw=_angle(values["informed_yaw_rad"]),
            lower=-math.inf if lower is None else _angle(lower),
            upper=math.inf if upper is None else _angle(upper),
            started=str(values["started"]),
            versions={str(name): str(version) for name, version in dict(values["versions"]).items()},
            end=None if values.get("end") is None else str(values["end"]),
        )
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise ConfigError(f"{folder / MANIFEST}: damaged, or of another version: {error!r}") from error


def _angle(value: Any) -> float:
    if not are_finite(value):
        raise ValueError(f"expected an angle, got {value!r}")
    return float(value)


def _values(folder: Path) -> dict[str, Any]:
    path = folder / MANIFEST
    try:
        values = parsed_json(read_bounded(path))
    except OSError as error:
        raise ConfigError(f"{folder}: not a session folder: session.json: {error.strerror}") from error
    except ValueError as error:
        raise ConfigError(f"{path}: damaged: expected JSON: {error}") from error
    if not isinstance(values, dict) or values.get("format") != FORMAT:
        raise ConfigError(f"{folder}: not a session folder: its session.json is of another program")
    return values
