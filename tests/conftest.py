"""Shared by all tests: caches and personal data stay out of the user's own folders."""

import os
from functools import cache
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("shared machine", deadline=None)  # a busy machine makes no example wrong
settings.load_profile("shared machine")

ROOT = Path(__file__).parents[1]
PATIENCE = 10  # how much nicer lockstep tests are


def pytest_addoption(parser):
    parser.addoption("--actuator", metavar="FILE", help="Hold a real device to the contract: a payload's TOML file.")
    parser.addoption("--actuator-kind", metavar="NAME", help="Hold this back end and its far end to the contract.")


def pytest_configure(config):
    if config.getoption("--actuator-kind"):
        import rigs

        rigs.KINDS = (config.getoption("--actuator-kind"),)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Let tests in lock-step leave the processor to those in real time beside them."""
    if item.get_closest_marker("hardware") or not item.get_closest_marker("lockstep") or not may_hurry_again():
        return (yield)
    before = os.getpriority(os.PRIO_PROCESS, 0)
    os.setpriority(os.PRIO_PROCESS, 0, before + PATIENCE)
    try:
        return (yield)
    finally:
        os.setpriority(os.PRIO_PROCESS, 0, before)


@cache
def may_hurry_again():
    """Whether the system lets this process take back that it was nice."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    try:
        os.setpriority(os.PRIO_PROCESS, 0, before + 1)
        os.setpriority(os.PRIO_PROCESS, 0, before)
    except PermissionError:
        return False
    return True


@pytest.fixture(scope="session", autouse=True)
def own_folders(tmp_path_factory):
    """Rooms and synthetic voices are cached beside pytest's own cache; voice prints go to a temporary folder."""
    patch = pytest.MonkeyPatch()
    if "ROSS_CACHE" not in os.environ:
        patch.setenv("ROSS_CACHE", str(ROOT / ".pytest_cache" / "ross"))
    patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("data")))
    yield
    patch.undo()


@pytest.fixture
def speech():
    """The folder of recorded talkers, which is not in the repository."""
    folder = Path(os.environ.get("ROSS_SPEECH", ROOT.parent / "shared" / "speech"))
    if not folder.is_dir():
        pytest.skip(f"needs the recordings in ../shared/speech (or ROSS_SPEECH); {folder.name} is missing")
    return folder
