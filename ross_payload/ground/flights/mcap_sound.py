"""The sound of a flight in an MCAP file: foxglove.RawAudio, a topic for each track, in blocks of a tenth of a second.

Blocks of all tracks have the same times where they overlap in a session, since their samples do.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import soundfile
from foxglove import Context
from foxglove.channels import RawAudioChannel
from foxglove.messages import RawAudio, Timestamp

from ross_payload.ground.flights.reading import Flight
from ross_payload.ground.flights.sound import Track, tracks_of

BLOCK_S = 0.1
FORMAT = "pcm-s16"
Block = tuple[float, bytes]  # when it begins in the flight [s], samples


class RecordedSound:
    """Writes the sound of a flight beside its telemetry, in the order of their times.

    Parameters
    ----------
    flight
        What is exported.
    context
        Of the library: what is open for writing.
    """

    def __init__(self, flight: Flight, context: Context) -> None:
        self._start = flight.start or 0.0
        self._tracks = [
            _Playing(track, RawAudioChannel(f"/sound/{track.name}", context=context), -self._start)
            for track in tracks_of(flight)
        ]

    def until(self, at: float) -> None:
        """Write all blocks that begin before a time in the flight [s]."""
        while due := min((each for each in self._tracks if each.next is not None), key=_begin, default=None):
            if _begin(due) >= at:
                return
            due.write(self._start)


class _Playing:
    """A track, and its next block."""

    def __init__(self, track: Track, channel: RawAudioChannel, earliest: float) -> None:
        self._track, self._channel = track, channel
        self._blocks = _blocks(track, earliest)
        self.next: Block | None = next(self._blocks, None)

    def write(self, start: float) -> None:
        """Write the next block; ``start`` is that of the flight [s]."""
        if self.next is None:
            return
        at, samples = self.next
        self.next = next(self._blocks, None)
        time = round((start + at) * 1e9)
        message = RawAudio(
            timestamp=Timestamp(sec=time // 10**9, nsec=time % 10**9),
            data=samples,
            format=FORMAT,
            sample_rate=self._track.rate,
            number_of_channels=self._track.channels,
        )
        self._channel.log(message, log_time=time)


def _begin(playing: _Playing) -> float:
    return np.inf if playing.next is None else playing.next[0]


def _blocks(track: Track, earliest: float) -> Iterator[Block]:
    """Yield a track block by block, from the ``earliest`` time on that can be written; where it is damaged it ends."""
    size = round(BLOCK_S * track.rate)
    left_out = max(math.ceil((earliest - track.begin) * track.rate), 0)
    with suppress(OSError, RuntimeError), soundfile.SoundFile(os.fsencode(track.path)) as file:
        file.seek(min(left_out, file.frames))
        for number, block in enumerate(file.blocks(size, dtype="float32", always_2d=True)):
            whole = (np.clip(block, -1, 1) * 32767).round().astype("<i2")
            yield track.begin + (left_out + number * size) / track.rate, whole.tobytes()
