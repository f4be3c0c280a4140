"""A delay between the converters, while several people talk: it is the same at all headings, and nobody moves with it.

A few sources at rest are taken out of what was heard, one after the other, each with its sinusoid of delays plus the
common one (matching pursuit; Mallat, Zhang 1993). The common delay that leaves the least is the one that is there.
"""

from __future__ import annotations

import numpy as np

from ross_payload.calibration.turn_fit import AZIMUTHS, BANDS, Steered, Turn
from ross_payload.interfaces import Complex, Real

SOURCES = 3  # that are taken out
COSINES = np.array([1.0, 0.8, 0.6, 0.4, 0.2])  # of the elevations that they may have
STEP = 2.5e-5  # of the delays that are tried [s]
FIRST = 2  # steps to both sides of none
LAST = 8  # steps
RIDGE = 1e-6  # of the weight: two sources at one place share it
TINY = 1e-12


def common_delay(turn: Turn, steered: Steered, amplitude: float) -> tuple[float, float, float]:
    """The delay of microphone 2 before 1, whatever the heading, that leaves the least of what was heard unexplained.

    Parameters
    ----------
    turn
        What was heard.
    steered
        All of it.
    amplitude
        d / v_p [s].

    Returns
    -------
    tuple
        The delay [s], a multiple of `STEP`; what it leaves unexplained, a share of the weight; what none leaves.
    """
    left = {steps: _left(turn, steered, amplitude, steps * STEP) for steps in (0, -FIRST, FIRST)}
    best = min(left, key=left.__getitem__)
    while best and abs(best) < LAST:
        near = {best - 1, best + 1} - left.keys()
        left |= {steps: _left(turn, steered, amplitude, steps * STEP) for steps in near}
        before, best = best, min(left, key=left.__getitem__)
        if best == before:
            break
    return best * STEP, left[best], left[0]


def _left(turn: Turn, first: Steered, amplitude: float, delay: float) -> float:
    """Share of the weight that `SOURCES` at rest leave unexplained with a common delay [s]."""
    around = np.cos(AZIMUTHS - turn.headings[:, None])
    delays = (amplitude * COSINES[:, None] * around[:, None]).reshape(len(around), -1) + delay
    steered, waves, left = first, list[Complex](), turn.phase
    for number in range(SOURCES):
        steered = Steered(turn, left) if number else first
        chosen = delays[:, steered.share(delays).argmax()]
        waves.append(np.exp(2j * np.pi * np.outer(chosen, turn.frequencies)))
        left = _without(turn, waves)
    untold = 1 - np.abs(turn.phase) ** 2  # of neighbours that disagree no source explains more than their mean
    return float((turn.weight * (np.abs(left) ** 2 + untold)).sum() / (turn.weight.sum() + TINY))


def _without(turn: Turn, waves: list[Complex]) -> Complex:
    """What sources with these phases leave, (n_headings, n_freqs); each has the share that explains most by band."""
    left, n = turn.phase.copy(), len(turn.frequencies)
    for band in np.array_split(np.arange(n), BANDS):
        part = slice(band[0], band[-1] + 1)
        weight, heard = turn.weight[:, part], turn.phase[:, part]
        shown = np.stack([wave[:, part] for wave in waves])
        weighted = weight * shown.conj()
        among = np.einsum("ihf,jhf->ij", weighted, shown).real + RIDGE * (weight.sum() + TINY) * np.eye(len(waves))
        shares: Real = np.clip(np.linalg.solve(among, (weighted * heard).real.sum(axis=(1, 2))), 0, 1)
        left[:, part] -= np.tensordot(shares, shown, 1)
    return left
