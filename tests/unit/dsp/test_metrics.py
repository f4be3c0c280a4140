import numpy as np
import pytest

from ross_payload.dsp.metrics import si_sdr, si_sdri
from ross_payload.errors import AudioError

rng = np.random.default_rng(0)
SIGNAL = rng.standard_normal(1000)
OTHER = rng.standard_normal(1000)


def test_neither_scale_nor_sign_nor_offset_matters() -> None:
    estimate = SIGNAL + 0.3 * OTHER
    expected = si_sdr(estimate, SIGNAL)
    for changed in (5 * estimate, -estimate, estimate + 7):
        assert si_sdr(changed, SIGNAL) == pytest.approx(expected, abs=1e-9)


def test_it_is_the_energy_ratio_of_orthogonal_parts() -> None:
    signal = SIGNAL - SIGNAL.mean()
    error = OTHER - OTHER.mean()
    error -= (error @ signal) / (signal @ signal) * signal
    error *= np.linalg.norm(signal) / np.linalg.norm(error) / 100
    assert si_sdr(signal + error, signal) == pytest.approx(40.0, abs=1e-9)


def test_nothing_gained_is_zero() -> None:
    assert si_sdri(SIGNAL + OTHER, SIGNAL + OTHER, SIGNAL) == 0.0


@pytest.mark.parametrize(
    ("estimate", "reference", "reason"),
    [
        (np.zeros(1000), SIGNAL, "estimate: expected sound, got silence"),
        (SIGNAL, np.full(1000, 0.1), "reference: expected sound, got silence"),
        (SIGNAL[:-1], SIGNAL, "expected an estimate of 1000 samples, .* got 999"),
        (np.where(SIGNAL > 2, np.nan, SIGNAL), SIGNAL, "expected finite samples"),
        (SIGNAL[None], SIGNAL, "one channel"),
    ],
)
def test_what_cannot_be_scored_is_refused(estimate: np.ndarray, reference: np.ndarray, reason: str) -> None:
    with pytest.raises(AudioError, match=reason):
        si_sdr(estimate, reference)
