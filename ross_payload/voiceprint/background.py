"""The background model: what voices in general are like, and how much one voice varies.

A recording becomes a point: the means of its frames under a Gaussian mixture that was trained on many voices (first
order statistics, shrunk as in Reynolds, Quatieri and Dunn, "Speaker verification using adapted Gaussian mixture
models", Digital Signal Processing 10 (2000)), and quantiles of its pitch, projected onto the directions in which
voices differ most compared with how much one voice varies (linear discriminant analysis). Two points are compared by
the log-likelihood ratio of the two-covariance model (Brümmer and de Villiers, "The speaker partitioning problem",
Odyssey 2010).
"""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass, fields
from importlib.resources import files

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real
from ross_payload.voiceprint.features import Features

PITCH_QUANTILES = (10.0, 25.0, 50.0, 75.0, 90.0)  # [%]


@dataclass(frozen=True, slots=True)
class Background:
    """Parameters of the background model."""

    weights: Real  # of the Gaussians, (n_gaussians,)
    means: Real  # (n_gaussians, n_cepstra)
    deviations: Real  # (n_gaussians, n_cepstra)
    relevance: Real  # frames a Gaussian needs before its mean is believed by half, ()
    centre: Real  # mean point before projection, (n_gaussians * n_cepstra + n_quantiles,)
    projection: Real  # (n_gaussians * n_cepstra + n_quantiles, n_dimensions)
    between: Real  # variance between voices where that within a voice is 1, (n_dimensions,)
    calibration: Real  # slope and offset from model score to nat, (2,)

    @property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that tell this model from another."""
        digest = hashlib.sha256()
        for field in fields(self):
            digest.update(np.ascontiguousarray(getattr(self, field.name), dtype="<f4").tobytes())
        return digest.hexdigest()[:16]

    def point(self, features: Features) -> Real:
        """Return the point (n_dimensions,) of a recording."""
        return np.asarray((self.statistics(features) - self.centre) @ self.projection)

    def statistics(self, features: Features) -> Real:
        """Return shrunk, whitened means per Gaussian and pitch quantiles, (n_gaussians * n_cepstra + n_quantiles,)."""
        deviation = (features.cepstra[:, None] - self.means) / self.deviations
        exponent = np.log(self.weights) - np.log(self.deviations).sum(axis=1) - (deviation**2).sum(axis=2) / 2
        posterior = np.exp(exponent - exponent.max(axis=1, keepdims=True))
        posterior /= posterior.sum(axis=1, keepdims=True)
        shrunk = np.einsum("tc,tcd->cd", posterior, deviation) / (posterior.sum(axis=0) + self.relevance)[:, None]
        quantiles = np.percentile(features.pitch, PITCH_QUANTILES)
        return np.concatenate([(np.sqrt(self.weights)[:, None] * shrunk).ravel(), quantiles])

    def compare(self, enrolled: Real, heard: Real) -> float:
        """Return the calibrated log-likelihood ratio [nat] that two points are one voice rather than two.

        With variances b between and 1 within: both points are N(0, b + 1), and of one voice their covariance is b.
        """
        total, shared = self.between + 1, self.between
        determinant = total**2 - shared**2
        quadratic = (total * (enrolled**2 + heard**2) - 2 * shared * enrolled * heard) / determinant
        same = np.log(determinant) + quadratic
        different = 2 * np.log(total) + (enrolled**2 + heard**2) / total
        slope, offset = self.calibration
        return float(slope * np.sum(different - same) / 2 + offset)


def shipped_background() -> Background:
    """Read the background model that comes with the package."""
    return read_background(files(__package__).joinpath("background.npz").read_bytes(), "background.npz")


def read_background(content: bytes, name: str) -> Background:
    """Decode a background model.

    Raises
    ------
    ConfigError
        When the bytes are no background model.
    """
    wanted = [field.name for field in fields(Background)]
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return Background(**{key: arrays[key].astype(np.float64) for key in wanted})
    except Exception as error:  # zipfile, zlib and numpy each have their own way to fail on damaged bytes
        raise ConfigError(f"{name}: not a background model of voices: {error}") from error
