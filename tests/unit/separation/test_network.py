import numpy as np
import pytest

from ross_payload.errors import ConfigError
from ross_payload.separation.network import (
    LIMIT,
    Network,
    encode_network,
    network_of,
    places,
    read_network,
    shipped_network,
)
from ross_sim.study.training import refiner_model

N_FEATURES, WIDTH = 10, 11.7
FREQUENCIES = WIDTH * np.arange(20)


def _network(rng: np.random.Generator) -> Network:
    arrays = refiner_model.initial(6, 4, 7, rng)
    arrays["skip"] = rng.normal(0, 0.1, arrays["skip"].shape).astype(np.float32)
    return network_of(arrays)


def _shown(rng: np.random.Generator, n_groups: int = 3, n_freqs: int = 20, n_frames: int = 12) -> np.ndarray:
    return rng.standard_normal((n_groups, N_FEATURES, n_freqs, n_frames)).astype(np.float32)


def _each(shown: np.ndarray) -> list[np.ndarray]:
    """What training takes in one array, feature by feature."""
    return [np.swapaxes(shown[:, index], 0, 1) for index in range(shown.shape[1])]


def _silent(**changes: np.ndarray) -> Network:
    zeros = {name: 0 * array for name, array in refiner_model.initial(2, 1, 2, np.random.default_rng(0)).items()}
    return network_of(zeros | {name: np.asarray(array, np.float32) for name, array in changes.items()})


def test_without_weights_nothing_is_corrected() -> None:
    assert not _silent().corrections(_each(_shown(np.random.default_rng(0))), FREQUENCIES).any()


def test_the_direct_path_carries_every_bin_to_its_own_place() -> None:
    skip = np.zeros((8, N_FEATURES * 8 + 3))
    skip[np.arange(8), np.arange(8)] = 0.1  # the first feature
    shown = _shown(np.random.default_rng(1))
    expected = LIMIT * np.tanh(0.1 * shown[:, 0] / LIMIT)
    np.testing.assert_allclose(_silent(skip=skip).corrections(_each(shown), FREQUENCIES), expected, atol=1e-6)


@pytest.mark.parametrize(("name", "rows", "columns"), [("f0", [0, 1, 2], [1]), ("t0", [1], [2, 3, 4])])
def test_the_taps_of_a_block_reach_its_neighbours_only(name: str, rows: list[int], columns: list[int]) -> None:
    """An impulse in one patch spreads by one patch, along frequency or along time."""
    one = np.zeros((2, 8 * N_FEATURES + 3))
    one[0, 0] = 1.0
    here = np.concatenate([np.zeros((2, 2)), np.eye(2), np.zeros((2, 2))])
    weights = {"in": one, "f0": here, "t0": here, "hid": np.eye(2), "out": np.eye(8, 2)} | {
        name: np.tile(np.eye(2), (3, 1))
    }
    shown = np.zeros((1, N_FEATURES, 12, 12), np.float32)
    row, column = rows[len(rows) // 2], columns[len(columns) // 2]
    shown[0, 0, 4 * row, 2 * column] = 1.0
    found = _silent(**weights).corrections(_each(shown), FREQUENCIES[:12])[0, ::4, ::2]
    expected = np.zeros((3, 6))
    expected[np.ix_(rows, columns)] = 1.0
    expected[row, column] = 2.0  # the block adds to its input
    np.testing.assert_allclose(found, LIMIT * np.tanh(expected / LIMIT), atol=1e-6)


def test_the_mean_of_the_others_is_what_a_group_hears_of_them() -> None:
    one = np.zeros((2, 8 * N_FEATURES + 3))
    one[0, 0] = 1.0
    here = np.concatenate([np.zeros((2, 2)), np.eye(2), np.zeros((2, 2))])
    shown = np.zeros((3, N_FEATURES, 4, 2), np.float32)
    shown[:, 0, 0, 0] = [1.0, 2.0, 6.0]
    network = _silent(**{"in": one, "o0": np.eye(2), "t0": here, "hid": np.eye(2), "out": np.eye(8, 2)})
    found = np.arctanh(network.corrections(_each(shown), FREQUENCIES[:4])[:, 0, 0] / LIMIT) * LIMIT
    np.testing.assert_allclose(found, [1 + 4.0, 2 + 3.5, 6 + 1.5], rtol=1e-5)


def test_permuting_the_groups_permutes_the_corrections() -> None:
    rng = np.random.default_rng(2)
    network, shown, order = _network(rng), _shown(rng, n_groups=4), [2, 0, 3, 1]
    found = network.corrections(_each(shown), FREQUENCIES)
    np.testing.assert_allclose(network.corrections(_each(shown[order]), FREQUENCIES), found[order], atol=1e-5)


@pytest.mark.parametrize("shape", [(1, 2, 1), (2, 5, 3), (5, 9, 1), (3, 4, 40)])
def test_any_number_of_groups_bins_and_frames_fits(shape: tuple[int, int, int]) -> None:
    rng = np.random.default_rng(3)
    found = _network(rng).corrections(_each(_shown(rng, *shape)), FREQUENCIES[: shape[1]])
    assert found.shape == shape
    assert np.isfinite(found).all()
    assert np.abs(found).max() <= LIMIT


@pytest.mark.parametrize("n_frames", [12, 1700])  # the longer one is worked on strip by strip
def test_it_is_the_function_that_training_differentiates(n_frames: int) -> None:
    rng = np.random.default_rng(4)
    weights, shown = refiner_model.initial(6, 4, 7, rng), _shown(rng, n_frames=n_frames)
    expected = refiner_model.corrections(np, weights, shown, places(FREQUENCIES))
    np.testing.assert_allclose(network_of(weights).corrections(_each(shown), FREQUENCIES), expected, atol=1e-5)


def test_weights_survive_a_file_in_half_precision() -> None:
    weights = refiner_model.initial(4, 2, 3, np.random.default_rng(5))
    read = read_network(encode_network(weights), "there")
    np.testing.assert_allclose(read.enter, weights["in"], rtol=1e-3, atol=1e-6)
    assert [block.step for block in read.blocks] == [1, 2]


def test_the_shipped_weights_are_few_and_finite() -> None:
    network = shipped_network()
    arrays = [network.enter, network.leave, network.skip, *(block.along_time for block in network.blocks)]
    assert all(np.isfinite(array).all() for array in arrays)


def test_damaged_weights_are_refused() -> None:
    with pytest.raises(ConfigError, match="there: expected the weights"):
        read_network(b"PK", "there")


def test_frame_by_frame_it_corrects_as_in_the_whole_recording_when_nothing_later_matters() -> None:
    rng, n_frames = np.random.default_rng(6), 24
    weights = refiner_model.initial(8, 4, 8, rng)
    for name, array in weights.items():
        if name.startswith("t"):
            array[-8:] = 0  # the taps of what follows
    weights["out"] = rng.normal(0, 0.1, weights["out"].shape).astype(np.float32)
    network, shown, past, found = network_of(weights), _shown(rng, 2, 12, n_frames), (), []
    whole = network.corrections(_each(shown), FREQUENCIES[:12])
    for frame in range(1, n_frames):
        both, past = network.advance(_each(shown[..., frame - 1 : frame + 1]), FREQUENCIES[:12], past)
        found.append(both)
    np.testing.assert_allclose(np.concatenate(found[::2], axis=2), whole, atol=1e-5)


def test_what_training_hides_is_what_is_not_known_frame_by_frame() -> None:
    rng, n_frames = np.random.default_rng(7), 16
    weights = refiner_model.initial(6, 4, 7, rng)
    weights["out"] = rng.normal(0, 0.1, weights["out"].shape).astype(np.float32)
    shown, past, found = _shown(rng, 3, 12, n_frames), (), []
    for frame in range(1, n_frames):
        both, past = network_of(weights).advance(_each(shown[..., frame - 1 : frame + 1]), FREQUENCIES[:12], past)
        found.append(both)
    expected = refiner_model.corrections(np, weights, shown, places(FREQUENCIES[:12]), 0.0)
    np.testing.assert_allclose(np.concatenate(found[::2], axis=2), expected, atol=1e-5)
