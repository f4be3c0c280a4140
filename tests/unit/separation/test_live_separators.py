from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from examples import in_soak
from live_mixtures import LONGEST, SCENE, TAU, bins, listened, mixture
from ross_payload.errors import NotLive, PluginError
from ross_payload.interfaces import Complex, Groups, Scene
from ross_payload.plugin_checks import CheckedSeparator, load_separator
from ross_payload.separation import auto_separator, duet, local_gaussian_model
from ross_payload.separation.network import network_of
from ross_payload.separation.refined import Refined
from ross_sim.study.training.refiner_model import initial

FINE = np.fft.rfftfreq(1600, 1 / 16000)  # bins of 10 Hz, which the network was trained for


def _fine() -> tuple[Scene, Complex]:
    heard = bins(np.random.default_rng(0), 2, FINE.size, 24)
    return replace(SCENE, frequencies=FINE, noise_psd=np.full(FINE.size, 0.1), hop=400), heard


def test_duet_gives_the_frames_of_the_whole_recording() -> None:
    _, heard = mixture(frames=40)
    whole = duet.separator.batch(heard, SCENE).signals
    live = listened(duet.separator.live(), heard)
    np.testing.assert_allclose(live[..., 1:], whole[..., 1:39], atol=1e-5)


@pytest.mark.soak
def test_duet_guesses_the_noise_that_nobody_knows() -> None:
    unknown, (_, heard) = replace(SCENE, noise_psd=None), mixture()
    loud = listened(duet.separator.live(), heard, unknown)
    quiet = listened(duet.separator.live(), heard, unknown, renew=16)
    assert (np.abs(quiet[..., 80:]) ** 2).sum() < (np.abs(loud[..., 80:]) ** 2).sum()


def test_a_network_that_corrects_nothing_leaves_the_local_gaussian_model() -> None:
    scene, heard = _fine()
    weights = {name: np.zeros_like(array) for name, array in initial(8, 2, 8, np.random.default_rng(0)).items()}
    corrected = listened(Refined(network_of(weights)).live(), heard, scene, renew=8)
    plain = listened(local_gaussian_model.separator.live(), heard, scene, renew=8)
    np.testing.assert_allclose(corrected, plain, rtol=1e-2, atol=1e-3)


@pytest.mark.parametrize("lookahead", [0, 2, *in_soak(1)])
def test_a_correction_reaches_the_frame_that_it_is_about(lookahead: int) -> None:
    scene, heard = _fine()
    weights = {name: np.zeros_like(array) for name, array in initial(8, 2, 8, np.random.default_rng(0)).items()}
    weights["skip"][:, 24:32] = 5 * np.eye(8)  # the power of the mixture raises the PSD: the loud frame only
    heard *= 1e-3
    heard[:, :, 12] *= 1e3
    corrected = listened(Refined(network_of(weights)).live(lookahead), heard, scene)
    plain = listened(local_gaussian_model.separator.live(lookahead), heard, scene)
    changed = np.abs(np.abs(corrected) - np.abs(plain)).sum(axis=(0, 1))
    assert changed.argmax() == 12


def test_frames_that_overlap_more_are_corrected_too() -> None:
    scene, heard = _fine()
    close = replace(scene, hop=200)
    corrected = listened(Refined().live(), heard, close)
    plain = listened(local_gaussian_model.separator.live(), heard, close)
    assert np.isfinite(corrected).all()
    assert np.abs(corrected - plain).max() > 1e-3


def test_without_a_look_ahead_auto_does_without_the_network() -> None:
    assert [auto_separator.separator.live(n).name for n in (0, 1)] == ["gaussian", "refined"]


@pytest.mark.parametrize("name", ["gaussian", "duet", *in_soak("auto")])
@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("n_sources", [0, 2, *in_soak(1, 8)])
def test_any_number_of_talkers_at_any_level_gives_finite_groups(name: str, known: bool, n_sources: int) -> None:
    live, tau = load_separator(name).live(1), LONGEST * np.linspace(-1, 1, n_sources)
    noise = np.full(FINE.size, 1e-4) if known else None
    scene = Scene(FINE, 0.05, 343.0, n_sources, tau, noise, hop=400)
    loudness = np.array([1, 1, 1e4, 1, 0, 0, 1e-6, 1])
    heard = bins(np.random.default_rng(0), 2, FINE.size, loudness.size) * loudness
    assert np.isfinite(listened(live, heard.astype(np.complex64), scene, renew=3)).all()


class _Plugin:
    """Gives the mixture to every group, or what a test wants instead."""

    name = "mine"

    def __init__(self, **instead: Any) -> None:
        self.instead, self.lookahead = instead, 1

    def batch(self, spectrogram: Complex, scene: Scene) -> Groups:
        raise NotImplementedError

    def live(self, lookahead: int) -> Any:
        self.lookahead = self.instead.get("lookahead", lookahead)
        return self

    def start(self, scene: Scene) -> int:
        return 0

    def step(self, state: int, frame: Complex, scene: Scene) -> Any:
        make: Callable[[Complex], Any] = self.instead.get("step", lambda frame: (state + 1, _groups(frame)))
        return make(frame)

    def learn(self, window: Complex, scene: Scene, before: Any = None) -> Any:
        return None

    def renewed(self, state: int, learnt: Any) -> int:
        return state


def _groups(frame: Complex, scale: float = 1.0) -> Groups:
    return Groups(np.repeat(scale * frame[:1, :, None], 3, axis=0), ((0,), (1,), (2,)), "mine")


def _fails(frame: Complex) -> Any:
    raise ZeroDivisionError("no\nluck")


def test_a_live_plug_in_is_used() -> None:
    _, heard = mixture(frames=8)
    found = listened(CheckedSeparator("separator 'mine'", _Plugin()).live(1), heard, renew=4)
    assert found.shape == (len(TAU), heard.shape[1], 7)


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (_fails, "step raised ZeroDivisionError: no luck"),
        (_groups, "step: expected a state and groups, got Groups"),
        (lambda frame: (0, None), "step: expected Groups, got NoneType"),
        (lambda frame: (0, _groups(frame[:, 1:])), "step: signals: expected shape"),
        (lambda frame: (0, _groups(frame, np.nan)), "step: signals: expected finite numbers"),
    ],
)
def test_what_a_live_plug_in_does_wrong_becomes_one_line(step: Callable[[Complex], Any], message: str) -> None:
    live = CheckedSeparator("separator 'mine'", _Plugin(step=step)).live(1)
    with pytest.raises(PluginError, match=f"separator 'mine': {message}"):
        live.step(live.start(SCENE), mixture(frames=8)[1][:, :, 0], SCENE)


def test_a_live_plug_in_must_look_as_far_ahead_as_it_is_told() -> None:
    with pytest.raises(PluginError, match="live: expected a lookahead of 2, got 5"):
        CheckedSeparator("separator 'mine'", _Plugin(lookahead=5)).live(2)


def test_a_live_plug_in_must_have_every_method() -> None:
    class Half(_Plugin):
        learn = None  # type: ignore[assignment]

    with pytest.raises(PluginError, match=r"expected a method learn\(window, scene, before\), got None"):
        CheckedSeparator("separator 'mine'", Half()).live(1)


def test_a_plug_in_without_live_is_told_apart() -> None:
    class Whole(_Plugin):
        live = None  # type: ignore[assignment]

    with pytest.raises(NotLive, match="separator 'mine': it separates whole recordings only"):
        CheckedSeparator("separator 'mine'", Whole()).live(1)
