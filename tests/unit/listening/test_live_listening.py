"""Live listening on a thread of its own: neither a mission that computes nor a sink that hangs holds up the voice."""

import itertools
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import soundfile
from threadpoolctl import threadpool_limits

from listening_bench import HOP, RATE, estimate, inputs, source
from ross_payload import plugins
from ross_payload.clock import SystemClock
from ross_payload.config import Config, Table
from ross_payload.events import SourcesEstimated, State, StateChanged
from ross_payload.interfaces import AudioBlock
from ross_payload.listening.observers import LiveListening, LockstepListening
from ross_payload.pointing import Pointing
from ross_payload.streams import StreamOrder
from ross_payload.telemetry.stream_report import brief
from voice_sender import ear
from waiting import wait_for

GRID = 2.0**-23
MIXTURE = (np.random.default_rng(0).integers(-(2**18), 2**18, (2, 4 * RATE)) * GRID).astype(np.float32)


@pytest.fixture(autouse=True)
def one_numeric_thread():
    """As in `ross run`: small products on several cores wait for each other."""
    with threadpool_limits(limits=1):
        yield


def blocks(begin=0.0, end=4.0):
    for index in range(round(begin * RATE), round(end * RATE), HOP):
        yield AudioBlock(MIXTURE[:, index : index + HOP], index, index / RATE)


def here(begin, end):
    return Pointing(time=end), True


def config(tmp_path, *more, what="mixture", **listening):
    streams = ({"sink": "file", "what": what, "options": {"path": str(tmp_path / "heard.wav")}}, *more)
    return Config.model_validate({"listening": {"streams": streams, **listening}})


def live(configuration, tmp_path, locate=here):
    return LiveListening(configuration, SystemClock(), tmp_path, locate=locate)


def heard(tmp_path):
    return soundfile.read(tmp_path / "heard.wav", dtype="float32")[0]


def length(tmp_path):
    path = tmp_path / "heard.wav"
    return (path.stat().st_size - 44) // 3 if path.exists() else 0


def feed(listening, hops):
    """Hops no faster than they are listened to."""
    for block in hops:
        listening.hear(block)
        wait_for(lambda: listening._queue.qsize() < 20)


def test_all_that_was_heard_gets_out_without_any_mission(tmp_path):
    with live(config(tmp_path), tmp_path) as listening:
        feed(listening, blocks())
        wait_for(lambda: length(tmp_path) > 3.9 * RATE)
        (status,) = listening.streams()
        assert (status.on, status.fault, status.lost, status.keeps) == (True, "", 0, True)
        assert status.delay is not None
    assert np.array_equal(heard(tmp_path), MIXTURE[0])


@pytest.mark.soak
def test_a_voice_is_what_the_lock_step_gives_but_for_when_it_is_learnt(tmp_path):
    told = SourcesEstimated(0.0, estimate(), rotations=1, final=True), StateChanged(0.0, State.RUN)
    (first, *_) = inputs(MIXTURE)
    slow = {"what": "source 1", "separator": "gaussian", "learn_s": 10.0}  # nothing is learnt in time: geometry alone
    (tmp_path / "live").mkdir()
    with live(config(tmp_path / "live", **slow), tmp_path) as listening:
        for event in told:
            listening.on_event(event, first)
        feed(listening, blocks(end=1.5))
        wait_for(lambda: length(tmp_path / "live") > 1.4 * RATE)
        assert listening.streams()[0].separated
    (tmp_path / "lockstep").mkdir()
    with LockstepListening(config(tmp_path / "lockstep", **slow), SystemClock(), tmp_path) as lockstep:
        for event in told:
            lockstep.on_event(event, first)
        for hop in inputs(MIXTURE[:, : 3 * RATE // 2]):
            lockstep.on_input(hop)
    assert np.array_equal(heard(tmp_path / "live"), heard(tmp_path / "lockstep"))


def test_what_recordings_must_leave_free_files_of_streams_leave_free_too(tmp_path):
    wanted = config(tmp_path).model_copy(
        update={"recording": Config().recording.model_copy(update={"min_free_gb": 9999})}
    )
    hops = (AudioBlock(MIXTURE[:, :HOP], index, index / RATE) for index in itertools.count(0, HOP))
    with live(wanted, tmp_path) as listening:
        wait_for(lambda: listening.hear(next(hops)) or any(stream.fault for stream in listening.streams()))
        assert listening.streams()[0].fault.endswith(
            "cannot be made: below min_free_gb; [recording] keeps 9999 GB of the disk free"
        )
        assert brief(listening.streams()[0].fault) == "below min_free_gb"
    assert not list(tmp_path.iterdir())


def test_a_computer_that_is_too_slow_leaves_out_sound_and_not_places(tmp_path, caplog):
    go_on = threading.Event()
    go_on.set()

    def locate(begin, end):
        assert go_on.wait(30)
        return here(begin, end)

    with live(config(tmp_path), tmp_path, locate) as listening:
        feed(listening, blocks(0.0, 1.0))
        wait_for(lambda: length(tmp_path) > 0.9 * RATE)
        go_on.clear()
        for block in blocks(1.0, 3.5):
            listening.hear(block)
        go_on.set()
        wait_for(listening._queue.empty)
        feed(listening, blocks(3.5, 4.0))
        wait_for(lambda: length(tmp_path) > 3.9 * RATE)
    found = heard(tmp_path)
    assert len(found) == 4 * RATE
    assert np.array_equal(found[: RATE * 9 // 10], MIXTURE[0, : RATE * 9 // 10])
    last = RATE * 3 // 10
    assert np.array_equal(found[-last:], MIXTURE[0, -last:])
    assert "too slow for live listening" in caplog.text


def test_a_failure_is_logged_and_the_next_hop_is_heard(tmp_path, caplog):
    def locate(begin, end):
        if begin < 0.5:
            raise ZeroDivisionError
        return here(begin, end)

    with live(config(tmp_path), tmp_path, locate) as listening:
        feed(listening, blocks())
        wait_for(lambda: length(tmp_path) > 3.0 * RATE)
    assert np.array_equal(heard(tmp_path)[-RATE:], MIXTURE[0, -RATE:])
    assert "live listening has failed" in caplog.text


def test_an_ordered_stream_ends_when_its_listener_is_gone_and_a_configured_one_goes_on(tmp_path, caplog, monkeypatch):
    caplog.set_level("INFO")
    monkeypatch.setattr("ross_payload.listening.stage.LISTENER_TIMEOUT_S", 0.3)
    with ear() as configured, ear() as ordered:
        ports = [sock.getsockname()[1] for sock in (configured, ordered)]
    streams = [{"sink": "rtp", "what": "mixture", "options": {"address": "127.0.0.1", "port": ports[0]}}]
    configuration = Config.model_validate({"listening": {"streams": streams}})
    with live(configuration, tmp_path) as listening:
        assert listening.order(StreamOrder(True, address="127.0.0.1", port=ports[1])) == ""
        hops = itertools.chain.from_iterable(map(always, itertools.count()))

        def ended():
            feed(listening, itertools.islice(hops, 10))
            told = listening.streams()
            return len(told) == 2 and told[1].detail.startswith("no listener") and "no receiver" in told[0].fault

        wait_for(ended)
        waits, over = listening.streams()
    assert (waits.on, "no receiver at this port" in waits.fault) == (True, True)
    assert (over.listeners, over.detail) == (0, "no listener for 25 s")
    assert f"stream 1 (target to rtp 127.0.0.1:{ports[1]}) ends: no listener for 25 s" in caplog.text


def always(turn):
    """The mixture once more, behind itself."""
    for block in blocks():
        yield AudioBlock(block.samples, block.index + turn * 4 * RATE, block.time + turn * 4.0)


class Hanging:
    """A sink of others that never comes back."""

    fault, lost = "", 0

    def __init__(self, go_on):
        self._go_on = go_on

    def write(self, block):
        assert self._go_on.wait(60)

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        pass


@pytest.fixture
def hanging(monkeypatch):
    go_on = threading.Event()
    plugin = SimpleNamespace(Config=Table, open=lambda config, services: Hanging(go_on))
    load = plugins.load
    monkeypatch.setattr(plugins, "load", lambda group, name: plugin if name == "hanging" else load(group, name))
    monkeypatch.setattr("ross_payload.listening.sink_runner.LAST_CALL_S", 0.05)
    yield
    go_on.set()


def test_a_sink_that_hangs_holds_up_no_other(tmp_path, hanging):
    with live(config(tmp_path, {"sink": "hanging", "what": "mixture"}), tmp_path) as listening:
        feed(listening, blocks())
        wait_for(lambda: length(tmp_path) > 3.9 * RATE)
        wait_for(lambda: listening.streams()[1].fault)
        assert listening.streams()[1].fault == "the sink hangs: what it does not take is lost"
        assert listening.streams()[1].lost > 0
        assert listening.streams()[0].fault == ""
    assert np.array_equal(heard(tmp_path), MIXTURE[0])


def test_a_stream_is_started_changed_and_stopped_by_order_with_the_next_hop(tmp_path):
    configuration = config(tmp_path)
    with live(configuration, tmp_path) as listening:
        feed(listening, blocks(0.0, 1.0))
        assert listening.order(StreamOrder(False, number=0)) == ""
        listening.hear(next(blocks(1.0)))
        wait_for(lambda: not listening.streams()[0].on)
        assert listening.order(StreamOrder(True, number=0, selection=source(1), gain_db=-3.0)) == ""
        feed(listening, blocks(1.01, 2.0))
        wait_for(lambda: listening.streams()[0].on)
        status = listening.streams()[0]
        assert (status.selection, status.gain_db) == (source(1), -3.0)
        assert listening.order(StreamOrder(True, number=3)) == "there is no stream 3"
    assert (tmp_path / "heard-2.wav").exists()  # every start has a file of its own


def test_a_listener_that_was_never_begun_can_be_closed(tmp_path):
    live(config(tmp_path), tmp_path).close()
    assert not (tmp_path / "heard.wav").exists()
