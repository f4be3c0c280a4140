"""Opus to samples, by libopus: also what a packet says of the one before it (in-band FEC), and what it leaves open.

FFmpeg's decoders, and so PyAV, give neither FEC nor concealment of lost packets (RFC 6716, section 4.4). The library
they use does: the one that came with PyAV, or else the system's.
"""

from __future__ import annotations

import contextlib
import ctypes
import ctypes.util
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, files

import numpy as np

from ross_payload.errors import ConfigError
from ross_payload.interfaces import Samples
from ross_payload.plugins import install_line

LONGEST_S = 0.12  # of sound in a packet, RFC 6716
_FLOATS = ctypes.POINTER(ctypes.c_float)


class OpusDecoder:
    """One stream of Opus, mono.

    Parameters
    ----------
    rate
        Of the samples [Hz]: one that Opus knows.

    Raises
    ------
    ConfigError
        When there is no libopus.
    """

    def __init__(self, rate: int) -> None:
        self._library = _libopus()
        error = ctypes.c_int()
        self._state = self._library.opus_decoder_create(rate, 1, ctypes.byref(error))
        if not self._state:
            raise ConfigError(f"Opus: expected a rate of 8, 12, 16, 24 or 48 kHz, got {rate} Hz")
        self._has_lbrr = getattr(self._library, "opus_packet_has_lbrr", None)  # since libopus 1.5
        self._rate = rate

    def __del__(self) -> None:
        if getattr(self, "_state", None):
            self._library.opus_decoder_destroy(self._state)

    def decode(self, payload: bytes) -> Samples:
        """Return the samples of a packet, (n,).

        Raises
        ------
        ValueError
            When it is no packet of Opus.
        """
        return self._decode(payload, round(LONGEST_S * self._rate), False)

    def recover(self, after: bytes, n: int) -> Samples:
        """Return the ``n`` samples before a packet, (n,), from its FEC, or concealed when it has none.

        Raises
        ------
        ValueError
            When it is no packet of Opus.
        """
        return self._decode(after, n, True)

    def conceal(self, n: int) -> Samples:
        """Return ``n`` samples, (n,), in place of what was lost: like what was before, and ever softer."""
        whole = -(-n // (step := self._rate // 400)) * step  # libopus counts in 2.5 ms
        return self._decode(None, whole, True)[:n]

    def has_fec(self, after: bytes) -> bool:
        """Tell whether a packet repeats the one before it."""
        return self._has_lbrr is not None and int(self._has_lbrr(after, len(after))) == 1

    def _decode(self, payload: bytes | None, n: int, fec: bool) -> Samples:
        samples = np.zeros(n, np.float32)
        size = len(payload) if payload is not None else 0
        if payload is not None and not payload:
            raise ValueError("an empty packet")  # libopus would take it for a lost one
        count = self._library.opus_decode_float(
            self._state, payload, size, samples.ctypes.data_as(_FLOATS), n, int(fec and payload is not None)
        )
        if count < 0:
            raise ValueError(f"no packet of Opus: error {count} of libopus")
        return samples[:count]


def _candidates() -> Iterator[str]:
    with contextlib.suppress(PackageNotFoundError):
        yield from (str(file.locate()) for file in files("av") or () if file.name.startswith("libopus"))
    yield ctypes.util.find_library("opus") or "libopus.so.0"


def _libopus() -> ctypes.CDLL:
    for name in _candidates():
        try:
            library = ctypes.CDLL(name)
            library.opus_decoder_create.restype = ctypes.c_void_p
            library.opus_decoder_create.argtypes = [ctypes.c_int32, ctypes.c_int, ctypes.POINTER(ctypes.c_int)]
            library.opus_decoder_destroy.argtypes = [ctypes.c_void_p]
            library.opus_decode_float.argtypes = [
                *(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int32),
                *(_FLOATS, ctypes.c_int, ctypes.c_int),
            ]
        except (OSError, AttributeError):
            continue
        return library
    raise ConfigError(f"Opus needs libopus: {install_line('stream')}")
