"""How the microphones and the recorder are: plain values that cross from them to telemetry, the log and the doctor."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag, StrEnum

DEAD_DB = 30.0  # so far is a dead microphone below the other; talkers and rooms make a few
DEAD_FROM_HZ = 400.0  # where they are compared: below it hum and wind may be far louder at one of them
ALIKE = 1e-6  # share of power in which two channels of one microphone may differ: every microphone has its own noise
QUIET_DB = -80.0  # below it two channels may be alike by rounding [dB re full scale]


def are_identical(first: float, second: float, product: float) -> bool:
    """Whether two channels are one microphone, as loud or not: by their powers and the mean of their product.

    >>> are_identical(1.0, 0.25, 0.5), are_identical(1.0, 0.25, 0.499)
    (True, False)
    """
    loud = min(first, second) > 10 ** (QUIET_DB / 10)
    return loud and 1 - product**2 / (first * second) < ALIKE


class AudioTrouble(IntFlag):
    """What is wrong with the microphones."""

    NONE = 0
    CLIPPING = 1  # samples at full scale within the last second
    DEAD_1 = 2  # microphone 1 gives digital silence, or far less than the other
    DEAD_2 = 4
    OFFSET = 8  # a constant part (DC) far above the noise
    IDENTICAL = 16  # both channels are one microphone
    INVERTED = 32  # one of them has the wrong polarity
    LOST = 64  # samples were lost within the last 10 s
    ABSENT = 128  # no audio arrives


@dataclass(frozen=True, slots=True)
class AudioHealth:
    """The microphones at one moment; levels are re full scale, over the last second."""

    trouble: AudioTrouble = AudioTrouble.NONE
    level_db: tuple[float, float] = (-120.0, -120.0)  # of microphones 1 and 2
    peak_db: tuple[float, float] = (-120.0, -120.0)
    lost: int = 0  # samples since the source was opened
    reopened: int = 0  # times since start
    waiting: float = 0.0  # audio heard but not yet used [s]
    rate: float | None = None  # of the samples, measured against the Clock [Hz]


class RecordingState(StrEnum):
    """What the recorder does."""

    OFF = "off"
    ON = "on"
    FULL = "full"  # stopped: the disk or its share is full
    BROKEN = "broken"  # stopped: the disk is gone


@dataclass(frozen=True, slots=True)
class RecordingStatus:
    """The recorder at one moment."""

    state: RecordingState = RecordingState.OFF
    name: str = ""  # of the session folder
    seconds: float = 0.0  # recorded in this session
    free_gb: float | None = None  # left on the disk
    reason: str = ""  # why it is full or broken
    path: str = ""  # of the session folder, on the payload's disk
