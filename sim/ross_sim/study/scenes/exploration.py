"""Making explorations: what the array hears at every heading, what an explorer makes of it, and how near that is.

K talkers of equal power at microphone 1 speak from random places of their recordings around the array in the middle of
a room (`rooms`); white noise is 15 dB below the mixture. `ross study` makes tables of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.signal import oaconvolve

from ross_payload.angles import difference
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate
from ross_payload.interfaces import Explorer, Observation, Real, Samples
from ross_sim.study.scenes.mixtures import RATE, SNR_DB, expect_sound, spread
from ross_sim.study.scenes.room_settings import Setting

FRAME = 1024
UNIT, STEP = 3.0, np.deg2rad(15.0)  # [s], [rad]
BEFORE = 1.0  # of speech before every orientation, so that its reverberation is there [s]
NEAR_DEG = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Explored:
    """One random layout and what an explorer observes of it."""

    azimuths: Real  # [rad], (k,)
    voices: tuple[Samples, ...]
    observations: tuple[Observation, ...]  # one per heading


def render(
    voices: Sequence[Samples],
    azimuths: Real,
    setting: Setting,
    headings: Real,
    rng: np.random.Generator,
    *,
    seconds: float = UNIT,
    rate: int = RATE,
) -> Real:
    """What both microphones hear for some seconds at every heading, (n_headings, 2, n_samples).

    Raises
    ------
    ConfigError
        When a talker is silent all the time.
    """
    unit, before = round(seconds * rate), round(BEFORE * rate)
    places = setting.places(azimuths, np.random.default_rng(np.abs(azimuths * 1e6).astype(int)))
    responses = setting.responses(places, headings.tolist(), rate)
    received = np.zeros((len(headings), 2, unit))
    n = unit * len(headings) + before
    spoken = [np.resize(np.roll(voice, -int(rng.integers(len(voice)))), n) for voice in voices]
    expect_sound(spoken, rate)
    for source, speech in enumerate(spoken):
        pieces = np.stack([speech[r * unit : (r + 1) * unit + before] for r in range(len(headings))])
        image = oaconvolve(pieces[:, None], responses[:, :, source], axes=-1)[..., before : before + unit]
        received += image / np.sqrt(np.mean(image[:, 0] ** 2))
    noise = np.sqrt(np.mean(received[:, 0] ** 2)) * 10 ** (-SNR_DB / 20)
    mixture = received + noise * rng.standard_normal(received.shape)
    return np.asarray(0.05 / np.sqrt(np.mean(mixture**2)) * mixture)


def observed(explorer: Explorer, stft: Stft, received: Real, headings: Real) -> Iterator[Observation]:
    """What an explorer, whom nobody tells the noise, observes of (n_headings, 2, n_samples)."""
    for samples, heading in zip(received.astype(np.float32), headings, strict=True):
        spectrogram = stft.analyse(samples)
        yield explorer.observe(spectrogram, stft.frequencies, float(heading), None, frame_period=stft.period)


def explore(
    explorer: Explorer, setting: Setting, voices: Sequence[Samples], k: int, *, key: Sequence[int], rotations: int
) -> Explored:
    """Let an explorer hear ``k`` random talkers; ``key`` seeds the layout, which is the same in every room."""
    rng = np.random.default_rng(key)
    azimuths = spread(k, rng)
    chosen = tuple(voices[i] for i in rng.permutation(len(voices))[:k])
    headings = STEP * np.arange(rotations + 1)
    received = render(chosen, azimuths, setting, headings, rng)
    return Explored(azimuths, chosen, tuple(observed(explorer, Stft(RATE, FRAME, FRAME // 4), received, headings)))


def matched(azimuths: Real, estimate: Estimate) -> tuple[Real, Real]:
    """Error [deg] and sigma [deg] of every talker's own estimate, (k,); 180 and infinite for a talker without one."""
    errors, sigmas = np.full(len(azimuths), 180.0), np.full(len(azimuths), np.inf)
    apart = np.rad2deg(np.abs(difference(azimuths[:, None], estimate.azimuths)))
    talkers, sources = linear_sum_assignment(np.minimum(apart, 60.0))
    errors[talkers] = apart[talkers, sources]
    sigmas[talkers] = [np.rad2deg(estimate.sources[source].sigma) for source in sources]
    return errors, sigmas
