"""What one would hear when covariances are renewed: levels that pump, and talkers that swap."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from examples import in_soak
from live_mixtures import FRAMES, SCENE, listened, mixture
from ross_payload.interfaces import Complex, LiveSeparator
from ross_payload.separation import live_gaussian
from ross_payload.separation.live_gaussian import Learnt
from ross_payload.separation.local_gaussian_model import separator

EVERY = 31  # frames between renewals, 0.25 s
AROUND = 4  # frames on either side of a renewal over which a level is taken
PUMPING_DB = 1.0  # which nobody hears, while levels were to jump by more
STRETCH = 20  # frames over which a talker is recognised


def _levels_db(signals: Complex) -> np.ndarray:
    return np.asarray(10 * np.log10((np.abs(signals) ** 2).mean(axis=1) + 1e-3))


def _jumps_db(renewed: Complex, steady: Complex) -> np.ndarray:
    """By how much the level jumps at every renewal, and would not without, (n_groups, n_renewals)."""
    change = _levels_db(renewed) - _levels_db(steady)
    when = np.arange(4 * EVERY, change.shape[1] - AROUND, EVERY)
    after = np.stack([change[:, t + 1 : t + 1 + AROUND].mean(axis=1) for t in when], axis=1)
    return np.abs(after - np.stack([change[:, t - 1 - AROUND : t - 1].mean(axis=1) for t in when], axis=1))


def _between(live: LiveSeparator, heard: Complex, one: Learnt, other: Learnt) -> Complex:
    """Listen while two very different things are learnt in turn."""
    state, found = live.renewed(live.start(SCENE), one), []
    for index in range(heard.shape[2]):
        if index and not index % EVERY:
            state = live.renewed(state, other if (index // EVERY) % 2 else one)
        state, groups = live.step(state, heard[:, :, index], SCENE)
        found.append(groups.signals)
    return np.concatenate(found, axis=2)[..., live.lookahead :]


def _different(live: LiveSeparator, heard: Complex) -> tuple[Learnt, Learnt]:
    """What was learnt, and something far from it: nearly diffuse."""
    learnt = live.learn(heard, SCENE)
    poor = learnt.covariances.copy()
    poor[:, 2:] *= 0.4
    return learnt, replace(learnt, covariances=poor)


Jumps = Callable[[], np.ndarray]


@pytest.fixture(scope="module")
def jumps_db() -> Jumps:
    """Tell the jumps when something very different is renewed, against what is heard without."""
    live, (_, heard) = separator.live(), mixture(frames=3 * FRAMES // 2, steady=True)
    one, other = _different(live, heard)
    steady = _between(live, heard, one, one)
    return lambda: _jumps_db(_between(live, heard, one, other), steady)


@pytest.mark.soak
def test_renewing_covariances_does_not_pump(jumps_db: Jumps) -> None:
    assert jumps_db().max() < PUMPING_DB


@pytest.mark.soak
def test_pumping_would_be_heard(jumps_db: Jumps, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_gaussian, "FADE", 0.0)
    assert jumps_db().max() > PUMPING_DB


def _owners(signals: Complex, images: Complex) -> list[tuple[int, int]]:
    """(group, the talker whose image it resembles most) in every stretch in which that group's talker speaks."""
    found = []
    for first in range(0, signals.shape[2] - STRETCH, STRETCH):
        part = slice(first, first + STRETCH)
        for group, voice in enumerate(signals[..., part]):
            likeness = [
                abs(np.vdot(image, voice)) / (np.linalg.norm(image) * np.linalg.norm(voice) + 1e-9)
                for image in images[..., part]
            ]
            found.append((group, int(np.argmax(likeness))))
    return found


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2)])
def test_talkers_never_swap_when_covariances_are_renewed(seed: int) -> None:
    images, heard = mixture(seed=seed)
    owners = _owners(listened(separator.live(), heard, renew=EVERY // 2), images)
    assert len(owners) == 3 * ((FRAMES - 1) // STRETCH)
    assert all(group == talker for group, talker in owners)


@pytest.mark.soak
def test_a_swap_would_be_heard() -> None:
    live, (images, heard) = separator.live(), mixture()
    learnt = live.learn(heard, SCENE)
    swapped = replace(learnt, covariances=learnt.covariances[[1, 0, 2]])
    owners = _owners(_between(live, heard, learnt, swapped), images)
    assert any(group != talker for group, talker in owners)
