"""The background model: what voices in general are like.

A Gaussian mixture over the frames of many voices, adapted to one voice by moving its means (maximum a posteriori, as
in Reynolds, Quatieri and Dunn, "Speaker verification using adapted Gaussian mixture models", Digital Signal
Processing 10 (2000)); the same for the logarithm of the pitch, where the weights are adapted. How much a recording
sounds like a voice is the gain in log-likelihood per frame over the nearest of a cohort of other voices (as in
Auckenthaler, Carey and Lloyd-Thomas, "Score normalization for text-independent speaker verification systems", ibid.).
Logistic regression turns this and the pitch into a log-likelihood ratio.
"""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Real, Score
from ross_payload.voiceprint.features import Features, analyse

COHORT_STEP = 1 / 64  # of the offsets of the cohort, which are kept as bytes [standard deviations]
RIVALS = 3  # of the cohort, the nearest to the recording, are what the enrolled voice must beat
ENOUGH = (
    0.5  # gain by spectrum beyond which more of it says little: two synthetic voices may differ by their pitch alone
)
PITCH_RELEVANCE = 20.0  # frames of pitch that the background counts for
HALF_TIME = 1.0  # voiced speech after which half of the evidence is believed [s]
SCORE_SECONDS = 0.3  # with less voiced speech a recording tells nothing [s]
SEPARATED_CRITERION = 4.0  # [nat]: what a separator leaves of one voice is like what it leaves of another


@dataclass(frozen=True, slots=True)
class Adapted:
    """The background model adapted to one voice."""

    offsets: Real  # of the means, in standard deviations, (n_gaussians, n_features)
    pitch_weights: Real  # (n_pitches,)


@dataclass(frozen=True, slots=True)
class Background:
    """Parameters of the background model."""

    weights: Real  # of the Gaussians, (n_gaussians,)
    means: Real  # (n_gaussians, n_features)
    deviations: Real  # (n_gaussians, n_features)
    pitch_weights: Real  # (n_pitches,)
    pitch_means: Real  # of the logarithm of F0 / 1 Hz, (n_pitches,)
    pitch_deviations: Real  # (n_pitches,)
    relevance: Real  # frames a Gaussian needs before its mean moves by half, ()
    cohort: Real  # offsets of other voices in COHORT_STEP, (n_voices, n_gaussians, n_features)
    calibration: Real  # nat per unit of evidence of the spectrum and of the pitch, and offset, (3,)

    @property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that tell this model from another."""
        digest = hashlib.sha256()
        for each in fields(self):
            digest.update(np.ascontiguousarray(getattr(self, each.name), dtype="<f4").tobytes())
        return digest.hexdigest()[:16]

    def enrolled(self, samples: Real, features: Features, *, separated: bool) -> VoicePrintModel:
        """Return the print of a voice; one that was ``separated`` from others is compared with separated ones alone."""
        criterion = SEPARATED_CRITERION if separated else 0.0
        return VoicePrintModel(self.adapt(features), features.seconds, self, criterion)

    def restored(self, values: dict[str, Any], seconds: float, consent: str) -> VoicePrintModel:
        """Make a print again from its `VoicePrintModel.values`.

        Raises
        ------
        ValueError
            When they are not those of a print of this model.
        """
        offsets, pitch, criterion = (
            np.array(values[name], dtype=np.float64) for name in ("offsets", "pitch_weights", "criterion")
        )
        if offsets.shape != self.means.shape or pitch.shape != self.pitch_weights.shape or criterion.shape:
            raise ValueError(
                f"expected {self.means.size} + {self.pitch_weights.size} numbers, got {offsets.size} + {pitch.size}"
            )
        if not all(np.isfinite(each).all() for each in (offsets, pitch, criterion)) or (pitch < 0).any():
            raise ValueError("not finite, or negative weights")
        return VoicePrintModel(Adapted(offsets, pitch), seconds, self, float(criterion), consent)

    def adapt(self, features: Features) -> Adapted:
        """Adapt the model to a voice: mean <- (sum_t p_t x_t + r mean) / (sum_t p_t + r)."""
        exponent = self._exponents(features, np.zeros((1, *self.means.shape)))[:, 0]
        posterior = np.exp(exponent - np.logaddexp.reduce(exponent, axis=1)[:, None])
        deviation = np.einsum("tc,td->cd", posterior, features.cepstra) - posterior.sum(axis=0)[:, None] * self.means
        offsets = deviation / self.deviations / (posterior.sum(axis=0) + self.relevance)[:, None]
        likelihood = self._pitch_likelihoods(features) * self.pitch_weights
        count = (likelihood / likelihood.sum(axis=1, keepdims=True)).sum(axis=0) + PITCH_RELEVANCE * self.pitch_weights
        return Adapted(offsets, count / count.sum())

    def evidence(self, voice: Adapted, features: Features) -> Real:
        """Return what speaks for a voice: its gains in log-likelihood per frame by spectrum and by pitch, (2,).

        By spectrum over the nearest of the cohort, g, bounded to E tanh(g / E) with E = ENOUGH; by pitch over the
        background.
        """
        everyone = np.concatenate([voice.offsets[None], self.cohort * COHORT_STEP])
        exponents = self._exponents(features, everyone)
        top = exponents.max(axis=2)
        likelihood = (top + np.log(np.exp(exponents - top[:, :, None]).sum(axis=2))).mean(axis=0)
        gain = likelihood[0] - np.sort(likelihood[1:])[-RIVALS:].mean()
        pitch = self._pitch_likelihoods(features)
        pitch_gain = np.log(pitch @ voice.pitch_weights / (pitch @ self.pitch_weights)).mean()
        return np.array([ENOUGH * np.tanh(gain / ENOUGH), pitch_gain])

    def compare(self, voice: Adapted, features: Features) -> float:
        """Return the calibrated log-likelihood ratio [nat] that a recording is of a voice; 0 without voiced speech."""
        believed = reliability(features)
        if not believed:
            return 0.0
        return float(believed * (self.calibration[:2] @ self.evidence(voice, features) + self.calibration[2]))

    def _exponents(self, features: Features, offsets: Real) -> Real:
        """Return ln w_c N(x_t; mean_vc, deviation_c) but for a constant, float32 (n_frames, n_voices, n_gaussians)."""
        frames = features.cepstra.astype(np.float32)
        means = self.means / self.deviations + offsets
        constant = np.log(self.weights) - np.log(self.deviations).sum(axis=1) - (means**2).sum(axis=2) / 2
        slopes = np.asarray(means / self.deviations, np.float32).reshape(-1, self.means.shape[1])
        common = frames**2 @ np.asarray(0.5 / self.deviations.T**2, np.float32)
        linear = (frames @ slopes.T).reshape(len(frames), *means.shape[:2])
        return np.asarray(linear + constant.astype(np.float32) - common[:, None])

    def _pitch_likelihoods(self, features: Features) -> Real:
        deviation = (features.pitch[:, None] - self.pitch_means) / self.pitch_deviations
        return np.asarray(np.exp(-(deviation**2) / 2) / self.pitch_deviations + np.finfo(float).tiny)


@dataclass(frozen=True, slots=True)
class VoicePrintModel:
    """One enrolled voice, an ``interfaces.VoicePrint``, by the built-in model."""

    voice: Adapted
    seconds: float  # voiced speech that it was enrolled from [s]
    background: Background = field(repr=False)
    criterion: float = 0.0  # evidence [nat] at which this print is undecided
    consent: str = ""  # how the talker agreed, in words; empty: the file does not say

    def score(self, voice: Real, rate: int) -> Score:
        """Compare a recording (n_samples,) at ``rate`` [Hz] with the enrolled voice.

        A recording with hardly any voiced speech has the score 0, undecided, and is not accepted.

        Raises
        ------
        AudioError
            When the recording is empty, not one channel, not finite, or sampled below 16 kHz.
        """
        features = analyse(voice, rate)
        if features.seconds < SCORE_SECONDS:
            return Score(0.0, accepted=False)
        value = self.background.compare(self.voice, features) - self.criterion
        return Score(value, accepted=value > 0.0)

    @property
    def fingerprint(self) -> str:
        """Of the model that made it."""
        return self.background.fingerprint

    def agreed(self, consent: str) -> VoicePrintModel:
        """Return the same with how the talker agreed."""
        return replace(self, consent=consent)

    def values(self) -> dict[str, Any]:
        """Return what a file keeps, ready for JSON."""
        return {
            "criterion": self.criterion,
            "offsets": np.round(self.voice.offsets, 4).tolist(),
            "pitch_weights": np.round(self.voice.pitch_weights, 6).tolist(),
        }


def reliability(features: Features) -> float:
    """Return how much of the evidence is believed: s / (s + 1 s) after s seconds of voiced speech."""
    return features.seconds / (features.seconds + HALF_TIME)


@cache
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
        raise ConfigError(f"{name}: expected a background model of voices: {error}") from error


def encode_background(background: Background) -> bytes:
    """Encode a background model: numbers as float32, the cohort as bytes."""
    arrays = {field.name: getattr(background, field.name).astype(np.float32) for field in fields(background)}
    arrays["cohort"] = np.clip(np.round(background.cohort), -127, 127).astype(np.int8)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()
