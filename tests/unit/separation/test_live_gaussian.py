from dataclasses import replace

import numpy as np
import pytest

from examples import rows_in_soak
from live_mixtures import FRAMES, FREQUENCIES, LONGEST, SCENE, TAU, listened, mixture, ratio_db
from ross_payload.dsp.steering import steering_vectors
from ross_payload.errors import ConfigError, NotLive
from ross_payload.interfaces import Complex, Scene
from ross_payload.plugin_checks import load_separator


@pytest.mark.parametrize(("lookahead", "worse_db"), [(2, 1.5), *rows_in_soak((0, 2.0), (1, 1.5))])
def test_every_source_comes_out_in_its_group_nearly_as_clean_as_from_the_whole_recording(
    lookahead: int, worse_db: float
) -> None:
    separator, (images, heard) = load_separator("gaussian"), mixture()
    whole = separator.batch(heard, SCENE).signals
    live = listened(separator.live(lookahead), heard, renew=16)
    for k in range(len(TAU)):
        assert ratio_db(live[k, :, 80:], images[k, :, 80:]) > ratio_db(whole[k], images[k]) - worse_db


def _moved(images: Complex, heard: Complex, tau: np.ndarray) -> Complex:
    moved = heard.copy()
    moved[1] = np.einsum("kft,fk->ft", images, steering_vectors(FREQUENCIES, tau)[:, 1])
    return moved


@pytest.mark.soak
def test_covariances_follow_a_source_whose_tdoa_changes() -> None:
    separator, (images, heard) = load_separator("gaussian"), mixture()
    live, elsewhere = separator.live(), TAU - 0.09 * LONGEST * np.array([-1, 1, 1])
    learnt, moved = live.learn(heard, SCENE), _moved(images, heard, elsewhere)

    def found(scene: Scene) -> float:
        state, out = live.renewed(live.start(SCENE), learnt), []
        for index in range(FRAMES):
            state, groups = live.step(state, moved[:, :, index], scene)
            out.append(groups.signals)
        return float(np.mean([ratio_db(np.concatenate(out, axis=2)[k, :, 1:], images[k]) for k in range(3)]))

    assert found(replace(SCENE, tau=elsewhere)) > found(SCENE) + 0.5


def test_another_heading_tells_how_poor_the_room_is_and_nothing_else() -> None:
    live, (_, heard) = load_separator("gaussian").live(), mixture()
    elsewhere = replace(SCENE, tau=-0.5 * TAU)
    for part, share in ((0.0, 0.03), (1.0, 0.6)):
        learnt = replace(live.learn(heard, elsewhere), astray=part)
        state = live.renewed(live.start(SCENE), learnt)
        state, _ = live.step(state, heard[:, :, 0], SCENE)
        white = 2 - np.hypot(*state.covariances[:3, 2:, -1].T).max() * np.sqrt(2)  # at 8 kHz a diffuse field is white
        assert white == pytest.approx(2 * share, rel=0.35)


@pytest.mark.soak
def test_noise_that_nobody_knows_is_guessed() -> None:
    live, (images, heard) = load_separator("gaussian").live(), mixture()
    found = listened(live, heard, replace(SCENE, noise_psd=None), renew=16)
    assert np.mean([ratio_db(found[k, :, 80:], images[k, :, 80:]) for k in range(3)]) > 6


def test_a_scene_without_a_hop_is_taken_to_overlap_by_three_quarters() -> None:
    live, (_, heard) = load_separator("gaussian").live(), mixture(frames=40)
    told, untold = (listened(live, heard, replace(SCENE, hop=hop), renew=16) for hop in (128, None))
    np.testing.assert_array_equal(told, untold)


def test_silence_stays_silent() -> None:
    live = load_separator("gaussian").live()
    heard = listened(live, np.zeros((2, FREQUENCIES.size, 20), np.complex64), renew=8)
    assert np.isfinite(heard).all()
    assert not heard.any()


def test_zeros_in_front_silence_nobody() -> None:
    live, (_, heard) = load_separator("gaussian").live(), mixture(frames=60)
    silent = np.zeros((2, FREQUENCIES.size, 5), heard.dtype)
    found = listened(live, np.concatenate([silent, heard], axis=2), replace(SCENE, noise_psd=None), renew=16)
    assert found.dtype == np.complex64
    assert np.isfinite(found).all()
    assert (np.abs(found).max(axis=(0, 1))[10:] > 0).all()


def test_sources_that_pose_as_one_stay_one_group_though_they_part() -> None:
    live, (_, heard) = load_separator("gaussian").live(), mixture(frames=16)
    together = replace(SCENE, tau=LONGEST * np.array([-0.8, 0.50, 0.52]))
    state = live.start(together)
    for index in range(16):
        scene = replace(together, tau=LONGEST * np.array([-0.8, 0.50 - 0.01 * index, 0.52 + 0.01 * index]))
        state, groups = live.step(state, heard[:, :, index], scene)
        assert groups.members == ((0,), (1, 2))


def test_directions_must_be_known() -> None:
    live = load_separator("gaussian").live()
    with pytest.raises(ConfigError, match="expected the TDOA of every source"):
        live.start(replace(SCENE, tau=None))


def test_a_separator_of_whole_recordings_says_that_it_is_not_live() -> None:
    with pytest.raises(NotLive, match="separator 'lcmv': it separates whole recordings only"):
        load_separator("lcmv").live()
