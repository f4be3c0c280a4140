from functools import cache

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from examples import in_soak, rows_in_soak
from ross_payload import plugins
from ross_payload.dsp.steering import steering_vectors
from ross_payload.errors import PluginError
from ross_payload.interfaces import Groups, Scene, Separator
from ross_sim.study import baselines
from ross_sim.study.baselines import fastmnmf2, ilrma, library

FREQUENCIES = np.fft.rfftfreq(128, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.7, 0.8])
BOTH = pytest.mark.parametrize("separator", [ilrma, fastmnmf2], ids=lambda separator: separator.name)


def _mixture(tau: np.ndarray = TAU, frames: int = 150) -> tuple[np.ndarray, np.ndarray]:
    """Sources of low rank: each switches between two spectra of its own; images at microphone 1 and the mixture."""
    rng = np.random.default_rng(0)
    shape = (len(tau), FREQUENCIES.size, frames)
    psds = rng.gamma(0.3, size=(len(tau), FREQUENCIES.size, 2)) @ rng.gamma(0.3, size=(len(tau), 2, frames))
    images = np.sqrt(psds) * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
    return images, np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, tau), images)


def _scene(tau: np.ndarray | None, n_sources: int = 2, seed: int = 0) -> Scene:
    return Scene(FREQUENCIES, 0.05, 343.0, n_sources, tau, seed=seed)


@cache
def _separated(name: str, order: tuple[int, ...]) -> Groups:
    return {each.name: each for each in (ilrma, fastmnmf2)}[name].batch(_mixture()[1], _scene(TAU[list(order)]))


def _error_db(estimate: np.ndarray, image: np.ndarray) -> float:
    heard = (FREQUENCIES > 300) & (FREQUENCIES < 7000)
    return float(10 * np.log10((np.abs(estimate - image) ** 2)[heard].sum() / (np.abs(image) ** 2)[heard].sum()))


@BOTH
@pytest.mark.parametrize("order", [[1, 0], *in_soak([0, 1])])
def test_groups_are_told_apart_by_their_directions(separator: Separator, order: list[int]) -> None:
    images, _ = _mixture()
    groups = _separated(separator.name, tuple(order))
    assert groups.members == ((0,), (1,))
    for signal, right, wrong in zip(groups.signals, order, order[::-1], strict=True):
        assert _error_db(signal, images[right]) < -3
        assert _error_db(signal, images[wrong]) > 0


@BOTH
def test_outputs_are_what_microphone_1_hears(separator: Separator) -> None:
    _, mixture = _mixture()
    total = _separated(separator.name, (0, 1)).signals.sum(axis=0)
    assert _error_db(total, mixture[0]) < -20


@BOTH
def test_aliased_interferers_are_one_group(separator: Separator) -> None:
    _, mixture = _mixture(LONGEST * np.array([0.8, -0.7, 0.8]), frames=30)
    groups = separator.batch(mixture, _scene(LONGEST * np.array([0.8, -0.7, 0.8]), 3))
    assert groups.members == ((0, 2), (1,))
    assert len(groups.signals) == 2


def test_fastmnmf2_has_an_output_per_group() -> None:
    tau = LONGEST * np.array([0.8, -0.7, 0.0])
    groups = fastmnmf2.batch(_mixture(tau, frames=30)[1], _scene(tau, 3))
    assert groups.members == ((0,), (1,), (2,))
    assert groups.signals.shape[0] == 3


@BOTH
def test_the_seed_alone_decides(separator: Separator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(baselines, "MNMF_ITERATIONS", 10)
    _, mixture = _mixture(frames=30)
    first = separator.batch(mixture, _scene(TAU)).signals
    np.random.random()  # noqa: NPY002
    np.testing.assert_array_equal(separator.batch(mixture, _scene(TAU)).signals, first)
    assert not np.array_equal(separator.batch(mixture, _scene(TAU, seed=1)).signals, first)


def test_the_global_generator_and_the_threads_are_given_back() -> None:
    before, threads = np.random.get_state()[1].copy(), [pool["num_threads"] for pool in threadpool_info()]  # noqa: NPY002
    with library(seed=5):
        assert all(pool["num_threads"] == 1 for pool in threadpool_info())
        np.random.random()  # noqa: NPY002
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    assert [pool["num_threads"] for pool in threadpool_info()] == threads


@BOTH
@pytest.mark.parametrize(
    ("tau", "count"), [(TAU, 2), (None, 1), *rows_in_soak((None, 2), (TAU[:1], 1), (np.zeros(0), 0))]
)
def test_silence_no_frames_and_a_dead_microphone_give_finite_signals(
    monkeypatch: pytest.MonkeyPatch, separator: Separator, tau: np.ndarray | None, count: int
) -> None:
    monkeypatch.setattr(baselines, "MNMF_ITERATIONS", 10)
    mixture = _mixture(frames=20)[1].astype(np.complex64)
    dead = [mixture * np.array(on, np.float32)[:, None, None] for on in ([0, 0], [1, 0], [0, 1])]
    for changed in (*dead, mixture[..., :0]):
        groups = separator.batch(changed, _scene(tau, count))
        assert groups.signals.shape == (count, *changed.shape[1:])
        assert groups.signals.dtype == changed.dtype
        assert np.isfinite(groups.signals).all()


@BOTH
def test_one_frame_is_too_little_and_the_groups_say_so(separator: Separator) -> None:
    mixture = _mixture(frames=1)[1]
    groups = separator.batch(mixture, _scene(TAU))
    assert "not separated" in groups.why
    np.testing.assert_array_equal(groups.signals, mixture[[0, 0]])


@pytest.mark.parametrize("name", ["ilrma", "fastmnmf2"])
def test_a_missing_extra_is_named(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(__import__("sys").modules, "ross_sim.study.baselines")
    monkeypatch.setitem(__import__("sys").modules, "pyroomacoustics.bss", None)
    monkeypatch.setitem(__import__("sys").modules, "pyroomacoustics", None)
    with pytest.raises(PluginError, match=r"install .*pyroomacoustics"):
        plugins.load("ross_payload.separators", name)
