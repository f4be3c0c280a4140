"""One source for the mission and for live listening: who computes holds up nobody, and misses nothing silently."""

import threading

import numpy as np
import pytest

from ross_payload.audio.live_source import SourceStatus
from ross_payload.audio.shared_source import SharedSource
from ross_payload.errors import AudioEnded, AudioError
from ross_payload.interfaces import AudioBlock, AudioFlag
from waiting import wait_for

RATE, HOP = 16000, 160


class Counting:
    """Gives hops that count as fast as they are asked for, as many as it may; then it waits or ends."""

    rate = RATE

    def __init__(self, hops, ends=True):
        self._hops, self._ends = hops, ends
        self._over = threading.Event()
        self.given = 0
        self.open = False

    def read(self, n):
        if self.given == self._hops:
            if self._ends:
                raise AudioEnded("the end")
            assert self._over.wait(20)
            raise AudioError("not open")
        index, self.given = self.given * n, self.given + 1
        return AudioBlock(np.full((2, n), self.given, np.float32), index, index / RATE)

    def status(self):
        return SourceStatus(waiting=0.25, lost=3)

    def __enter__(self):
        self.open = True
        return self

    def __exit__(self, *exception):
        self.open = False

    def let_go(self):
        self._over.set()


def test_listeners_get_every_block_while_nobody_reads():
    source, heard = Counting(50), []
    shared = SharedSource(source, HOP, 10.0)
    shared.listeners.append(heard.append)
    with shared:
        wait_for(lambda: len(heard) == 50)
        blocks = [shared.read(HOP) for _ in range(50)]
        with pytest.raises(AudioEnded, match="the end"):
            shared.read(HOP)
    assert all(one is other for one, other in zip(blocks, heard, strict=True))
    assert not source.open


def test_what_has_no_room_is_silence_that_is_flagged_and_counted():
    source = Counting(30)
    shared = SharedSource(source, HOP, 20 * HOP / RATE, source)
    with shared:
        wait_for(lambda: source.given == 30)
        wait_for(lambda: shared.status().waiting == pytest.approx(0.25 + 31 * HOP / RATE))  # and the end
        assert shared.status().lost == 3 + 10 * HOP
        blocks = [shared.read(HOP) for _ in range(30)]
    assert [block.index for block in blocks] == list(range(0, 30 * HOP, HOP))
    assert [bool(block.flags & AudioFlag.MISSING) for block in blocks] == [False] * 20 + [True] * 10
    assert not blocks[-1].samples.any()


def test_it_is_read_in_hops_and_only_while_open():
    source = Counting(3)
    shared = SharedSource(source, HOP, 1.0)
    with pytest.raises(AudioError, match="not open"):
        shared.read(HOP)
    with shared, pytest.raises(AudioError, match="expected to be read in hops of 160 samples, got 7"):
        shared.read(7)
    with pytest.raises(AudioError, match="not open"):
        shared.read(HOP)


def test_a_source_that_cannot_be_opened_says_so():
    class Broken(Counting):
        def __enter__(self):
            raise AudioError("no such file")

    with pytest.raises(AudioError, match="no such file"), SharedSource(Broken(1), HOP, 1.0):
        pass


def test_leaving_does_not_wait_for_ever(monkeypatch):
    monkeypatch.setattr("ross_payload.audio.shared_source.LAST_CALL_S", 0.01)
    source = Counting(1, ends=False)
    with SharedSource(source, HOP, 1.0) as shared:
        assert shared.read(HOP).index == 0
    assert not source.open
    source.let_go()
