"""The ring: what is written is taken in order, and what has no room is counted."""

import sys
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_payload.audio.ring import Ring


def frames(begin, size):
    return np.stack([np.arange(begin, begin + size), -np.arange(begin, begin + size), np.zeros(size)], 1).astype("f4")


@given(st.integers(1, 400), st.lists(st.tuples(st.booleans(), st.integers(0, 60)), max_size=60))
def test_pieces_come_out_in_order_with_their_place_and_time_and_nothing_else(capacity, steps):
    ring, offered, kept = Ring(capacity), 0, []
    for writes, size in steps:
        if writes:
            before = ring.waiting
            ring.write(frames(offered, size), (0, 1), arrived=float(offered))
            kept += [(offered, size)] if ring.waiting > before else []
            offered += size
        elif kept:
            place, length = kept.pop(0)
            piece = ring.read()
            assert (piece.offered, piece.arrived) == (place, float(place))
            assert np.array_equal(piece.samples, frames(place, length)[:, :2].T)
        else:
            assert ring.read() is None
        assert ring.offered == offered
        assert ring.waiting == sum(length for _, length in kept) <= capacity


def test_a_piece_is_kept_when_it_fits_and_refused_whole_when_not():
    ring = Ring(200)
    for begin in (0, 150, 150):
        ring.write(frames(begin, 150), (0, 1), 0.0)
    assert ring.waiting == 150
    ring.read()
    ring.write(frames(450, 150), (0, 1), 0.0)
    assert ring.read().offered == 450


@pytest.fixture
def restless():
    """Threads take turns 100 times as often as they do otherwise."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(before / 100)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("restless")
def test_a_writer_and_a_reader_in_two_threads_agree():
    ring, total = Ring(1000), 50_000

    def write():
        begin = 0
        while begin < total:
            if ring.capacity - ring.waiting >= 100:
                ring.write(frames(begin, 100), (0, 1), 0.0)
                begin += 100

    writer = threading.Thread(target=write)
    writer.start()
    expected = 0
    while expected < total:
        piece = ring.read()
        if piece is not None:
            assert np.array_equal(piece.samples[0], np.arange(expected, expected + 100, dtype=np.float32))
            expected += 100
    writer.join()
    assert ring.offered == total
