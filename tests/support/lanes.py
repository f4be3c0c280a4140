"""How a test runs decides beside what it may run: every test belongs to one lane.

``pure``      one process, no clock but the test's own
``lockstep``  computes in simulated time
``process``   starts programs, or speaks through sockets and files, and waits for what comes, however long it takes
``realtime``  holds the product to times of this world, in seconds: it mostly waits, and leaves room for others
``alone``     measures milliseconds, counts pulses or samples of a sound card, or loads the computer on purpose
``browser``   drives a real Chromium

A folder of ``tests`` says the lane of what lies in it; a marker of that name, on a file or a test, says it instead.
What lies among the pure and imports what leaves the process (`REACHES_OUT`) is ``process``.
The first three run beside each other. The others claim something about time, lie in folders of their own (``alone`` in
those of ``realtime``), and run when the first three have ended: at a higher priority, where the system allows it, so
that what else the computer does cannot make them late. A test that is ``alone`` has no other test beside it.

``python tests/support/lanes.py [ARGUMENTS OF PYTEST]`` runs all of them so.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import ModuleType

TESTS = Path(__file__).parents[1]
LANES = ("pure", "lockstep", "process", "realtime", "alone", "browser")
FOLDERS = {
    "unit": "pure",
    "contract": "lockstep",
    "lockstep": "lockstep",
    "dist": "process",
    "process": "process",
    "interop": "realtime",
    "realtime": "realtime",
    "browser": "browser",
}
REACHES_OUT = {"aiohttp", "asyncio", "multiprocessing", "pty", "socket", "subprocess", "threading"} | {
    "fleet_bench", "ground_page", "processes", "served_ground", "station_bench", "voice_sender",
    "waiting",  # tests/support
}  # fmt: skip
TIMED = {"realtime": ("realtime", "alone"), "browser": ("browser",)}  # folders of other lanes hold none of these
FIRST = (  # what takes long, the longest first, so that nobody waits for it in the end
    "test_endurance", "test_own_actuator_probe", "test_first_look", "test_grbl_peer",
    "test_listening_live", "test_full_disk", "test_through_ardupilot", "test_signed", "test_actuator_latency",
    "test_gimbal_pilot", "test_weather", "test_whole_mission", "test_tour", "test_shell",
)  # fmt: skip
ALWAYS = "not hardware and not soak"
NOTHING_SELECTED = 5  # exit code of pytest
REPORTS = "ROSS_TEST_REPORTS"  # a folder for reports in junit's form


@dataclass(frozen=True)
class Pass:
    """Lanes that run beside each other, in so many processes."""

    lanes: tuple[str, ...]
    workers: int  # 0: in the process of pytest itself, one after the other
    paths: tuple[str, ...] = ()  # where they lie; empty: anywhere
    ignored: tuple[str, ...] = ()  # where none of them lies: every process imports what it collects
    niceness: int = 0


PASSES = (
    Pass(("pure", "lockstep", "process"), workers=4, ignored=("tests/realtime", "tests/browser")),
    Pass(("realtime",), workers=4, paths=("tests/realtime", "tests/interop"), niceness=-10),
    Pass(("alone",), workers=0, paths=("tests/realtime", "tests/interop"), niceness=-10),
    Pass(("browser",), workers=3, paths=("tests/browser",), niceness=-10),
)


def lane_of(path: Path, markers: Iterable[str], imports: Iterable[str] = ()) -> str:
    """Return the lane of a test in this file that has these markers and imports.

    Raises
    ------
    ValueError
        When there is none, or more than one.
    """
    named = sorted(set(markers) & set(LANES))
    if len(named) > 1:
        raise ValueError(f"two lanes: {', '.join(named)}")
    folder = path.relative_to(TESTS).parts[0] if path.is_relative_to(TESTS) else "unit"  # a docstring's example
    own = FOLDERS.get(folder)
    if not named and own is None:
        raise ValueError(f"no lane: mark it with one of {', '.join(LANES)}, or put it into one of {', '.join(FOLDERS)}")
    lane = named[0] if named else str(own)
    home = next((each for each in TIMED if lane in TIMED[each]), None)
    if home is not None and home != own:
        raise ValueError(f"lane {lane}: lies in {', '.join(folder for folder in FOLDERS if FOLDERS[folder] == home)}")
    if folder in TIMED and lane not in TIMED[folder]:
        raise ValueError(f"lane {lane}: expected {' or '.join(TIMED[folder])}, as all of tests/{folder}")
    return "process" if lane == "pure" and not named and REACHES_OUT & set(imports) else lane


def begins(path: Path) -> int:
    """Return the place of a file's tests among the others: what takes long begins (`FIRST`)."""
    return FIRST.index(path.stem) if path.stem in FIRST else len(FIRST)


def imports_of(module: object) -> frozenset[str]:
    """Return the names of the modules from which a module has something."""
    things = vars(module).values() if module is not None else ()
    names = (
        thing.__name__ if isinstance(thing, ModuleType) else getattr(thing, "__module__", None) for thing in things
    )
    return frozenset(name.split(".")[0] for name in names if isinstance(name, str))


def main(arguments: list[str]) -> int:
    """Run every pass, also when one before it has failed; return 0 when all of them passed."""
    chosen = any(not word.startswith("-") and Path(word.split("::")[0]).exists() for word in arguments)
    codes = []
    for number, each in enumerate(PASSES, 1):
        print(f"\n{', '.join(each.lanes)}: {each.workers or 1} at a time", flush=True)
        command = [sys.executable, "-m", "pytest", "-m", f"{ALWAYS} and ({' or '.join(each.lanes)})"]
        command += ["--numprocesses", str(each.workers), "--dist", "worksteal"] if each.workers else []
        command += () if chosen else (*each.paths, *(f"--ignore={path}" for path in each.ignored))
        if folder := os.environ.get(REPORTS):
            command.append(f"--junitxml={folder}/{number}.xml")
        began = time.monotonic()
        hurry = partial(_hurry, each.niceness)
        codes.append(subprocess.run([*command, *arguments], check=False, preexec_fn=hurry).returncode)
        print(f"{', '.join(each.lanes)}: {time.monotonic() - began:.0f} s", flush=True)
    bad = [code for code in codes if code not in (0, NOTHING_SELECTED)]
    return bad[0] if bad else min(codes)


def _hurry(niceness: int) -> None:
    with suppress(PermissionError):
        os.nice(niceness)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
