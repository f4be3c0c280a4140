"""Voice prints by a network that the user adds: an ONNX file that turns filter banks into a speaker embedding.

The networks that are published for speaker verification share one form: log energies of 80 mel bands as Kaldi makes
them (16 kHz, frames of 25 ms every 10 ms, Povey window, no dither), their mean over time removed, give one vector,
and two recordings are compared by the cosine of theirs.

The built-in model errs elsewhere than a network does, and costs little: what it says is added (linear fusion of
scores).
"""

from __future__ import annotations

import hashlib
import os
import threading
from typing import Any

import numpy as np

from ross_payload.errors import ConfigError, PluginError
from ross_payload.interfaces import Real
from ross_payload.plugins import install_line
from ross_payload.voiceprint.built_in import built_in_model
from ross_payload.voiceprint.embedding_print import LEAST_SECONDS, Calibration, EmbeddingPrint, enrolled_print, unit
from ross_payload.voiceprint.features import RATE, Features

BANDS = 80
FULL_SCALE = 32768.0  # Kaldi's samples are those of 16 bits
TRIED_FRAMES = (30, 300)  # 0.3 and 3 s of noise: what a network is tried with
TRIAL_TIMEOUT_S = 30.0  # for each of them
MOST_NUMBERS = 16384  # of an embedding: published networks give up to 2048, and a print is a small file
WEIGHTS_BESIDE = "session.model_external_initializers_file_folder_path"  # of the session options of onnxruntime
PLACE_OF_WEIGHTS = b"\x0a\x08location"  # key of a tensor's `external_data` in the protocol buffer of ONNX
BUILT_IN = 0.05  # weight of what the built-in model says beside the cosine of a network


class EmbeddingModel:
    """A network as a model of voices.

    Parameters
    ----------
    content
        Of the ONNX file.
    name
        Of the file, for messages.
    calibration
        How a similarity is read.

    Raises
    ------
    ConfigError
        When a package is missing, or this is no network of that form.
    """

    def __init__(self, content: bytes, name: str, calibration: Calibration) -> None:
        self.name = name
        self.several = 0.0  # it is calibrated by several clips
        self.calibration = calibration
        self._built_in = built_in_model()
        self.fingerprint = hashlib.sha256(content + self._built_in.fingerprint.encode()).hexdigest()[:16]
        self._session, self._input, self._alone = _opened(content, name)
        told = self._session.get_modelmeta().custom_metadata_map
        self.licence: str = told.get("license", told.get("licence", ""))  # empty: the file names none
        self.size = self._alone + self._built_in.size  # numbers of an embedding, the first of them the network's

    def enrolled(self, samples: Real, features: Features, *, separated: bool) -> EmbeddingPrint:
        """Return the print of a voice (n,) at `RATE`: of its recording and, unless it was ``separated``, of copies."""
        return enrolled_print(self, samples, features.seconds, separated=separated)

    def embed(self, samples: Real) -> Real:
        """Return the embedding of a recording (n,) at `RATE`, of length 1 or, of less than 0.3 s, 0, (size,).

        It is that of the network and that of the built-in model, side by side.

        Raises
        ------
        PluginError
            When the network fails, or gives something else than finite numbers.
        """
        if len(samples) < LEAST_SECONDS * RATE:
            return np.zeros(self.size)
        return unit(np.concatenate([unit(self._run(filter_banks(samples))), self._built_in.embed(samples)]))

    def similarity(self, enrolled: Real, test: Real) -> float:
        """Return how alike two embeddings (size,) are: the cosine by the network, and what the built-in model says."""
        (enrolled, enrolled_built_in), (test, test_built_in) = (
            np.split(each, [self._alone]) for each in (enrolled, test)
        )
        cosine = float(unit(enrolled) @ unit(test))
        return cosine + BUILT_IN * self._built_in.similarity(unit(enrolled_built_in), unit(test_built_in))

    def _run(self, features: Real) -> Real:
        """Return what the network makes of filter banks (n_frames, BANDS), (n,)."""
        try:
            found = np.asarray(self._session.run(None, {self._input: features[None]})[0][0], np.float64)
        except Exception as error:  # onnxruntime has a class of its own for each way to fail
            told = str(error).partition("\n")[0]
            raise PluginError(f"{self.name}: expected an embedding of {len(features)} frames, got {told}") from error
        if found.shape != (self._alone,) or not np.isfinite(found).all():
            got = "numbers that are not finite" if found.shape == (self._alone,) else f"shape {found.shape}"
            expected = f"{self._alone} finite numbers of {len(features)} frames"
            raise PluginError(f"{self.name}: expected {expected}, got {got}")
        return found


def filter_banks(samples: Real) -> Real:
    """Return log energies of 80 mel bands, their mean over time removed, float32 (n_frames, BANDS)."""
    import kaldi_native_fbank  # noqa: PLC0415  of the extra `voice`

    options = kaldi_native_fbank.FbankOptions()
    options.frame_opts.dither = 0.0
    options.frame_opts.samp_freq = RATE
    options.mel_opts.num_bins = BANDS
    computer = kaldi_native_fbank.OnlineFbank(options)
    computer.accept_waveform(RATE, (samples * FULL_SCALE).astype(np.float32))
    computer.input_finished()
    frames = np.array([computer.get_frame(index) for index in range(computer.num_frames_ready)], np.float32)
    return np.asarray(frames - frames.mean(axis=0))


def _onnxruntime() -> Any:
    """Import onnxruntime without its telemetry to Microsoft, which begins with the import; a user may allow it."""
    os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
    import onnxruntime  # noqa: PLC0415  of the extra `voice`

    return onnxruntime


def _opened(content: bytes, name: str) -> tuple[Any, str, int]:
    """Open a network and check that it is one of speakers; returns it, the name of its input and how many numbers.

    It is tried with noise of two lengths: a network may be made for one, and zeros would hide what is not finite.
    """
    try:
        import kaldi_native_fbank  # noqa: F401, PLC0415

        onnxruntime = _onnxruntime()
    except ModuleNotFoundError as error:
        raise ConfigError(f"{name}: needs the package {error.name}: {install_line('voice')}") from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    options.add_session_config_entry(WEIGHTS_BESIDE, os.devnull)  # else those in the folder one happens to be in
    try:
        session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime has a class of its own for each way to be damaged
        told = str(error).splitlines()[0]
        if PLACE_OF_WEIGHTS in content:  # each release of onnxruntime has other words for it
            told = "its weights are in a file beside it: save it with all of them inside"
        raise ConfigError(f"{name}: expected an ONNX file: {told}") from error
    inputs, outputs = session.get_inputs(), session.get_outputs()
    shapes = ", ".join(f"{each.name} {each.shape}" for each in (*inputs, *outputs))
    if len(inputs) != 1 or len(inputs[0].shape) != len(("batch", "frames", "bands")):
        raise ConfigError(f"{name}: expected one input (batch, frames, {BANDS}), got {shapes}")
    tried = [_tried(session, name, shapes, frames) for frames in TRIED_FRAMES]
    sizes = [len(each) for each in tried]
    if len(set(sizes)) > 1:
        of = " and ".join(f"{size} of {frames} frames" for size, frames in zip(sizes, TRIED_FRAMES, strict=True))
        raise ConfigError(f"{name}: expected as many numbers of every recording, got {of}")
    if sizes[0] > MOST_NUMBERS:
        raise ConfigError(f"{name}: expected an embedding of at most {MOST_NUMBERS} numbers, got {sizes[0]}")
    if np.array_equal(tried[0], tried[1]):
        raise ConfigError(f"{name}: expected an embedding that depends on what is heard, got the same twice")
    return session, inputs[0].name, sizes[0]


def _tried(session: Any, name: str, shapes: str, frames: int) -> Real:
    """Return the embedding of so many frames of noise, (n,); a network that does not end is ended."""
    noise = np.random.default_rng(frames).standard_normal((1, frames, BANDS)).astype(np.float32)
    options = _onnxruntime().RunOptions()
    ending = threading.Timer(TRIAL_TIMEOUT_S, setattr, (options, "terminate", True))  # no signal is heard in `run`
    ending.daemon = True
    ending.start()
    try:
        inputs = {session.get_inputs()[0].name: noise - noise.mean(axis=1, keepdims=True)}
        found = np.asarray(session.run(None, inputs, options)[0])
    except Exception as error:
        if options.terminate:
            limit = f"{TRIAL_TIMEOUT_S:g} s"
            raise ConfigError(f"{name}: expected an embedding of {frames} frames within {limit}, got none") from error
        told = str(error).splitlines()[0]
        raise ConfigError(f"{name}: expected float32 (batch, frames, {BANDS}), got {shapes}: {told}") from error
    finally:
        ending.cancel()
    if found.ndim != len(("batch", "size")) or len(found) != 1 or found.dtype.kind != "f":
        raise ConfigError(f"{name}: expected one embedding (batch, size), got {shapes}")
    if not np.isfinite(found).all() or not found.any():
        got = "zeros" if np.isfinite(found).all() else "numbers that are not finite"
        raise ConfigError(f"{name}: expected an embedding of {frames} frames of noise, got {got}")
    return np.asarray(found[0], np.float64)
