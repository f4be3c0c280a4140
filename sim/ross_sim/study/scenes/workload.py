"""What the bench works on, and how it is timed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Complex, Real, Scene
from ross_sim.study.scenes.mixtures import aligned_heading, images_of, layouts
from ross_sim.study.scenes.room_settings import SETTINGS, SPACING, SPEED_OF_SOUND
from ross_sim.talkers.speech import resampled

VOICE_RATE = 48000  # the voices are loaded at [Hz]; every lower rate divides its resampling
FRAME = 0.1  # rounded to a power of two in samples [s]
LEAD_IN = 2.0  # of noise alone [s]
SNR_DB = 15.0  # mixture over noise, at microphone 1


@dataclass(frozen=True, slots=True)
class Case:
    """One mixture of the bench."""

    n_sources: int = 3
    setting: str = "S1"
    rate: int = 24000  # [Hz]
    seconds: float = 10.0
    target: int = 0
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """A mixture, its spectrogram, what a separator is told, and the truth."""

    mixture: Real  # (2, n)
    reference: Real  # the target alone at microphone 1, (n,)
    stft: Stft
    spectrogram: Complex  # (2, n_freqs, n_frames)
    scene: Scene
    simulation: float  # CPU time of responses and rendering [s]

    def gain(self, outputs: Complex) -> float:
        """SI-SDRi [dB] of the output that is nearest to the target."""
        voices = self.stft.synthesise(outputs, self.reference.size)
        return max(si_sdri(voice, self.mixture[0], self.reference) for voice in voices if np.ptp(voice) > 0)


@dataclass(frozen=True, slots=True)
class Peer:
    """One method of another library."""

    library: str
    method: str
    iterations: int
    call: Callable[[Complex, int, int], Complex]  # spectrogram, iterations, outputs


def prepared(case: Case, voices: Sequence[Real]) -> Work:
    """Simulate a case with voices (n,) at 48 kHz; the array is at the target's alignment, the noise PSD known.

    The paper's layout up to five talkers; a short voice is repeated.
    """
    rng = np.random.default_rng([case.seed, case.n_sources, case.target])
    azimuths = layouts(case.n_sources, 0, rng)[0] if case.n_sources <= 5 else layouts(case.n_sources, 1, rng)[1]
    heading, n = aligned_heading(azimuths, case.target), round(case.seconds * case.rate)
    speech = [np.resize(resampled(voice, VOICE_RATE, case.rate), n) for voice in voices[: case.n_sources]]
    before = time.process_time()
    setting = SETTINGS[case.setting]
    places = setting.places(azimuths, np.random.default_rng(case.seed))
    images = images_of(speech, places, heading, setting, case.rate)
    simulation = time.process_time() - before
    clean = images.sum(axis=0)
    sigma = math.sqrt(float((clean[0] ** 2).mean()) * 10 ** (-SNR_DB / 10))
    mixture = (clean + sigma * rng.standard_normal(clean.shape)).astype(np.float32)
    lead_in = sigma * rng.standard_normal((2, round(LEAD_IN * case.rate)))
    frame = 2 ** round(math.log2(FRAME * case.rate))
    stft = Stft(case.rate, frame, frame // 4)
    spectrogram = stft.analyse(mixture)
    tau = tdoa(azimuths, heading, SPACING, SPEED_OF_SOUND)
    psd = quiet_psd(stft.analyse(lead_in), spectrogram)
    scene = Scene(stft.frequencies, SPACING, SPEED_OF_SOUND, case.n_sources, tau, psd)
    return Work(mixture, np.asarray(images[case.target, 0]), stft, spectrogram, scene, simulation)


def cpu_seconds(call: Callable[[], object], repeats: int, clock: Callable[[], float] = time.process_time) -> float:
    """Median CPU time [s] of a call.

    >>> ticks = iter([0.0, 1.0, 5.0, 8.0, 9.0, 11.0])
    >>> cpu_seconds(lambda: None, 3, lambda: next(ticks))
    2.0
    """
    times = []
    for _ in range(repeats):
        before = clock()
        call()
        times.append(clock() - before)
    return median(times)
