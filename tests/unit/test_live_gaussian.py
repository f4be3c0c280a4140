import numpy as np
import pytest

from ross_payload.dsp.steering import steering_vectors
from ross_payload.errors import ConfigError, NotLive
from ross_payload.interfaces import Complex, LiveSeparator, Scene
from ross_payload.plugin_checks import load_separator

FREQUENCIES = np.fft.rfftfreq(512, 1 / 16000)
LONGEST = 0.05 / 343.0
TAU = LONGEST * np.array([-0.8, 0.1, 0.9])
NOISE = 0.01
FRAMES = 160


def _bins(rng: np.random.Generator, *shape: int) -> Complex:
    return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)).astype(np.complex64) / np.sqrt(2)


def _mixture() -> tuple[Complex, Complex]:
    """Patchy sources of mean power 1: images at microphone 1 and the noisy mixture."""
    rng = np.random.default_rng(0)
    patches = rng.random((len(TAU), 33, FRAMES // 8)) < 0.25
    active = np.kron(patches, np.ones((1, 8, 8)))[:, : FREQUENCIES.size]
    images = 2 * active * _bins(rng, *active.shape)
    clean = np.einsum("fmk,kft->mft", steering_vectors(FREQUENCIES, TAU), images)
    return images, (clean + np.sqrt(NOISE) * _bins(rng, *clean.shape)).astype(np.complex64)


SCENE = Scene(FREQUENCIES, 0.05, 343.0, 3, TAU, np.full(FREQUENCIES.size, NOISE), hop=128)


def _listen(live: LiveSeparator, mixture: Complex, scene: Scene = SCENE, renew: int = 0) -> Complex:
    """Separate frame by frame, put back in time, (n_groups, n_freqs, n_frames - lookahead)."""
    state, learnt, heard = live.start(scene), None, []
    for index in range(mixture.shape[2]):
        state, groups = live.step(state, mixture[:, :, index], scene)
        heard.append(groups.signals)
        if renew and index % renew == renew - 1:
            learnt = live.learn(mixture[:, :, : index + 1], scene, learnt)
            state = live.renewed(state, learnt)
    return np.concatenate(heard, axis=2)[..., live.lookahead :]


def _ratio_db(estimate: Complex, image: Complex) -> float:
    image = image[..., : estimate.shape[-1]]
    return float(10 * np.log10((np.abs(image) ** 2).sum() / (np.abs(estimate - image) ** 2).sum()))


@pytest.mark.parametrize(("lookahead", "worse_db"), [(0, 2.0), (1, 1.5), (2, 1.5)])
def test_every_source_comes_out_in_its_group_nearly_as_clean_as_from_the_whole_recording(
    lookahead: int, worse_db: float
) -> None:
    separator, (images, mixture) = load_separator("gaussian"), _mixture()
    whole = separator.batch(mixture, SCENE).signals
    live = _listen(separator.live(lookahead), mixture, renew=16)
    for k in range(len(TAU)):
        assert _ratio_db(live[k, :, 80:], images[k, :, 80:]) > _ratio_db(whole[k], images[k]) - worse_db


def test_covariances_follow_a_source_whose_tdoa_changes() -> None:
    separator, (images, mixture) = load_separator("gaussian"), _mixture()
    live, elsewhere = separator.live(), 0.6 * TAU
    learnt = live.learn(mixture, SCENE)
    scene = Scene(FREQUENCIES, 0.05, 343.0, 3, elsewhere, SCENE.noise_psd, hop=128)
    moved = mixture.copy()
    moved[1] = np.einsum("kft,fk->ft", images, steering_vectors(FREQUENCIES, elsewhere)[:, 1])
    state, heard = live.renewed(live.start(SCENE), learnt), []
    for index in range(FRAMES):
        state, groups = live.step(state, moved[:, :, index], scene)
        heard.append(groups.signals)
    found = np.concatenate(heard, axis=2)[..., 1:]
    assert min(_ratio_db(found[k], images[k]) for k in range(3)) > 5


def test_silence_stays_silent() -> None:
    live = load_separator("gaussian").live()
    heard = _listen(live, np.zeros((2, FREQUENCIES.size, 20), np.complex64), renew=8)
    assert np.isfinite(heard).all()
    assert not heard.any()


def test_directions_must_be_known() -> None:
    live = load_separator("gaussian").live()
    with pytest.raises(ConfigError, match="expected the TDOA of every source"):
        live.start(Scene(FREQUENCIES, 0.05, 343.0, 3))


def test_a_separator_of_whole_recordings_says_that_it_is_not_live() -> None:
    with pytest.raises(NotLive, match="separator 'lcmv': it separates whole recordings only"):
        load_separator("lcmv").live()
