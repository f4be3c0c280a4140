"""The espeak-ng engine by ctypes, alone in a child process: ``python -m ross_sim.talkers.espeak``.

Reads one order (JSON: name, language, variant, speed, intonation, text) from its standard input and writes the rate
(32 bits) and 16-bit samples, little-endian, to its standard output. The engine keeps state from one text to the next,
so that every text gets a fresh process; it may crash without taking anything with it.
"""

from __future__ import annotations

import ctypes
import json
import struct
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

LONGEST_PATH = 120  # of the data folder; espeak-ng falls silent without an error somewhere above 160 characters

_RETRIEVAL, _NO_EXIT, _UTF8, _RATE, _RANGE = 1, 0x8000, 1, 1, 4  # of speak_lib.h


def _child() -> None:
    order = json.loads(sys.stdin.buffer.read())
    with tempfile.TemporaryDirectory(prefix="ross-") as folder:
        place = Path(folder)
        if len(folder) > LONGEST_PATH:
            raise SystemExit(f"the temporary folder has a path of {len(folder)} characters; set TMPDIR to a short one")
        _lay_out(place / "espeak-ng-data", order["name"], order["variant"])
        rate, samples = _synthesise(place, order)
    sys.stdout.buffer.write(struct.pack("<I", rate) + samples)


def _engine() -> Path:
    found = find_spec("espeakng_loader")
    if found is None or found.origin is None:
        raise SystemExit("espeakng_loader cannot be found")
    return Path(found.origin).parent


def _lay_out(data: Path, name: str, variant: str) -> None:
    """Make a data folder with a short path: links to the engine's data, and our variant."""
    variants = data / "voices" / "!v"
    variants.mkdir(parents=True)
    for entry in (_engine() / "espeak-ng-data").iterdir():
        if entry.name != "voices":
            (data / entry.name).symlink_to(entry)
    (variants / name).write_text(variant, encoding="ascii")


def _synthesise(place: Path, order: dict[str, Any]) -> tuple[int, bytes]:
    library = ctypes.CDLL(str(next(_engine().glob("libespeak-ng.so"))))
    rate = library.espeak_Initialize(_RETRIEVAL, 200, str(place).encode(), _NO_EXIT)
    heard = bytearray()

    def on_samples(samples: int | None, count: int, _events: int | None) -> int:
        if samples:
            heard.extend(ctypes.string_at(samples, 2 * count))
        return 0

    callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)(on_samples)
    library.espeak_SetSynthCallback(callback)
    name = f"{order['language']}+{order['name']}"
    if rate <= 0 or library.espeak_SetVoiceByName(name.encode()) != 0:
        raise SystemExit(f"espeak-ng does not know the voice {name} (rate {rate})")
    library.espeak_SetParameter(_RATE, order["speed"], 0)
    library.espeak_SetParameter(_RANGE, order["intonation"], 0)
    content = order["text"].encode()
    library.espeak_Synth.argtypes = [ctypes.c_char_p, ctypes.c_size_t, *[ctypes.c_uint] * 4, *[ctypes.c_void_p] * 2]
    if library.espeak_Synth(content, len(content) + 1, 0, 1, 0, _UTF8, None, None) != 0:
        raise SystemExit("espeak-ng refuses to speak")
    library.espeak_Synchronize()
    return int(rate), bytes(heard)


if __name__ == "__main__":
    _child()
