"""How clean a group is believed to be: closed forms of the posterior, and voices whose truth is known."""

import numpy as np
import pytest

from ross_payload.alignment.predicted_gain import best_headings
from ross_payload.dsp.metrics import OFFSET, SLOPE, qualities, si_sdr, si_sdri
from ross_payload.dsp.stft import Stft
from ross_payload.separation.refined import separator
from ross_sim.study.scenes.mixtures import FRAME, HOP, RATE, record, scene_of
from ross_sim.study.scenes.room_settings import SETTINGS
from ross_sim.talkers.synthetic_voices import synthetic_voice

WHITE = [1.0, 1.0, 0.0, 0.0]  # the covariance I
ABREAST = [1.0, 1.0, np.sqrt(2), 0.0]  # a plane wave from abeam: all ones


def quality(covariance: list[float], power: float, noise: float):
    psds = np.array([[[power], [noise]]])
    return qualities(psds, np.array([[covariance, WHITE]]))[0]


@pytest.mark.parametrize("ratio", [1.0, 4.0, 100.0])
def test_two_deaf_microphones_are_one(ratio: float) -> None:
    """Independent at both microphones: kept v^2 / (v + n), missed v n / (v + n)."""
    found = quality(WHITE, ratio, 1.0)
    assert found.si_sdr == pytest.approx(SLOPE * 10 * np.log10(ratio) + OFFSET)
    assert found.si_sdri == pytest.approx(found.si_sdr - 10 * np.log10(ratio))


@pytest.mark.parametrize("ratio", [1.0, 4.0, 100.0])
def test_a_plane_wave_is_heard_twice(ratio: float) -> None:
    """S = v 1 1^T + n I: what is missed is v n / (2 v + n), so the ratio is 2 v / n."""
    assert quality(ABREAST, ratio, 1.0).si_sdr == pytest.approx(SLOPE * 10 * np.log10(2 * ratio) + OFFSET)


def test_a_group_whose_twin_stands_in_the_same_place_is_not_clean() -> None:
    alone = quality(ABREAST, 1.0, 0.01).si_sdr
    psds, covariances = np.array([[[1.0], [1.0], [0.01]]]), np.array([[ABREAST, ABREAST, WHITE]])
    assert qualities(psds, covariances)[0].si_sdr < alone - 20


@pytest.mark.soak
def test_the_estimate_is_near_the_truth() -> None:
    rng = np.random.default_rng(3)
    voices = [synthetic_voice(variant, RATE).speech[: 4 * RATE] for variant in range(3)]
    azimuths = np.deg2rad([170.0, 70.0, -50.0])
    target, stft = 1, Stft(RATE, FRAME, HOP)
    recording = record(voices, azimuths, target, float(best_headings(azimuths)[target]), SETTINGS["S1"], rng=rng)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True))
    group = groups.members.index((target,))
    voice = stft.synthesise(groups.signals[group], recording.mixture.shape[1])
    assert groups.quality[group].si_sdr == pytest.approx(si_sdr(voice, recording.reference), abs=4)
    assert groups.quality[group].si_sdri == pytest.approx(
        si_sdri(voice, recording.mixture[0], recording.reference), abs=4
    )


@pytest.mark.parametrize("noise", [1e-5, 1e-6, 1e-7, 1e-9, 0.0])
def test_one_voice_without_noise_is_not_believed_cleaner_than_single_precision_tells(noise: float) -> None:
    rng = np.random.default_rng(5)
    psds = np.stack([rng.exponential(size=(300, 50)), np.full((300, 50), noise)], axis=1).astype(np.float32)
    covariances = np.tile(np.array([[ABREAST, WHITE]], np.float32), (300, 1, 1))
    assert qualities(psds, covariances)[0].si_sdr <= SLOPE * 60 + OFFSET + 1e-6
