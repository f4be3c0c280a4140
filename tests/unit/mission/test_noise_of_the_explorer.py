"""What the explorer is told of the noise: more where it has a direction; the separators are told what was measured."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from mission_bench import RATE, SETTINGS, Likes, OneGroupEach, Rig, ThreeTalkers
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.mission.context import Context, Listening, hop
from ross_payload.mission.identify_target import separate
from ross_payload.mission.orientation_scan import observe
from ross_payload.mission.settings import Tools

STFT = Stft(RATE, 512, 128)


@dataclass
class Told(ThreeTalkers):
    """An explorer that remembers the noise PSDs that it is told."""

    psds: list = field(default_factory=list)

    def observe(self, spectrogram, frequencies, heading, noise_psd, *, frame_period=None):
        self.psds.append(noise_psd)
        return super().observe(spectrogram, frequencies, heading, noise_psd, frame_period=frame_period)


@dataclass
class ToldApart(OneGroupEach):
    """A separator that remembers them, too."""

    psds: list = field(default_factory=list)

    def batch(self, spectrogram, scene):
        self.psds.append(scene.noise_psd)
        return super().batch(spectrogram, scene)


def told(noise):
    """Noise PSDs that the explorer is told at two headings, and the separator, after a lead-in of noise."""
    explorer, separator = Told(), ToldApart()
    context = Context(SETTINGS, Tools(explorer, STFT, separator, STFT, Likes(1)))
    speech = 30 * np.random.default_rng(2).standard_normal((2, RATE)).astype(np.float32)

    def brain():
        yield from hop(context)
        context.lead_in = noise.astype(np.float32)
        for heading in (0.0, 0.5):
            observe(context, Listening(heading, speech))
        separate(context, Estimate((SourceEstimate(0.0, 0.01, 0.9, resolved=True),)), Listening(0.5, speech))

    Rig(brain()).run()
    return explorer.psds, *separator.psds


@pytest.mark.parametrize(("sensors", "raised"), [(0.05, True), (1e3, False)])
def test_the_explorer_is_told_more_of_noise_with_a_direction(sensors, raised):
    rng = np.random.default_rng(1)
    fan = rng.standard_normal(2 * RATE)
    noise = 0.001 * (np.stack([np.roll(fan, 1), fan]) + sensors * rng.standard_normal((2, 2 * RATE)))
    (first, second), measured = told(noise)
    np.testing.assert_array_equal(first, second)
    assert ((first / measured).min() > 1.4) == raised
    assert raised or (first == measured).all()


def test_after_a_lead_in_in_which_somebody_talked_the_explorer_is_told_nothing():
    loud = 30 * np.random.default_rng(3).standard_normal((2, 2 * RATE))
    (first, second), measured = told(loud)
    assert first is second is measured is None
