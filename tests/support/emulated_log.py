"""A telemetry log of an emulated payload."""

from emulated_scene import full
from ross_protocols.mavlink.codec import Encoder

START = 1_700_000_000_000_000  # UNIX time [us]
RATE = 5  # [Hz]


def log(path, seconds=20, start=START):
    """Write a log of the first seconds; ``start`` [us] of a simulation is 0. Return its path."""
    encoder = Encoder(1, 191)
    with path.open("wb") as file:
        for tick in range(seconds * RATE):
            for said in full(tick / RATE):
                file.write((start + tick * 1_000_000 // RATE).to_bytes(8, "big") + encoder.encode(said))
    return path
