"""Telemetry logs to try readers on: whole missions in a few frames, and hours of several payloads."""

import math

from fastcrc.crc16 import mcrf4xx

from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.values import (
    Alignment,
    Audio,
    CandidateState,
    Density,
    Health,
    Heartbeat,
    Phase,
    Rule,
    Separation,
    Severity,
    Source,
    Status,
    Text,
)

UNIX = 1_790_000_000_000_000  # [us]
MAVLOGDUMP = """
import runpy, sys
from pymavlink.dialects import v20
from ross_protocols.mavlink.dialect import ross
v20.ross = ross
sys.modules["pymavlink.dialects.v20.ross"] = ross
runpy.run_module("pymavlink.tools.mavlogdump", run_name="__main__")
"""  # a program that knows our dialect


def record(usec, frame):
    return int(usec).to_bytes(8, "big") + frame


def full_tick(at, step):
    """All that a payload says ten times a second when it is asked for everything, eleven frames."""
    usec, turn = round(at * 1e6), math.remainder(step / 100, 2 * math.pi)
    yield Status(usec, at, 3 + step // 300 % 4, True, heading=turn, joint=turn, k=3, score=math.sin(at), criterion=0.0)
    for index in range(3):
        where = math.remainder(2.1 * index + 0.01 * math.sin(at), 2 * math.pi)
        yield Source(usec, 1 + step // 300, index, 3, where, 0.02, 0.9, 0.3, earth=True, resolved=True)
    for index in range(2):
        yield Alignment(
            usec, 1 + step // 300, index, 2, index, turn, turn, 2e-4, (2,), Rule.GAIN, CandidateState.PLANNED, True
        )  # fmt: skip
        yield Separation(usec, 1 + step // 300, index, 2, Phase.CHECK, (index,), "auxiva", True, score=float(index))
    yield Audio(usec, level=(-30.0, -31.0), peak=(-10.0, -11.0), rate=16_000.0)
    yield Density(usec, 1 + step // 300, step // 30 % 8, turn, True, -1e-4, 1e-4, tuple([0.5] * 80))
    yield Heartbeat(Health.ACTIVE, 3) if step % 100 else Text(Severity.INFO, f"RoSS: step {step}")


def write_hour(path, seconds=3600, payloads=5, hertz=10):
    """Write the log of some payloads that say everything; return the number of frames."""
    encoders = [Encoder(system, 191) for system in range(1, payloads + 1)]
    count = 0
    with path.open("wb") as file:
        for step in range(seconds * hertz):
            at = step / hertz
            frames = [encoder.encode(value) for encoder in encoders for value in full_tick(at, step)]
            file.write(b"".join(record(UNIX + round(at * 1e6), frame) for frame in frames))
            count += len(frames)
    return count


def vehicle_frames(system=1, steps=10):
    """What an autopilot says, MAVLink 2."""
    encoder = Encoder(system, 1)
    for step in range(steps):
        yield encoder.encode(common.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3))
        yield encoder.encode(common.MAVLink_attitude_message(step * 100, 0.0, 0.0, 0.1 * step, 0.0, 0.0, 0.0))
        place = (473_977_000 + step, 85_455_000, 500_000, 10_000, 0, 0, 0, 9000)
        yield encoder.encode(common.MAVLink_global_position_int_message(step * 100, *place))


def raw_frame(number, payload, sequence=0, component=191):
    """A MAVLink 2 frame of a message with any payload, with the right checksum."""
    head = bytes([len(payload), 0, 0, sequence % 256, 1, component]) + number.to_bytes(3, "little")
    crc = mcrf4xx(head + payload + bytes([MESSAGES[number].crc_extra]))
    return b"\xfd" + head + payload + crc.to_bytes(2, "little")


def frames(steps=10, component=191, key=None):
    """Frames of a component that says everything, ten times a second."""
    encoder = Encoder(1, component, key)
    values = [value for step in range(steps) for value in full_tick(step / 10, step)]
    return [encoder.encode(value, timestamp=place) for place, value in enumerate(values)]


def log_of(these, start=UNIX, step=10_000):
    """A telemetry log of these frames, 10 ms apart."""
    return b"".join(record(start + place * step, frame) for place, frame in enumerate(these))
