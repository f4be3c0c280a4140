"""Segments of a pulse train, and single pulses."""

from __future__ import annotations

import numpy as np

from ross_payload.actuators.tb6600.pulses import EDGE, Line, Segment


def segment(start: float, duration: float, *edges: tuple[float, Line, bool]) -> Segment:
    return Segment(start, duration, np.array(list(edges), dtype=EDGE))


def pulse(time: float) -> tuple[tuple[float, Line, bool], ...]:
    return (time, Line.STEP, True), (time + 10e-6, Line.STEP, False)
