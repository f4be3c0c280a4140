"""The computer as the doctor sees it: its files, its programs and who asks; a test gives it another one."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ross_payload.clock import may_hurry

PROGRAM_TIMEOUT_S = 5.0  # [s] that a program may take


def output_of(command: Sequence[str]) -> str | None:
    """Return what a program prints; None when it is not there, fails or hangs."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PROGRAM_TIMEOUT_S, check=True)  # noqa: S603
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def writable(path: Path) -> bool:
    """Tell whether this user may read and write a file or use a folder."""
    return os.access(path, os.R_OK | os.W_OK | (os.X_OK if path.is_dir() else 0))


@dataclass(frozen=True, slots=True)
class Machine:
    """Everything that checks of the computer read."""

    root: Path = Path("/")
    environment: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))
    run: Callable[[Sequence[str]], str | None] = output_of
    may_use: Callable[[Path], bool] = writable
    may_hurry: Callable[[], bool] = may_hurry
    python: tuple[int, int] = sys.version_info[:2]
    bits: int = 8 * struct.calcsize("P")

    def path(self, where: str | Path) -> Path:
        """Return where a file of this computer is; a relative path is one in the folder in which we are."""
        return self.root / str(Path(where).absolute()).lstrip("/")

    def text(self, where: str) -> str:
        """Return the content of a small file; empty when it cannot be read."""
        try:
            return self.path(where).read_text(encoding="utf-8", errors="replace").strip("\0\n ")
        except OSError:
            return ""

    def names(self, folder: str, *patterns: str) -> list[str]:
        """Return the files of a folder that match, as paths of this computer, sorted."""
        found = {path for pattern in patterns for path in self.path(folder).glob(pattern)}
        return sorted(f"/{path.relative_to(self.root)}" for path in found)

    @property
    def is_pi(self) -> bool:
        """Whether it is a Raspberry Pi."""
        return "Raspberry Pi" in self.text("/proc/device-tree/model")
