"""What the microphones of a simulated world hear beside the talkers."""

import numpy as np

from ross_sim.clock import SimClock
from ross_sim.sitl.world import World
from ross_sim.talkers.speech import TalkerVoice

RATE, SPACING, SPEED_OF_SOUND = 16000, 0.05, 343.0


class Fixed:
    """An array that stands at one heading."""

    port, faults = None, frozenset()

    def __init__(self, angle=0.0):
        self._angle = angle

    def advance(self, now):
        pass

    def angle(self):
        return self._angle

    def complaints(self):
        return []


def heard(scene, cache, *, seed=1, angle=0.0, seconds=3.0):
    generator = np.random.default_rng(7)
    clips = [generator.standard_normal(4 * RATE).astype(np.float32) for _ in scene.talkers]
    voices = [TalkerVoice(f"voice-{index}", clip, clip, RATE) for index, clip in enumerate(clips)]
    world = World(scene, voices, Fixed(angle), SimClock(), seed, cache=cache)
    with world.source as source:
        for _ in range(round(seconds * 100)):
            source.read(RATE // 100)
    return world


def power_db(samples):
    return 10 * np.log10(np.mean(samples.astype(float) ** 2))


def arrives_earlier_at_microphone_2(samples):
    """TDOA [s] from the phase slope of the averaged cross-spectrum below 3 kHz."""
    frames = samples[:, : samples.shape[1] // 512 * 512].reshape(2, -1, 512) * np.hanning(512)
    first, second = np.fft.rfft(frames)
    cross = (second * first.conj()).mean(axis=0)[2:96]
    omega = 2 * np.pi * np.fft.rfftfreq(512, 1 / RATE)[2:96]
    weight = np.abs(cross)
    return float((weight * omega * np.angle(cross)).sum() / (weight * omega**2).sum())
