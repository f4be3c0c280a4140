"""Training of the refiner; what needs jax is soak."""

from pathlib import Path

import numpy as np
import pytest
import soundfile
from click.testing import CliRunner

from ross_payload.errors import ConfigError
from ross_payload.separation.local_gaussian_model import wiener
from ross_payload.separation.network import encode_network, network_of, places, shipped_arrays
from ross_payload.separation.refiner_features import N_FEATURES
from ross_sim.study import train_refiner
from ross_sim.study.train_refiner import (
    FASTEST,
    GROUPS,
    LONGER,
    PIECE,
    SLOWER,
    Recipe,
    Training,
    steps_folder,
    train,
    training,
)
from ross_sim.study.training import noise_pieces, refiner_clips, refiner_data, refiner_model
from ross_sim.study.training.refiner_clips import N_KEPT, clips, kept_out, load, packed, piece
from ross_sim.study.training.refiner_data import clip
from ross_sim.study.training.voice_augmentation import RATE


@pytest.fixture
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clips of 3 s in small rooms without much reverberation: the same code in less time."""
    monkeypatch.setattr(refiner_data, "SECONDS", 3.0)
    monkeypatch.setattr(refiner_data, "T60", (0.22, 0.25))
    monkeypatch.setattr(refiner_data, "PLANE_T60", (0.3, 0.31))


def _voices(n_talkers: int = 3, seconds: float = 4.0) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(0)
    return {f"t{i}": rng.standard_normal(round(seconds * RATE)) for i in range(n_talkers)}


@pytest.mark.soak
@pytest.mark.usefixtures("_short")
def test_a_clip_depends_on_its_number_alone_and_adds_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(refiner_data, "MISSED", 0.0)
    made = clip(_voices(), seed=1, index=4)
    clip(_voices(), seed=1, index=6)
    again = clip(_voices(), seed=1, index=4)
    np.testing.assert_array_equal(made.mixture, again.mixture)
    assert not np.array_equal(made.mixture[0, :9, 9], clip(_voices(), seed=1, index=5).mixture[0, :9, 9])
    rest = made.mixture[0] - made.wanted.sum(axis=0)
    assert (np.abs(rest) ** 2).sum() < 0.5 * (np.abs(made.mixture[0]) ** 2).sum()


@pytest.mark.usefixtures("_short")
def test_a_piece_shows_what_the_payload_would_and_half_precision_is_enough() -> None:
    made = clip(_voices(), seed=1, index=4)
    shown, where, covariances, noise, mixture, wanted = piece(packed(made), 10, 20)
    n_groups, n_freqs = made.wanted.shape[:2]
    assert shown.shape == (n_groups, N_FEATURES, n_freqs, 20)
    assert where.shape == (3, n_freqs // 4)
    np.testing.assert_array_equal(noise, covariances[:, -1, 0] * made.psds[:, -1, 0])
    np.testing.assert_allclose(mixture[0], made.mixture[..., 10:30].real, rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(wanted[1], made.wanted[..., 10:30].imag, rtol=1e-3, atol=1e-6)
    expected = 0.2 * np.log(np.maximum(made.psds[:, :-1, 10:30], 1e-7)).swapaxes(0, 1)
    np.testing.assert_allclose(shown[:, 0], expected, atol=2e-3)


def test_readers_kept_out_speak_for_long_enough_and_do_not_depend_on_the_order() -> None:
    voices = _voices(N_KEPT + 4, 11.0) | {"short": np.zeros(RATE)}
    found = kept_out(voices, 0)
    assert len(found) == N_KEPT
    assert "short" not in found
    assert found == kept_out(dict(reversed(voices.items())), 0)
    with pytest.raises(ConfigError, match="expected at least 16 readers of more than 10"):
        kept_out(_voices(3, 11.0), 0)


def test_the_filter_that_training_differentiates_is_the_one_of_the_payload() -> None:
    rng = np.random.default_rng(2)
    factors = rng.standard_normal((6, 3, 2, 2, 2)) @ [1, 1j]
    matrices = factors @ np.swapaxes(factors.conj(), 2, 3)
    root2 = np.sqrt(2)
    h = [matrices[..., 0, 0].real, matrices[..., 1, 1].real, root2 * matrices[..., 0, 1].real]
    sources = np.stack([*h, root2 * matrices[..., 0, 1].imag], axis=-1)
    sources *= 2 / (sources[..., :1] + sources[..., 1:2])
    covariances = np.concatenate([sources, np.tile([1.0, 1, 0, 0], (6, 1, 1))], axis=1)
    psds, noise = rng.uniform(0.1, 2, (3, 6, 5)), rng.uniform(0.01, 0.1, 6)
    x = rng.standard_normal((2, 6, 5, 2)) @ [1, 1j]
    every = np.concatenate([psds.swapaxes(0, 1), np.tile(noise[:, None, None], (1, 1, 5))], axis=1)
    found = refiner_model.filtered(np, np.log(psds), covariances, noise, np.stack([x.real, x.imag]))
    np.testing.assert_allclose(found[0] + 1j * found[1], wiener(x, every, covariances), rtol=1e-6)


@pytest.mark.soak
@pytest.mark.usefixtures("_short")
def test_a_few_steps_lessen_the_loss_and_the_payload_computes_the_same(tmp_path: Path) -> None:
    jax = pytest.importorskip("jax", reason="training needs jax and optax")
    seed = next(n for n in range(20) if len(clip(_voices(), n, 0).wanted) in GROUPS)
    paths = list(clips(_voices(), tmp_path, 1, seed))
    recipe = Recipe(n_steps=40, n_channels=8, n_blocks=2, n_last=8, each=20)
    weights, batch = train(paths, [], tmp_path, recipe, seed=0), piece(load(paths[0]), 20, PIECE)
    start = refiner_model.initial(8, 2, 8, np.random.default_rng([0, 6]))
    assert refiner_model.loss(np, weights, batch) < refiner_model.loss(np, start, batch)
    shown = batch[0]
    assert shown.shape[-1] == PIECE
    frequencies = np.arange(shown.shape[2]) * float(load(paths[0])["rate"]) / 2048
    expected = refiner_model.corrections(jax.numpy, weights, shown, places(frequencies))
    np.testing.assert_allclose(network_of(weights).corrections(shown, frequencies), expected, atol=1e-4)
    last = next(tmp_path.glob("steps-*/000040.npz"))
    last.unlink()  # as when it was interrupted
    assert encode_network(train(paths, [], tmp_path, recipe, seed=0)) == encode_network(weights)


def test_going_on_begins_with_the_weights_of_a_file_and_takes_smaller_steps(tmp_path: Path) -> None:
    weights = refiner_model.initial(8, 2, 8, np.random.default_rng(4))
    file = tmp_path / "earlier.npz"
    file.write_bytes(encode_network(weights))
    first, further = training(None, None), training(file, None)
    begun = further.purpose.begin(further.recipe, 0)
    assert set(begun) == set(weights)
    np.testing.assert_allclose(begun["in"], weights["in"], rtol=1e-3)
    assert (first.recipe.fastest, further.recipe.fastest) == (FASTEST, SLOWER)
    assert first.recipe.begun != further.recipe.begun
    assert further.folder != first.folder


def test_going_on_is_in_more_reverberant_rooms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    monkeypatch.setattr(refiner_clips, "clip", lambda _voices, _seed, index, longest: asked.append((index, longest)))
    monkeypatch.setattr(refiner_clips, "packed", lambda _: {"rate": np.array(1)})
    file = tmp_path / "earlier.npz"
    file.write_bytes(encode_network(refiner_model.initial(8, 2, 8, np.random.default_rng(4))))
    for way in (training(None, None), training(file, None)):
        assert len(list(way.make({}, tmp_path / f"{way.folder}clips", 2, 0))) == 2
    assert asked == [(0, None), (1, None), (0, LONGER), (1, LONGER)]


def level(path: Path) -> float:
    return float(load(path)["rate"])


def test_clips_of_other_readers_another_seed_or_other_rooms_are_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def loudness(voices: dict[str, np.ndarray], seed: int, index: int, longest: float | None) -> float:
        return float(sum(np.abs(voice).sum() for voice in voices.values())) + seed + index + (longest or 0.0)

    monkeypatch.setattr(refiner_clips, "clip", loudness)
    monkeypatch.setattr(refiner_clips, "packed", lambda value: {"rate": np.array(value)})
    voices, other = _voices(), {f"u{name}": 2 * voice for name, voice in _voices().items()}
    asked = [(voices, 0, None), (other, 0, None), (voices, 7, None), (voices, 0, LONGER)]
    for _ in range(2):  # the second time they are read
        for about, seed, longest in asked:
            found = list(clips(about, tmp_path, 2, seed, longest))
            assert [level(path) for path in found] == [loudness(about, seed, index, longest) for index in (0, 1)]
    folders = {path.parent for about, seed, longest in asked for path in clips(about, tmp_path, 1, seed, longest)}
    assert len(folders) == len(asked)
    recipe = Recipe()
    assert len({steps_folder([folder / "0-00000.npz"], recipe, 0) for folder in folders}) == len(asked)


def test_clips_in_the_noise_of_another_motor_are_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noise_pieces, "clip_in_noise", lambda voices, motor, seed, index: float(motor.sum()))
    monkeypatch.setattr(noise_pieces, "packed", lambda value: {"rate": np.array(value)})
    for motor in (np.ones(3), 2 * np.ones(3)):
        (made,) = noise_pieces.noisy_clips(_voices(), motor, tmp_path, 1, 0)
        assert level(made) == motor.sum()


def test_packages_that_are_missing_are_told_before_any_clip_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    def never(*_: object) -> None:
        raise AssertionError("a clip was made")

    monkeypatch.setattr(train_refiner, "readers", lambda *_: _voices(N_KEPT + 1, 11.0))
    monkeypatch.setattr(train_refiner, "training", lambda *_: Training(never, 1, 1, Recipe()))  # type: ignore[arg-type]
    monkeypatch.setattr(train_refiner.importlib, "import_module", missing)
    done = CliRunner().invoke(
        train_refiner.main, ["--readers", str(tmp_path), "--work", str(tmp_path / "work"), str(tmp_path / "out.npz")]
    )
    assert done.exit_code == 2
    assert "training needs the package jax" in done.output
    assert not (tmp_path / "work").exists()


def test_damaged_weights_to_begin_with_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "weights.npz"
    file.write_bytes(b"no weights")
    with pytest.raises(ConfigError, match="expected the weights of a refiner"):
        training(file, None)


def test_for_noise_it_begins_with_the_shipped_weights_or_those_of_a_file(tmp_path: Path) -> None:
    motor, file = tmp_path / "motor.wav", tmp_path / "earlier.npz"
    soundfile.write(motor, 0.1 * np.random.default_rng(5).standard_normal(RATE), RATE)
    earlier = refiner_model.initial(8, 2, 8, np.random.default_rng(4))
    file.write_bytes(encode_network(earlier))
    shipped, other = training(None, motor), training(file, motor)
    assert shipped.purpose.begin(shipped.recipe, 0)["f0"].shape == shipped_arrays()["f0"].shape
    np.testing.assert_allclose(other.purpose.begin(other.recipe, 0)["f0"], earlier["f0"], rtol=1e-3)
    assert other.recipe.fastest == shipped.recipe.fastest == FASTEST
