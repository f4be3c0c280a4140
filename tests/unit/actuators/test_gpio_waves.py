"""Edges become waves of a GPIO library: nothing is rounded away, and streams fit together."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pulse_trains import pulse, segment
from ross_payload.actuators.tb6600.pulse_segments import PulseLine
from ross_payload.actuators.wires.gpio import wave


def test_a_wave_waits_until_the_first_edge_and_after_the_last() -> None:
    pulses, end = wave(segment(5.0, 0.01, *pulse(0.002)), origin=5.0, written=0)
    assert pulses == [(0, 0, 2000), (1, 1, 10), (0, 1, 7990)]
    assert end == 10_000


def test_edges_of_one_microsecond_become_one_pulse_that_touches_only_their_lines() -> None:
    together = segment(0.0, 1e-3, (0.0, PulseLine.DIRECTION, True), (0.0, PulseLine.ENABLE, False))
    assert wave(together, 0.0, 0)[0] == [(0b010, 0b110, 1000)]


def test_a_segment_without_edges_is_a_rest() -> None:
    assert wave(segment(1.5, 0.25), origin=1.0, written=500_000) == ([(0, 0, 250_000)], 750_000)


times = st.lists(st.floats(5e-6, 0.01), min_size=1, max_size=30).map(np.cumsum)


@given(times, st.floats(0, 1e5), st.integers(1, 20))
def test_rounding_never_adds_up_and_waves_of_a_stream_fit_together(ends: np.ndarray, origin: float, n: int) -> None:
    """Each edge is within a microsecond of its time, whatever stretches the stream is cut into."""
    written, total, found = 0, 0, []
    for begin, end in zip(np.concatenate([[0.0], ends]), ends, strict=False):
        edges = np.linspace(0, end - begin, n, endpoint=False)
        lines = [(time, PulseLine.STEP, index % 2 == 0) for index, time in enumerate(edges)]
        pulses, written = wave(segment(origin + begin, end - begin, *lines), origin, written)
        for _, mask, delay in pulses:
            found += [total] * bool(mask)
            assert delay >= 0
            total += delay
    assert total == written
    assert written == pytest.approx(ends[-1] * 1e6, abs=0.6)
    assert len(found) <= n * len(ends)


@given(st.floats(0, 1e6), st.floats(0, 1), st.integers(1, 1000))
def test_edges_whole_microseconds_and_a_trifle_apart_stay_so_far_apart(start: float, first: float, gap: int) -> None:
    edges = segment(start, 2.0, (first, PulseLine.STEP, True), (first + gap * 1e-6 + 1e-8, PulseLine.STEP, False))
    pulses, _ = wave(edges, start, 0)
    assert next(delay for bits, mask, delay in pulses if bits & mask) >= gap
