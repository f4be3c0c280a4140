"""The state folder: what outlives a restart."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ross_payload.errors import ConfigError
from ross_payload.named_paths import expanded, nearest_there

if TYPE_CHECKING:  # `ross health` does without it
    from ross_payload.config import Config


def named_folder(named: str, environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of what outlives a restart by its name in a configuration; "" leaves it to the environment."""
    named = named or environment.get("STATE_DIRECTORY", "").partition(":")[0]
    return _expanded("service.state_dir", named) if named else Path.home() / ".local" / "state" / "ross"


def state_path(config: Config, environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of what outlives a restart; it need not be there."""
    return named_folder(config.service.state_dir, environment)


def recording_path(config: Config, environment: Mapping[str, str] = os.environ) -> Path:
    """Return the folder of the recorded sessions; it need not be there."""
    named = config.recording.folder
    return _expanded("recording.folder", named) if named else state_path(config, environment) / "recordings"


def state_folder(config: Config) -> Path:
    """Return the folder of what outlives a restart, made when it is missing, for its owner alone.

    Raises
    ------
    ConfigError
        When it cannot be made.
    """
    folder = state_path(config)
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise _unmade(folder, error.errno) from error
    return folder


def check_state_folder(config: Config) -> None:
    """Refuse a folder that cannot be made, and make none.

    Raises
    ------
    ConfigError
        When a file is in its way, or its parents may not be written.
    """
    folder = state_path(config)
    there = nearest_there(folder)
    if not there.is_dir():
        raise _unmade(folder, errno.EEXIST if there == folder else errno.ENOTDIR)
    if there != folder and not os.access(there, os.W_OK | os.X_OK):
        raise _unmade(folder, errno.EACCES)


def _expanded(key: str, named: str) -> Path:
    try:
        return expanded(named)
    except ConfigError as error:
        raise ConfigError(f"{key}: {error}") from error


def _unmade(folder: Path, number: int | None) -> ConfigError:
    return ConfigError(f"service.state_dir: {folder} cannot be made: {os.strerror(number or errno.EIO)}")
