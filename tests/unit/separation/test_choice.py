import numpy as np
import pytest

from ross_payload.dsp.steering import steering_vectors
from ross_payload.interfaces import Scene
from ross_payload.separation.auto_separator import choose, separator

FREQUENCIES = np.fft.rfftfreq(2048, 1 / 16000)  # frames that the network of `refined` knows
LONGEST = 0.05 / 343.0
APART = LONGEST * np.array([-0.8, 0.8])


def _mixture(tau: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(0)
    shape = (len(tau), FREQUENCIES.size, 60)
    sources = rng.gamma(0.3, size=shape) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), sources)


@pytest.mark.parametrize("tau", [APART, APART / 5, APART[[0, 1, 0]], LONGEST * np.array([-0.8, 0.0, 0.8])])
@pytest.mark.parametrize("noise", [None, 1e-5, 0.1])
def test_known_directions(tau: np.ndarray, noise: float | None) -> None:
    psd = None if noise is None else np.full(FREQUENCIES.size, noise)
    groups = separator.batch(_mixture(tau), Scene(FREQUENCIES, 0.05, 343.0, len(tau), tau, psd))
    assert (groups.method, groups.why) == ("refined", "directions known")


@pytest.mark.parametrize(("n_sources", "name"), [(2, "auxiva"), (3, "duet"), (5, "duet")])
def test_unknown_directions(n_sources: int, name: str) -> None:
    scene = Scene(FREQUENCIES, 0.05, 343.0, n_sources)
    method, why = choose(scene)
    assert method.name == name
    assert "unknown" in why
