"""A bare Debian of this computer's release, as a folder to enter; and the wheels that a payload needs, fetched once."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CLEAN = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C"}


def need(**tools: str) -> None:
    """Skip where a tool is missing, or the right to use it; say which package of Debian brings it."""
    for tool, package in tools.items():
        if shutil.which(tool.replace("_", "-")) is None:
            pytest.skip(f"{tool.replace('_', '-')} is missing: apt-get install {package}")
    if os.getuid():
        pytest.skip("a file system of another Debian is entered as root")


def run(command: list[object], **options: object) -> subprocess.CompletedProcess[str]:
    """Run a program that must succeed."""
    text = [str(word) for word in command]
    done = subprocess.run(text, capture_output=True, text=True, check=False, **options)  # type: ignore[call-overload]
    assert done.returncode == 0, f"{' '.join(text)}:\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done  # type: ignore[no-any-return]


def bare(folder: Path) -> Path:
    """Make the smallest Debian of this release that has apt, as an archive."""
    need(mmdebstrap="mmdebstrap")
    archive = folder / "bare.tar"
    release = platform.freedesktop_os_release()["VERSION_CODENAME"]
    run(["mmdebstrap", "--quiet", "--variant=minbase", release, archive])
    return archive


def wheels_of_a_payload(folder: Path) -> Path:
    """Fetch what a payload runs on, verified, and what builds its wheel, as pip is configured here."""
    tools = folder / "tools"
    run(["/usr/bin/python3", "-m", "venv", tools])
    fetch = [
        tools / "bin/python",
        "-m",
        "pip",
        "--quiet",
        "download",
        "--only-binary",
        ":all:",
        "--dest",
        folder / "wheels",
    ]
    run([*fetch, "--require-hashes", "--requirement", ROOT / "requirements-hashed.txt"])
    run([*fetch, "--constraint", ROOT / "constraints.txt", "hatchling"])
    return folder / "wheels"


class Chroot:
    """A folder with another system in it."""

    def __init__(self, folder: Path, archive: Path) -> None:
        self.folder = folder
        folder.mkdir()
        run(["tar", "-C", folder, "-xf", archive])

    def command(self, *words: object, user: str = "") -> list[object]:
        """Return a command that runs another one inside."""
        inside = ["chroot", self.folder, "/usr/bin/env", "-i", *(f"{name}={value}" for name, value in CLEAN.items())]
        become = ["setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups", "env", f"HOME=/var/lib/{user}"]
        return [*inside, *(become if user else []), *words]

    def run(self, *words: object, user: str = "") -> str:
        """Run a program inside that must succeed; return what it said."""
        return run(self.command(*words, user=user)).stdout

    def files(self) -> set[str]:
        """List all files but those in which apt and dpkg keep their books."""
        books = ("/var/lib/apt", "/var/lib/dpkg", "/var/cache", "/var/log", "/proc", "/sys", "/run", "/root")
        listed = self.run("find", "/", "-xdev", "-print").splitlines()
        return {path for path in listed if not path.startswith(books)}


def python_of_debian() -> str:
    """Skip where there is no Python of Debian beside the one that runs the tests."""
    need()
    if not Path("/usr/bin/python3").exists() or sys.platform != "linux":
        pytest.skip("/usr/bin/python3 is missing: apt-get install python3-venv")
    return "/usr/bin/python3"
