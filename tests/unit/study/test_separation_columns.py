"""What recordings are made of, and what the columns of a study say of separators and oracles."""

import numpy as np
import pytest

from examples import in_soak
from ross_payload import plugins
from ross_payload.dsp.metrics import si_sdri
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError
from ross_sim.study.runs.scoring import NOISE_BLIND, Belief, separations, tools_of
from ross_sim.study.runs.study_design import chosen
from ross_sim.study.scenes.mixtures import FRAME, HOP, RATE, Mixture, aligned_heading, gains, layouts, record, scene_of
from ross_sim.study.scenes.room_settings import SETTINGS


def _voices(n: int = 12000) -> list[np.ndarray]:
    """Three bursts of noise that take turns, the first of them longest."""
    rng = np.random.default_rng(0)
    return [rng.standard_normal(n) * np.repeat(rng.gamma(0.3, size=n // 600), 600) for _ in range(3)]


@pytest.fixture(scope="module")
def recording() -> Mixture:
    """The first talker of the paper's layout at its alignment, in the open."""
    rng = np.random.default_rng(0)
    azimuths = layouts(3, 0, rng)[0]
    return record(_voices(), azimuths, 0, aligned_heading(azimuths, 0), SETTINGS["S1"], rng=rng)


def test_the_reference_is_the_target_alone_and_all_talkers_and_noise_are_the_mixture(recording: Mixture) -> None:
    noise = recording.mixture - recording.images.sum(axis=0)
    np.testing.assert_array_equal(recording.reference, recording.images[recording.target, 0])
    clean = (recording.images.sum(axis=0)[0] ** 2).mean()
    assert 10 * np.log10(clean / (noise[0] ** 2).mean()) == pytest.approx(15, abs=0.2)


def test_an_oracle_beats_the_beam_and_both_have_one_number(recording: Mixture) -> None:
    asked = chosen("separation", {"separators": ("mvdr", "tvmwf")}, quick=False)
    made = list(separations(asked, tools_of(asked), recording, Belief(recording.tau)))
    assert [one.separator for one in made] == ["mvdr", "tvmwf"]
    beam, oracle = (si_sdri(one.voice_of(0), recording.mixture[0], recording.reference) for one in made)
    assert oracle > beam > 0


@pytest.mark.parametrize("name", ["mvdr", *in_soak(*sorted(NOISE_BLIND - {"fastmnmf2", "mvdr"}))])
def test_columns_with_one_number_do_not_depend_on_the_noise_psd(name: str, recording: Mixture) -> None:
    separator, stft = plugins.load("ross_payload.separators", name), Stft(RATE, FRAME, HOP)
    spectrogram = stft.analyse(recording.mixture)
    with_psd, without = (
        separator.batch(spectrogram, scene_of(recording, stft, known)).signals for known in (True, False)
    )
    np.testing.assert_array_equal(with_psd, without)
    assert abs(gains(separator, recording)[recording.target]) > 0.1


def test_an_unknown_column_is_refused() -> None:
    with pytest.raises(ConfigError, match="'nonesuch' is unknown; there are"):
        chosen("separation", {"separators": ("nonesuch",)}, quick=False)
