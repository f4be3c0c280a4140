"""Shared by all tests: caches and personal data stay out of the user's own folders."""

import gc
import os
import signal
from functools import cache
from pathlib import Path

import pytest
from hypothesis import settings

import examples
import forked_programs
import lanes
from forked_workers import ForkedWorkers

settings.load_profile(examples.TEST)

ROOT = Path(__file__).parents[1]
PROMPT = b">>>"
HEARD = "MAVLINK20"  # what pymavlink writes into the environment when it hears a message of this version
COLLECTED = (20_000, 20, 20)  # thresholds of the garbage collector: what the tests make is mostly gone without it
USUAL = "not hardware and not soak"  # what runs unless -m is given, see pyproject.toml


def pytest_addoption(parser):
    parser.addoption("--actuator", metavar="FILE", help="Hold a real device to the contract: a payload's TOML file.")
    parser.addoption("--audio-source", metavar="NAME:ADDRESS", help="Hold this source of live sound to the contract.")
    parser.addoption("--rows", metavar="FOLDER", help="Where soak tests write what they measured, as rows of tables.")
    parser.addoption("--actuator-kind", metavar="NAME", help="Hold this back end and its far end to the contract.")


class Examples:
    """Look for examples in docstrings only where there are any: to look at everything takes seconds."""

    @pytest.hookimpl(wrapper=True)
    def pytest_collect_file(self, file_path):
        found = yield
        if file_path.suffix == ".py" and PROMPT not in file_path.read_bytes():
            found = [each for each in found if type(each) is pytest.Module]
        return found


def pytest_configure(config):
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a background job
        signal.signal(signal.SIGINT, signal.default_int_handler)
    forked_programs.install()
    config.pluginmanager.register(Examples())  # a hook of this file would see the tests alone
    if config.getoption("--actuator-kind"):
        import rigs

        rigs.KINDS = (config.getoption("--actuator-kind"),)
    if (config.getoption("--actuator-kind") or config.getoption("--audio-source")) and config.option.markexpr == USUAL:
        config.option.markexpr = "not hardware"  # somebody's own is held to the whole contract, soak included


def pytest_collection():
    """Collect without the garbage collector: thousands of tests and modules are made, and all of them stay."""
    gc.disable()


def pytest_collection_finish(session):
    """From now on the garbage collector looks only at what the tests make, and no import makes a test late.

    Workers begin when all of them have collected.
    """
    gc.freeze()
    gc.set_threshold(*COLLECTED)
    gc.enable()
    if (
        not session.config.option.collectonly
        and not ForkedWorkers.runs(session.config)
        and any(item.get_closest_marker(lane) for item in session.items for lane in sum(lanes.TIMED.values(), ()))
    ):
        forked_programs.begin()


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(items):
    """Give every test its lane: the marker's, or that of its folder. Mark those that draw examples."""
    imports, lane_of = cache(lanes.imports_of), cache(lanes.lane_of)
    for item in items:
        if getattr(getattr(item, "obj", None), "is_hypothesis_test", False):
            item.add_marker("random")
        try:
            markers = frozenset(mark.name for mark in item.iter_markers())
            item.add_marker(lane_of(item.path, markers, imports(getattr(item, "module", None))))
        except ValueError as error:
            raise pytest.UsageError(f"{item.nodeid}: {error}") from error
    items.sort(key=lambda item: lanes.begins(item.path))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call():
    """Forget what pymavlink has heard: programs that start in another environment are not forked, but restarted."""
    before = os.environ.get(HEARD)
    try:
        return (yield)
    finally:
        if before is None:
            os.environ.pop(HEARD, None)


@pytest.fixture(scope="session", autouse=True)
def own_folders(tmp_path_factory):
    """Rooms and synthetic voices are cached beside pytest's own cache; voice prints and state go elsewhere."""
    patch = pytest.MonkeyPatch()
    if "ROSS_CACHE" not in os.environ:
        patch.setenv("ROSS_CACHE", str(ROOT / ".pytest_cache" / "ross"))
    patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("data")))
    patch.setenv("STATE_DIRECTORY", str(tmp_path_factory.mktemp("state")))
    yield
    patch.undo()


@pytest.fixture(scope="session")
def written(pytestconfig):
    """Write rows into a file of the folder ``--rows``, with those of the same name before; without it write nothing."""
    from ross_sim.study.rows.row_files import as_csv

    target, known = pytestconfig.getoption("--rows"), {}

    def write(name, rows):
        known.setdefault(name, []).extend(rows)
        if target is not None:
            Path(target, name).write_bytes(as_csv(known[name], type(known[name][0])))

    return write


@pytest.fixture(scope="session")
def speech():
    """The folder of recorded talkers, which is not in the repository."""
    folder = Path(os.environ.get("ROSS_SPEECH", ROOT.parent / "shared" / "speech"))
    if not folder.is_dir():
        pytest.skip(f"needs the recordings in ../shared/speech (or ROSS_SPEECH); {folder.name} is missing")
    return folder


@pytest.fixture
def shared_model():
    """A published network of speakers, which is not in the repository."""
    folder = Path(os.environ.get("ROSS_MODELS", ROOT.parent / "shared" / "models"))
    found = sorted(folder.glob("*.onnx"))
    if not found:
        pytest.skip(f"needs the network in ../shared/models (or ROSS_MODELS); {folder.name} is missing")
    return found[0]
