"""What drives a sink: it is opened again when that failed, and nobody else suffers from one that raises or hangs."""

import threading

import numpy as np
import pytest

from clocks import FakeClock
from ross_payload.audio.sinks import SinkInfo
from ross_payload.clock import SystemClock
from ross_payload.errors import AudioError
from ross_payload.interfaces import VoiceBlock
from ross_payload.listening.sink_runner import BLOCKS, RETRY_S, DirectRunner, ThreadedRunner
from waiting import wait_for


def block(index=0):
    return VoiceBlock(np.zeros(100, np.float32), index, 0.0)


class Sink:
    """Takes blocks; can be told to refuse to open, to raise, and to hang."""

    def __init__(self):
        self.blocks, self.entered, self.left = [], 0, 0
        self.refuses = self.raises = None
        self.go_on = threading.Event()
        self.go_on.set()
        self.fault, self.lost = "", 0
        self.info = SinkInfo("there", 7)
        self.clock, self.raised = FakeClock(), None

    def write(self, block):
        assert self.go_on.wait(30)
        if self.raises is not None:
            self.raised = self.clock.now()
            raise self.raises
        self.blocks.append(block)

    def __enter__(self):
        if self.refuses is not None:
            raise self.refuses
        self.entered += 1
        return self

    def __exit__(self, *exception):
        self.left += 1


@pytest.fixture
def sink():
    sink = Sink()
    yield sink
    sink.go_on.set()


def test_it_opens_hands_on_and_closes(sink):
    runner = DirectRunner("stream 0", lambda: sink, FakeClock())
    runner.write(block(0))
    runner.write(block(100))
    assert (runner.fault, runner.lost, runner.info) == ("", 0, SinkInfo("there", 7))
    runner.close()
    runner.close()
    assert [each.index for each in sink.blocks] == [0, 100]
    assert (sink.entered, sink.left) == (1, 1)


@pytest.mark.parametrize("broken", ["fault", "info", "lost"])
def test_a_sink_that_cannot_even_say_how_it_is_ends_nobody_and_is_opened_again(broken):
    class Broken(Sink):
        pass

    def raising(self):
        raise ZeroDivisionError("bug")

    sink = Broken()
    for name in ("fault", "info", "lost"):
        vars(sink).pop(name)
        setattr(Broken, name, {"fault": "", "info": SinkInfo(), "lost": 0}[name])
    setattr(Broken, broken, property(raising))
    clock = FakeClock()
    runner = DirectRunner("stream 0", lambda: sink, clock)
    runner.write(block(0))
    runner.close()
    assert runner.lost in (0, 100)
    if broken != "lost":
        assert "bug" in runner.fault
        assert sink.left == 1


def test_a_sink_that_cannot_be_opened_is_tried_again_and_the_log_says_so_once(sink, caplog):
    clock = FakeClock()
    sink.refuses = AudioError("tcp:127.0.0.1:5: cannot listen: Address already in use")
    runner = DirectRunner("stream 0", lambda: sink, clock)
    for _ in range(10):
        runner.write(block())
        clock.sleep(RETRY_S / 4)
    assert runner.fault == "tcp:127.0.0.1:5: cannot listen: Address already in use"
    assert runner.lost == 1000
    assert [each.getMessage() for each in caplog.records] == [f"stream 0: {runner.fault}"]
    sink.refuses = None
    clock.sleep(RETRY_S)
    runner.write(block())
    assert (runner.fault, runner.lost, len(sink.blocks)) == ("", 1000, 1)


@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("info", SinkInfo().__repr__, "the sink's info: expected SinkInfo, got method"),
        ("info", SinkInfo(codec=None), "the sink's info.codec: expected str, got NoneType"),
        ("info", SinkInfo(rate=48_000.0), "the sink's info.rate: expected int, got float"),
        ("info", SinkInfo(unheard_s=None), "the sink's info.unheard_s: expected float, got NoneType"),
        ("info", SinkInfo(packets_lost="3"), "the sink's info.packets_lost: expected int | None, got str"),
        ("info", SinkInfo(port=65_536), "the sink's info.port: expected 0 to 65535, got 65536"),
        ("info", SinkInfo(rate=2**32), "the sink's info.rate: expected 0 to 4294967295, got 4294967296"),
        ("info", SinkInfo(listeners=-1), "the sink's info.listeners: expected 0 or more, got -1"),
        ("info", SinkInfo(port=65_535, rate=2**32 - 1, listeners=1000), ""),
        ("info", SinkInfo(rate=np.int32(48_000), unheard_s=1, packets_lost=3), ""),
        ("fault", None, "the sink's fault: expected str, got NoneType"),
        ("lost", "many", ""),
    ],
)
def test_a_sink_that_tells_something_else_of_itself_is_a_fault_of_its_own_and_asks_nothing_of_others(
    sink, name, value, fault
):
    setattr(sink, name, value)
    runner = DirectRunner("stream 0", lambda: sink, FakeClock())
    runner.write(block())
    runner.close()
    assert runner.fault == fault
    assert isinstance(runner.info, SinkInfo)
    assert isinstance(runner.lost, int)


@pytest.mark.parametrize("error", [ZeroDivisionError("two\nlines"), SystemExit("two\nlines")])
def test_a_sink_that_raises_is_closed_and_opened_again(sink, error):
    clock = FakeClock()
    runner = DirectRunner("stream 0", lambda: sink, clock)
    sink.raises = error
    runner.write(block())
    assert runner.fault == f"the sink raised {type(error).__name__}: two lines"
    assert (runner.lost, sink.left) == (100, 1)
    sink.raises = None
    clock.sleep(RETRY_S)
    runner.write(block())
    assert (runner.fault, sink.entered) == ("", 2)


def test_a_sink_is_tried_again_after_a_pause_and_not_with_every_block(sink):
    clock = FakeClock()
    attempts, sink.clock = [], clock

    def make():
        attempts.append(clock.now())
        return sink

    sink.refuses = AudioError("there is no such device")
    runner = DirectRunner("stream 0", make, clock)
    for _ in range(100):
        runner.write(block())
        clock.sleep(RETRY_S / 20)
    assert np.diff(attempts) == pytest.approx(RETRY_S, rel=0.06)
    sink.refuses, attempts[:] = None, []
    for number in range(100):
        runner.write(block())
        sink.raises = ValueError("no") if number == 55 else None  # when it has been open for long
        clock.sleep(RETRY_S / 20)
    _, again = attempts
    assert again - sink.raised == pytest.approx(RETRY_S, rel=0.06)


def test_what_a_sink_lost_before_it_was_opened_again_stays_counted(sink):
    clock, sinks = FakeClock(), [sink, Sink()]
    runner = DirectRunner("stream 0", lambda: sinks.pop(0), clock)
    runner.write(block())
    sink.lost, sink.raises = 30, ValueError("no")
    runner.write(block())
    clock.sleep(RETRY_S)
    runner.write(block())
    assert (runner.fault, runner.lost) == ("", 130)


def test_what_a_sink_itself_says_is_wrong_is_told(sink):
    runner = DirectRunner("stream 0", lambda: sink, FakeClock())
    runner.write(block())
    sink.fault, sink.lost = "the headphones are gone", 30
    runner.write(block())
    assert (runner.fault, runner.lost) == ("the headphones are gone", 30)


def test_a_sink_that_hangs_holds_up_nobody_and_what_it_does_not_take_is_counted(sink):
    sink.go_on.clear()
    runner = ThreadedRunner("stream 0", lambda: sink, SystemClock())
    for number in range(BLOCKS + 20):
        runner.write(block(100 * number))
    wait_for(lambda: sink.entered)
    assert runner.fault == "the sink hangs: what it does not take is lost"
    assert 19 * 100 <= runner.lost <= 20 * 100  # one may be on its way
    sink.go_on.set()
    runner.close()
    runner.wait()
    assert sink.left == 1
    assert len(sink.blocks) + runner.lost // 100 == BLOCKS + 20


def test_how_long_a_sink_has_hung_and_what_that_cost_is_logged_when_it_takes_blocks_again(sink, caplog):
    sink.go_on.clear()
    clock = FakeClock()
    runner = ThreadedRunner("stream 0", lambda: sink, clock)
    for index in range(BLOCKS + 50):
        runner.write(block(100 * index))
    clock.sleep(27.0)
    sink.go_on.set()
    wait_for(lambda: len(sink.blocks) >= BLOCKS)
    runner.write(block(100 * (BLOCKS + 50)))
    runner.close()
    runner.wait()
    assert f"stream 0: works again after 27.0 s; {runner.lost} samples are missing" in caplog.text


def test_a_sink_that_hangs_for_ever_is_left_behind(sink, monkeypatch, caplog):
    monkeypatch.setattr("ross_payload.listening.sink_runner.LAST_CALL_S", 0.01)
    sink.go_on.clear()
    runner = ThreadedRunner("stream 0", lambda: sink, SystemClock())
    runner.write(block())
    runner.close()
    runner.wait()
    assert "stream 0: the sink hangs and is left behind" in caplog.text


def test_a_sink_is_opened_before_anything_is_written_to_it(sink):
    runner = ThreadedRunner("stream 0", lambda: sink, SystemClock())
    wait_for(lambda: sink.entered)
    runner.close()
    runner.wait()
    assert (sink.blocks, sink.left) == ([], 1)
