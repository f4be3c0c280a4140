"""Segments of a pulse train, and single pulses."""

from __future__ import annotations

import numpy as np

from ross_payload.actuators.tb6600.pulse_segments import EDGE, PulseLine, Segment


def segment(start: float, duration: float, *edges: tuple[float, PulseLine, bool]) -> Segment:
    return Segment(start, duration, np.array(list(edges), dtype=EDGE))


def pulse(time: float) -> tuple[tuple[float, PulseLine, bool], ...]:
    return (time, PulseLine.STEP, True), (time + 10e-6, PulseLine.STEP, False)
