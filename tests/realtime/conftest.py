"""What simulated missions share, and where what is measured in real time is written."""

from pathlib import Path

import pytest

from mission_fixtures import fly, free_port, ground_station, process, run, short  # noqa: F401
from own_actuator import folder  # noqa: F401
from ross_sim.study.row_files import as_csv


@pytest.fixture(scope="session")
def written(pytestconfig):
    """Write rows into a file of the folder ``--rows``, with those of the same name before; without it write nothing."""
    target, known = pytestconfig.getoption("--rows"), {}

    def write(name, rows):
        known.setdefault(name, []).extend(rows)
        if target is not None:
            Path(target, name).write_bytes(as_csv(known[name], type(known[name][0])))

    return write
