"""A voice that is found again in what was played: noise from 200 to 600 Hz, twenty seconds that come over and over.

A card with another crystal than the payload's is followed by a sample more or less in a block: a narrow band stands
that for the tenth of a second in which it is looked for.
"""

import numpy as np
from scipy.signal import butter, correlate, sosfilt

RATE = 16000
SECONDS = 20
PART = RATE // 10  # samples that are looked for together
SAME = 0.8  # normalized correlation of what is found


def voice():
    """Samples (n,); the end goes over into the beginning with a step that nobody minds."""
    noise = np.random.default_rng(0).standard_normal(SECONDS * RATE)
    band = sosfilt(butter(4, [200, 600], "band", fs=RATE, output="sos"), noise)
    return (0.15 * band / band.std()).astype(np.float32)


def found(part, near, reach=4.0):
    """Return where a part (PART,) of what was played is in the endless voice [s], and its normalized correlation.

    It is looked for within ``reach`` [s] before ``near`` [s].
    """
    begin = max(round((near - reach) * RATE), 0)
    places = np.arange(begin, max(round(near * RATE), begin) + len(part))
    searched = voice()[places % (SECONDS * RATE)]
    products = correlate(searched, part, "valid")
    powers = np.convolve(searched**2, np.ones(len(part)), "valid")
    matches = products / np.sqrt(powers * (part**2).sum() + 1e-12)
    best = int(np.argmax(matches))
    return (begin + best) / RATE, float(matches[best])


def delays(played, until):
    """Return the delays [s] of the last second of what was ``played``, part by part.

    It is empty unless all of that is the voice. ``until`` is when its last sample was heard, since the first sample of
    the voice was [s].
    """
    if len(played) < RATE:
        return []
    told = []
    for first in range(len(played) - RATE, len(played) - PART + 1, PART):
        heard = until - (len(played) - first) / RATE
        at, match = found(played[first : first + PART], heard)
        if match < SAME:
            return []
        told.append(heard - at)
    return told
