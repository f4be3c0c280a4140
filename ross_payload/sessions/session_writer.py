"""One session on its way to the disk; what `flush` has returned from survives the death of the process."""

from __future__ import annotations

import fcntl
import json
from collections import deque
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from ross_payload.atomic_files import append, create
from ross_payload.audio.track_files import AlignedTrack
from ross_payload.audio.wav_files import MOST, WIDTH, WavFile, exact
from ross_payload.events import Event
from ross_payload.interfaces import Input, Samples, Score, VoiceBlock
from ross_payload.sessions import event_json, input_log, manifest
from ross_payload.sessions.manifest import Beginning
from ross_payload.transport.tlog import TlogRecorder

FLUSH_PERIOD_S = 0.5  # [s] of audio that wait at most
AT_ONCE_S = 2.0  # of silence before a voice: hours of it would hold up everything else


class SessionWriter:
    """Writes one session folder; every method may raise OSError, and OutputError from the telemetry log."""

    def __init__(self, folder: Path, begin: Beginning, started: str) -> None:
        self.folder = folder
        self._begin = begin
        self._started = started
        self._rate = begin.config.audio.rate_hz
        self._waiting: list[Input] = []
        self._pending = 0  # samples waiting
        self._samples = 0  # written
        self._first: int | None = None  # index of the first sample
        self._voices: dict[str, VoiceTrack] = {}
        with ExitStack() as stack:
            self._inputs = stack.enter_context(create(folder / "inputs.jsonl"))
            fcntl.flock(self._inputs, fcntl.LOCK_EX)  # before it is a session, which another payload may delete
            manifest.write(folder, begin, started)
            self._events = stack.enter_context(create(folder / "events.jsonl"))
            self._scores = stack.enter_context(create(folder / "scores.jsonl"))
            self._audio = WavFile(folder / "audio.wav", self._rate)
            stack.callback(self._audio.close)
            (folder / "telemetry.tlog").touch(mode=0o600)
            self._tlog = stack.enter_context(TlogRecorder(folder / "telemetry.tlog"))
            self._open = stack.pop_all()

    @property
    def seconds(self) -> float:
        """Recorded so far [s]."""
        return (self._samples + self._pending) / self._rate

    @property
    def over(self) -> bool:
        """Whether the audio file is as long as a WAV file may be."""
        return self._audio.bytes > MOST - 2 * WIDTH * self._rate

    def write_input(self, hop: Input) -> None:
        """Take one Input."""
        if self._first is None:
            self._first = hop.block.index
        self._waiting.append(hop)
        self._pending += hop.block.samples.shape[1]
        if self._pending >= FLUSH_PERIOD_S * self._rate:
            self.flush()

    def write_event(self, event: Event) -> None:
        """Write what the mission has said."""
        append(self._events, event_json.line(event).encode())

    def write_voice(self, name: str, block: VoiceBlock) -> None:
        """Write samples of a voice to NAME.flac, where each has the place that it has in audio.wav."""
        if self._first is None:
            return
        if name not in self._voices:
            track = self._voices[name] = VoiceTrack(self.folder / f"{name}.flac", self._rate)
            self._open.callback(track.close)
        self._voices[name].write(block.index - self._first, block.samples)

    def write_score(self, number: int, score: Score) -> None:
        """Write what the voice print has answered after ``number`` Inputs."""
        values = {"input": number, "value": float(score.value), "accepted": bool(score.accepted)}
        append(self._scores, (json.dumps(values) + "\n").encode())

    def write_frame(self, time_usec: int, frame: bytes) -> None:
        """Write a frame of telemetry."""
        self._tlog.write(time_usec, frame)

    def flush(self) -> None:
        """Write what waits: the audio first, so that every Input on the disk has its samples there."""
        if not self._waiting:
            return
        waiting, self._waiting, self._pending = self._waiting, [], 0
        blocks = [_recorded(heard) for heard in waiting]
        self._audio.write(np.concatenate(blocks, axis=1))
        self._samples += sum(block.shape[1] for block in blocks)
        lines = (input_log.line(heard, exact=exact(block)) for heard, block in zip(waiting, blocks, strict=True))
        append(self._inputs, "".join(lines).encode())

    def finish(self, reason: str) -> None:
        """Write what waits, say that this is the end, and close everything."""
        try:
            self.flush()
            manifest.write_manifest(self.folder, self._begin, self._started, reason)
        finally:
            self.close()

    def close(self) -> None:
        """Close everything as it is; idempotent."""
        self._open.close()


class VoiceTrack:
    """An aligned track whose silence before a voice that begins late is written little by little, as the voice comes.

    Parameters
    ----------
    path, rate
        As of `AlignedTrack`.
    """

    def __init__(self, path: Path, rate: int) -> None:
        self._track = AlignedTrack(path, rate)
        self._at_once = round(AT_ONCE_S * rate)
        self._waiting: deque[tuple[int, Samples]] = deque()  # places, and what belongs there

    def write(self, place: int, samples: Samples) -> None:
        """Write samples (n,) at their place, or keep them until there is silence before them."""
        self._waiting.append((place, samples))
        self._advance(self._track.length + self._at_once)

    def close(self) -> None:
        """Write what waits and close; idempotent."""
        try:
            while self._waiting:
                self._advance(self._waiting[0][0])
        finally:
            self._waiting.clear()
            self._track.close()

    def _advance(self, furthest: int) -> None:
        while self._waiting:
            place, samples = self._waiting[0]
            if place > furthest:
                self._track.write(furthest, samples[:0])
                return
            self._track.write(place, samples)
            self._waiting.popleft()


def _recorded(hop: Input) -> Samples:
    """What came from the microphones, before all corrections."""
    return hop.block.samples if hop.block.raw is None else hop.block.raw
