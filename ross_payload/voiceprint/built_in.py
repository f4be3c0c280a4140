"""The built-in model of voices: factor analysis of how a voice moves a Gaussian mixture over cepstra.

A mixture over the frames of many voices is the background. How the frames of one recording lie about its means is
explained by some hundred factors ("i-vector": Dehak, Kenny, Dehak, Dumouchel and Ouellet, "Front-end factor analysis
for speaker verification", IEEE Trans. Audio, Speech and Language Processing 19 (2011)); short recordings move them
little. Together with the pitch they are projected to where talkers differ and rooms, separators and noise do not
(linear discriminant analysis). A recording is compared with a print by the cosine of what comes out, normalised by
those with other talkers (`ross_payload.voiceprint.score_normalisation`).
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files

import numpy as np

from ross_payload.array_files import decode_arrays, encode_arrays
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.embedding_print import (
    LEAST_SECONDS,
    Calibration,
    EmbeddingPrint,
    enrolled_print,
    unit,
)
from ross_payload.voiceprint.features import RATE, Features, analyse
from ross_payload.voiceprint.score_normalisation import Cohort

FILE = "built_in.npz"
HALVED = ("means", "deviations", "directions", "cohort")  # float16: rounding moves a score by less than 0.01 nat
PITCH_QUANTILES = (20, 50, 80)  # [percent]
USUAL_PITCH, PITCH_SPREAD = 5.0, 0.3  # of the logarithm of F0 / 1 Hz
POOR = (0.9, -0.306)  # slope [nat] and threshold of poor voices, by `ross_sim.study.calibrate_voice_model`
SEVERAL = 1.0  # `Embedder.several` [nat], docs/decisions/0119 and 0125
PITCH_FRAMES = 20.0  # after so many, half of the pitch is believed


@dataclass(frozen=True, slots=True, eq=False)
class Parameters:
    """What is learnt."""

    weights: Real  # of the Gaussians, (n_gaussians,)
    means: Real  # (n_gaussians, n_features)
    deviations: Real  # (n_gaussians, n_features)
    loadings: Real  # in units of `steps`, whole numbers up to 127, (n_gaussians * n_features, n_factors)
    steps: Real  # [standard deviations], (n_factors,)
    independence: Real  # how many independent frames one frame counts for, ()
    centre: Real  # of factors and pitch, (n_factors + 3,)
    directions: Real  # in which talkers differ, weighted by how much, (n_factors + 3, size)
    cohort: Real  # embeddings of other talkers, of length 1, (n, size)
    slopes: Real  # of the calibration, (2,)
    thresholds: Real  # (2,)
    separated: Real  # log-likelihood ratio [nat] at which a print of a separated voice is undecided, ()


class BuiltInModel:
    """The model that the package comes with, as a model of voices."""

    def __init__(self, parameters: Parameters, source: str = "") -> None:
        self.parameters = parameters
        digest = hashlib.sha256()
        for each in fields(parameters):
            digest.update(np.ascontiguousarray(getattr(parameters, each.name), dtype="<f4").tobytes())
        self.fingerprint = digest.hexdigest()[:16]
        (short, long), (low, high) = parameters.slopes.round(4).tolist(), parameters.thresholds.round(4).tolist()
        self.calibration = Calibration((short, long), (low, high), source, POOR)
        self.several = SEVERAL
        self.size = parameters.directions.shape[1]
        self._background = Background(parameters.weights, parameters.means, parameters.deviations)
        self._factors = Factors(parameters.loadings * parameters.steps, float(parameters.independence))
        self._cohort = Cohort(parameters.cohort)

    def enrolled(self, samples: Real, features: Features, *, separated: bool) -> EmbeddingPrint:
        """Return the print of a voice (n,) at `RATE`; one that was ``separated`` has a criterion of its own."""
        criterion = round(float(self.parameters.separated), 4) if separated else 0.0
        return enrolled_print(self, samples, features.seconds, separated=separated, criterion=criterion)

    def similarity(self, enrolled: Real, test: Real) -> float:
        """Return how alike two embeddings (size,) are: their cosine, normalised [standard deviations]."""
        return self._cohort.normalised(enrolled, test)

    def embed(self, samples: Real) -> Real:
        """Return the embedding of a recording (n,) at `RATE`, of length 1 or, with hardly any voice, 0, (size,)."""
        if len(samples) < LEAST_SECONDS * RATE:
            return np.zeros(self.size)
        return self.embedding_of(analyse(samples, RATE))

    def embedding_of(self, features: Features) -> Real:
        """Return the same of what was measured."""
        if features.seconds < LEAST_SECONDS:
            return np.zeros(self.size)
        factors = np.append(self._factors.of(*self._background.statistics(features.cepstra)), pitch_of(features))
        return unit((factors - self.parameters.centre) @ self.parameters.directions)


class Background:
    """A mixture of Gaussians with diagonal covariances: weights (n,), means and deviations (n, n_features)."""

    def __init__(self, weights: Real, means: Real, deviations: Real) -> None:
        self._means, self._deviations = means, deviations
        self._precisions = np.asarray(1 / deviations.T**2, np.float32)
        self._slopes = np.asarray((means / deviations**2).T, np.float32)
        constant = np.log(weights) - np.log(deviations).sum(axis=1) - ((means / deviations) ** 2).sum(axis=1) / 2
        self._constant = constant.astype(np.float32)

    def statistics(self, frames: Real) -> tuple[Real, Real]:
        """Return how many of the frames (m, n_features) belong to each Gaussian, (n,), and where they lie.

        The latter is the sum of their deviations from its mean [standard deviations], (n, n_features).
        """
        exponent = frames @ self._slopes - 0.5 * (frames * frames) @ self._precisions + self._constant
        posterior = np.exp(exponent - exponent.max(axis=1, keepdims=True))
        posterior /= posterior.sum(axis=1, keepdims=True)
        count = posterior.sum(axis=0, dtype=np.float64)
        return count, (posterior.T @ frames - count[:, None] * self._means) / self._deviations


class Factors:
    """The factors behind the statistics of a recording.

    With the counts n_c, sums f_c, loadings T_c (n_features, n_factors) and s independent frames per frame, their mean
    is (I + s sum_c n_c T_c^T T_c)^-1 s sum_c T_c^T f_c.

    Parameters
    ----------
    loadings
        Of the standard deviations, (n_gaussians * n_features, n_factors).
    independence
        s.
    """

    def __init__(self, loadings: Real, independence: float) -> None:
        self._loadings = np.asarray(loadings, np.float32)
        self._independence = independence
        self._products: Real | None = None  # T_c^T T_c, (n_gaussians, n_factors^2)

    def of(self, count: Real, sums: Real) -> Real:
        """Return the mean of the factors given counts (n,) and sums (n, n_features), (n_factors,)."""
        n_factors = self._loadings.shape[1]
        if self._products is None:
            each = self._loadings.reshape(*sums.shape, n_factors)
            self._products = (each.transpose(0, 2, 1) @ each).reshape(len(sums), -1)
        precision = self._independence * (count.astype(np.float32) @ self._products).reshape(n_factors, n_factors)
        linear = self._independence * (sums.ravel() @ self._loadings)
        return np.asarray(np.linalg.solve(np.eye(n_factors) + precision, linear))


def pitch_of(features: Features) -> Real:
    """Return quantiles of the logarithm of the pitch about the usual, of less size the fewer frames there are, (3,)."""
    believed = len(features.pitch) / (len(features.pitch) + PITCH_FRAMES)
    if not believed:
        return np.zeros(len(PITCH_QUANTILES))
    low, middle, high = np.percentile(features.pitch, PITCH_QUANTILES)
    return np.asarray(believed * (np.array([middle, high, low]) - USUAL_PITCH) / PITCH_SPREAD)


@cache
def built_in_model() -> BuiltInModel:
    """Read the model that comes with the package."""
    return read_model(files(__package__).joinpath(FILE).read_bytes(), FILE)


def read_model(content: bytes, name: str) -> BuiltInModel:
    """Decode a model.

    Raises
    ------
    ConfigError
        When the bytes are no model of voices.
    """
    arrays, wanted = decode_arrays(content, name, "a model of voices"), [field.name for field in fields(Parameters)]
    try:
        return BuiltInModel(Parameters(**{key: arrays[key].astype(np.float64) for key in wanted}))
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        raise ConfigError(f"{name}: expected a model of voices: {error}") from error


def encode_model(parameters: Parameters) -> bytes:
    """Encode a model: the large arrays of numbers as float16, the others as float32, the loadings as bytes."""
    arrays = {field.name: np.asarray(getattr(parameters, field.name), np.float32) for field in fields(parameters)}
    arrays |= {name: arrays[name].astype(np.float16) for name in HALVED}
    arrays["loadings"] = np.clip(np.round(parameters.loadings), -127, 127).astype(np.int8)
    return encode_arrays(arrays)
