"""Lead-ins of recorded speech: several people who talk at once are not taken for noise."""

import numpy as np

from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.stft import short_frames
from ross_sim.talkers.speech import load_folder

RATE, LEAD_IN, LATER, DRAWS = 16_000, 2 * 16_000, 3 * 16_000, 120
SNR_DB = 25


def test_a_lead_in_in_which_three_to_five_people_talk_is_rarely_quiet(speech):
    rng, stft = np.random.default_rng(7), short_frames(RATE)
    voices, quiet = load_folder(speech, RATE), 0
    for _ in range(DRAWS):
        mixture = _mixture(voices, rng)
        quiet += quiet_psd(stft.analyse(mixture[:, :LEAD_IN]), stft.analyse(mixture[:, LEAD_IN:])) is not None
    assert quiet <= 0.03 * DRAWS


def _mixture(voices, rng):
    """Three to five talkers, as loud as each other, and microphone noise, (2, n)."""
    talkers = []
    for k in rng.choice(len(voices), rng.integers(3, 6), replace=False):
        speech = voices[k].speech.astype(float)
        first = rng.integers(len(speech) - LEAD_IN - LATER)
        talkers.append(speech[first : first + LEAD_IN + LATER] / np.sqrt(np.mean(speech**2)))
    mixture = np.sum(talkers, axis=0)
    noise = rng.normal(0, np.sqrt(np.mean(mixture**2)) * 10 ** (-SNR_DB / 20), (2, mixture.size))
    return (mixture + noise).astype(np.float32)
