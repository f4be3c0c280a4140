"""How a test runs decides beside what it may run: every test belongs to one lane.

``pure``      one process, no clock but the test's own
``lockstep``  computes in simulated time
``process``   starts programs, or speaks through sockets and files, and waits for what comes, however long it takes
``realtime``  holds the product to times of this world, in seconds: it mostly waits, and leaves room for others
``alone``     measures milliseconds, counts pulses or samples of a sound card, or loads the computer on purpose
``browser``   drives a real Chromium

A folder of ``tests`` says the lane of what lies in it; a marker of that name, on a file or a test, says it instead.
What lies among the pure and imports what leaves the process (`REACHES_OUT`) is ``process``.
The lanes run in stages (`STAGES`), in processes that are forked from one that has collected them (`forked_workers`).
What claims something about time lies in folders of its own (``alone`` in those of ``realtime``), and runs at a higher
priority, where the system allows it, so that what else the computer does cannot make it late. While it waits, or a
browser does, ``pure`` tests use the processors, but only as long as nobody else wants them (SCHED_IDLE). A test that is
``alone`` has no other test beside it.

``python tests/support/lanes.py [ARGUMENTS OF PYTEST]`` runs all of them so.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import ModuleType

import pytest

import forked_programs
from forked_workers import ForkedWorkers, Stage

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
REACHES_OUT = {"aiohttp", "asyncio", "distributed", "multiprocessing", "pty", "socket", "subprocess", "threading"} | {
    "fleet_bench", "ground_page", "processes", "served_ground", "station_bench", "voice_sender",
    "waiting",  # tests/support
}  # fmt: skip
TIMED = {"realtime": ("realtime", "alone"), "browser": ("browser",)}  # folders of other lanes hold none of these
FIRST = (  # what takes long, the longest first, so that nobody waits for it in the end
    "test_guides", "test_sitl", "test_ground_command", "test_onlooker", "test_signed",
    "test_bad_input_live", "test_study", "test_ground_station", "test_slip", "test_drone",
    "test_live_portaudio", "test_first_look", "test_gimbal_pilot", "test_turntable_gimbal",
    "test_grbl_peer", "test_device", "test_through_ardupilot", "test_full_disk",
    "test_canopen_peer", "test_weather", "test_ground_promptness", "test_shell",
    "test_whole_mission", "test_listening", "test_ground_page", "test_portaudio",
)  # fmt: skip
REPORTS = "ROSS_TEST_REPORTS"  # a folder for reports in junit's form


STAGES = (
    Stage(("lockstep", "process"), workers=6),
    Stage(("realtime",), workers=6, niceness=-10, spare=True),
    Stage(("alone",), workers=1, niceness=-10, quiet=True),
    Stage(("browser",), workers=2, niceness=-10, spare=True),
    Stage(("pure",), workers=4),
)
SPARE = Stage(("pure",), workers=2, niceness=19)


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
    """Run every stage; return pytest's exit code."""
    folder = os.environ.get(REPORTS)
    forked_programs.install()
    forked_programs.begin(wait=False)  # it imports while pytest collects
    reports = [f"--junitxml={folder}/1.xml"] if folder else []
    return pytest.main([*reports, *arguments], plugins=[ForkedWorkers(STAGES, SPARE, _prepare)])


def _prepare(stage: Stage) -> None:
    """Give a worker the place among others that its stage has."""
    with suppress(PermissionError):
        os.nice(stage.niceness)
    if stage is SPARE:
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    if "pure" not in stage.lanes:
        forked_programs.begin()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
