"""Four rotors around an array, and talk from afar: what two microphones hear, heading by heading."""

from functools import cache

import numpy as np

from ross_payload.dsp.rotors import Rotors
from ross_payload.dsp.stft import Stft
from ross_payload.localization.joint_in_noise import JointInNoise
from ross_sim.acoustics.near_field import NearField
from ross_sim.acoustics.rotor_noise import rotor

RATE, SPACING, SPEED_OF_SOUND = 16000, 0.05, 343.0
PLACES = tuple((x, y, 0.15) for x in (0.25, -0.25) for y in (0.25, -0.25))
ROTORS = Rotors(PLACES, SPACING, SPEED_OF_SOUND)
STFT = Stft(RATE, 512, 128)


def heard(sounds, places, heading):
    """Sounds (n, n_samples) from places near or far, at both microphones, (2, n_samples)."""
    responses = NearField(tuple(places), SPACING, RATE, SPEED_OF_SOUND, delayed=False).at(heading)
    rows = [
        sum(np.convolve(sound, taps)[: len(sound)] for sound, taps in zip(sounds, row, strict=True))
        for row in responses
    ]
    return np.array(rows)


@cache
def rotor_noise(seconds, heading, seed=1):
    """Four rotors, unit power at microphone 1, (2, n)."""
    rng = np.random.default_rng(seed)
    sounds = [rotor(RATE, 5400.0, 2, rng, seconds).sound for _ in PLACES]
    noise = heard(sounds, PLACES, heading)
    noise /= np.sqrt((noise[0] ** 2).mean())
    noise.flags.writeable = False  # several tests share it
    return noise


def talk(seconds, azimuth, heading, seed=2):
    """A talker at 2.5 m: noise with the spectrum of speech in syllables with pauses, unit power, (2, n)."""
    rng = np.random.default_rng([seed, int(1000 * (azimuth + 4))])
    n = round(seconds * RATE)
    frequencies = np.fft.rfftfreq(n, 1 / RATE)
    strength = np.minimum(frequencies / 120, 1) / (1 + (frequencies / 700) ** 2)
    steady = np.fft.irfft(strength * np.fft.rfft(rng.standard_normal(n)), n)
    syllables = np.repeat(rng.exponential(size=n // 2000 + 1) * (rng.random(n // 2000 + 1) < 0.5), 2000)[:n]
    said = steady * np.convolve(syllables, np.hanning(1000) / 500, mode="same")
    image = heard([said], [(2.5 * np.cos(azimuth), 2.5 * np.sin(azimuth), 0.0)], heading)
    return image / np.sqrt((image[0] ** 2).mean())


def observations(azimuths, seconds=2):
    """What the explorer observes at six headings among rotors, talkers at some azimuths."""
    within = JointInNoise(SPACING, SPEED_OF_SOUND)
    known = within.learn(
        STFT.analyse(rotor_noise(2, 0.0).astype(np.float32)), STFT.frequencies, STFT.period, 0.0, ROTORS
    )
    seen = []
    for index, heading in enumerate(0.5 * np.arange(6)):
        heard = rotor_noise(seconds, heading, seed=index)
        for azimuth in azimuths:
            heard = heard + talk(seconds, azimuth, heading, seed=index)
        seen.append(
            within.observe(
                STFT.analyse(heard.astype(np.float32)), STFT.frequencies, heading, heading, known, period=STFT.period
            )
        )
    return seen
