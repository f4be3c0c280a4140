import numpy as np

from ross_payload.dsp.covariance import ROOT2, adjugate, determinant, direct, outer
from ross_payload.dsp.steering import steering_vectors

rng = np.random.default_rng(0)


def _coordinates(matrix: np.ndarray) -> np.ndarray:
    return np.array([matrix[0, 0].real, matrix[1, 1].real, ROOT2 * matrix[0, 1].real, ROOT2 * matrix[0, 1].imag])


def _hermitian() -> np.ndarray:
    factor = rng.standard_normal((2, 2)) + 1j * rng.standard_normal((2, 2))
    return factor @ factor.conj().T


def test_the_dot_product_of_coordinates_is_the_trace_of_the_product() -> None:
    first, second = _hermitian(), _hermitian()
    np.testing.assert_allclose(_coordinates(first) @ _coordinates(second), np.trace(first @ second).real)


def test_adjugate_over_determinant_is_the_inverse() -> None:
    matrix = _hermitian()
    coordinates = _coordinates(matrix)
    expected = _coordinates(np.linalg.inv(matrix))
    np.testing.assert_allclose(adjugate(coordinates) / determinant(coordinates), expected)


def test_a_plane_wave_has_the_covariance_of_its_steering_vector() -> None:
    frequencies, tau = np.array([500.0, 2000.0]), np.array([1e-4, -5e-5])
    vectors = steering_vectors(frequencies, tau)
    np.testing.assert_allclose(direct(frequencies, tau), np.swapaxes(outer(np.moveaxis(vectors, 1, 0)), 1, 2))
