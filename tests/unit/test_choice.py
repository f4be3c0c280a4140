import numpy as np
import pytest

from ross_payload.dsp.steering import steering_vectors
from ross_payload.interfaces import Scene
from ross_payload.separation.auto_separator import choose, separator

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)
LONGEST = 0.05 / 343.0
APART = LONGEST * np.array([-0.8, 0.8])


def _mixture(tau: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(0)
    shape = (len(tau), FREQUENCIES.size, 60)
    sources = rng.gamma(0.3, size=shape) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), sources)


def _elsewhere() -> np.ndarray:
    """Loud and incoherent: from nowhere in particular."""
    rng = np.random.default_rng(1)
    shape = (2, FREQUENCIES.size, 60)
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


@pytest.mark.parametrize(
    ("tau", "noise", "diffuse", "name", "why"),
    [
        (APART, 1e-5, 0.0, "auxiva", "in the open"),
        (APART, 1e-5, 1.0, "refined", "reverberation"),
        (APART, 0.1, 0.0, "refined", "above the noise"),
        (APART, None, 0.0, "refined", "noise unknown"),
        (APART / 5, 1e-5, 0.0, "refined", "close together"),
        (LONGEST * np.array([-0.8, 0.0, 0.8]), 1e-5, 0.0, "refined", "3 groups"),
        (APART[[0, 1, 0]], 1e-5, 0.0, "auxiva", "two groups"),
    ],
)
def test_known_directions(tau: np.ndarray, noise: float | None, diffuse: float, name: str, why: str) -> None:
    psd = None if noise is None else np.full(FREQUENCIES.size, noise)
    scene = Scene(FREQUENCIES, 0.05, 343.0, len(tau), tau, psd)
    groups = separator.batch(_mixture(tau) + diffuse * _elsewhere(), scene)
    assert groups.method == name
    assert why in groups.why


@pytest.mark.parametrize(("n_sources", "name"), [(2, "auxiva"), (3, "duet"), (5, "duet")])
def test_unknown_directions(n_sources: int, name: str) -> None:
    scene = Scene(FREQUENCIES, 0.05, 343.0, n_sources)
    method, why = choose(_mixture(APART), scene)
    assert method.name == name
    assert "unknown" in why
