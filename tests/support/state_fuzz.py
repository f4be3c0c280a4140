"""A state folder as a dying disk or somebody who means harm leaves it: one thing in it spoilt, by a seed."""

import os
import shutil
import socket
from pathlib import Path

PRINT = "data/ross/voices/ann.json"
SESSION = "state/recordings/0001"
NAMED = ("state/params.toml", "state/signing-time", "state/dronecan.json", f"{SESSION}/session.json", PRINT)
FILES = (
    *NAMED, "state/stopped", f"{SESSION}/inputs.jsonl", f"{SESSION}/audio.wav", f"{SESSION}/events.jsonl",
    f"{SESSION}/config.json",
    "state/recordings", "state/recordings/0002", "state/recordings/pipe",
)  # fmt: skip
DEPTH = 100_000


def fill(path, data):
    path.write_bytes(data)


def listening(path):
    with socket.socket(socket.AF_UNIX) as server:
        here = Path.cwd()
        os.chdir(path.parent)  # the name of a socket has 107 bytes at most
        try:
            server.bind(path.name)
        finally:
            os.chdir(here)


RUINED = {  # whatever file it is, it cannot be used afterwards
    "named pipe": lambda path, data, rng: os.mkfifo(path),
    "socket": lambda path, data, rng: listening(path),
    "folder": lambda path, data, rng: path.mkdir(),
    "nested lists": lambda path, data, rng: fill(path, b"a = " * (path.suffix == ".toml") + b"[" * DEPTH),
    "nested tables": lambda path, data, rng: fill(path, b'{"a":' * DEPTH),
    "dotted key": lambda path, data, rng: fill(path, b"a." * 20_000 + b"a = 1"),
    "closed nest": lambda path, data, rng: fill(path, b"[" * 900 + b"]" * 900),
    "huge": lambda path, data, rng: fill(path, b"7" * 20_000_000),
    "5,000 digits": lambda path, data, rng: fill(path, b"version = " * (path.suffix == ".toml") + b"9" * 5000),
    "noise": lambda path, data, rng: fill(path, b"\xff" + rng.bytes(500)),
}
DOUBTFUL = {  # it may be good afterwards
    "empty": lambda path, data, rng: fill(path, b""),
    "zeros": lambda path, data, rng: fill(path, bytes(len(data))),
    "cut": lambda path, data, rng: fill(path, data[: rng.integers(len(data) + 1)]),
    "flipped": lambda path, data, rng: fill(path, flipped(data, rng)),
    "doubled": lambda path, data, rng: fill(path, data + data),
    "loop": lambda path, data, rng: path.symlink_to(path.name),
    "link to nothing": lambda path, data, rng: path.symlink_to("nowhere"),
    "escapes": lambda path, data, rng: fill(path, b'version = 1\n[parameters]\n"\\u001b[2J" = 1\n'),
    "not finite": lambda path, data, rng: fill(path, data.replace(b"1", b"1e999").replace(b"0.", b"-inf")),
}


def flipped(data, rng):
    """A few bits of it are others."""
    spoilt = bytearray(data)
    for place in rng.integers(len(data), size=3) if data else ():
        spoilt[place] ^= 1 << rng.integers(8)
    return bytes(spoilt)


def drawn(rng):
    """A name and a kind."""
    return str(rng.choice(FILES)), str(rng.choice(list(RUINED | DOUBTFUL)))


def spoil(folder, name, kind, rng):
    """Spoil one thing of a folder in one way; returns its path."""
    path = folder / name
    data = path.read_bytes() if path.is_file() else b""
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    (RUINED | DOUBTFUL)[kind](path, data, rng)
    return path
