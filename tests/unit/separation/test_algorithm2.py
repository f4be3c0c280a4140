"""Algorithm 2 of the paper: "if K > 3 perform DUET, else if K <= 3 perform IVA"."""

import numpy as np
import pytest

from examples import rows_in_soak
from ross_payload import plugins
from ross_payload.interfaces import Scene
from ross_payload.separation import duet, natural_gradient_iva


def scene(k: int) -> Scene:
    tau = np.linspace(-1, 1, k) * 0.05 / 343.0
    return Scene(np.linspace(0, 8000, 65), 0.05, 343.0, k, tau)


@pytest.mark.parametrize(
    ("k", "method"),
    [
        (3, natural_gradient_iva),
        (4, duet),
        *rows_in_soak((1, natural_gradient_iva), (2, natural_gradient_iva), (5, duet)),
    ],
)
def test_up_to_three_sources_are_unmixed_and_more_are_masked(k: int, method) -> None:
    separator = plugins.load("ross_payload.separators", "paper")
    rng = np.random.default_rng(k)
    heard = (rng.standard_normal((2, 65, 40)) + 1j * rng.standard_normal((2, 65, 40))).astype(np.complex64)
    groups, same = separator.batch(heard, scene(k)), method.separator.batch(heard, scene(k))
    assert groups.method == method.separator.name
    assert groups.members == same.members
    np.testing.assert_array_equal(groups.signals, same.signals)
    assert f"K = {k}" in groups.why


def test_the_reason_of_the_method_itself_is_told_too() -> None:
    deaf = np.zeros((2, 65, 40), np.complex64)
    unknown = Scene(np.linspace(0, 8000, 65), 0.05, 343.0, 4, None)
    said = plugins.load("ross_payload.separators", "paper").batch(deaf, unknown).why
    assert said == "K = 4, as in Algorithm 2; no delay found: the mixture as it is"
