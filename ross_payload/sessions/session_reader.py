"""Read a session folder, also one that was cut off: what is there is read, what is missing is said."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from ross_payload.audio.audio_files import check_audio
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.wav_files import WavReader
from ross_payload.bounded_files import MB, open_regular, parsed_json, read_bounded
from ross_payload.config import Audio, Config, validated
from ross_payload.errors import AudioError, ConfigError, refused_as
from ross_payload.interfaces import AudioFlag, Input, Score
from ross_payload.json_values import are_finite
from ross_payload.sessions import input_log, manifest
from ross_payload.sessions.manifest import Manifest
from ross_payload.sessions.npz_memory import unpacked
from ross_payload.sessions.session_store import FILES, is_running

T = TypeVar("T")
LONGEST = 16 * MB  # line [bytes]: an event carries a density for every direction, never the samples


@dataclass(frozen=True, slots=True)
class Contents:
    """What is in a session folder, and what is wrong with it."""

    inputs: int = 0
    seconds: float = 0.0  # of the Inputs
    audio: float = 0.0  # of the samples [s]
    orders: int = 0
    events: int = 0
    lost: int = 0  # samples that were left out
    missing: float = 0.0  # of the Inputs, those in which zeros stand for samples that never came [s]
    rounded: bool = False  # 24 bits did not hold every sample
    notes: tuple[str, ...] = ()  # one line each; empty: whole


@dataclass(frozen=True, slots=True)
class _NoField:
    """Of a file of which only the directory is read."""


@dataclass(frozen=True, slots=True)
class RecordedSession:
    """A session folder, opened."""

    path: Path
    manifest: Manifest

    @classmethod
    def open(cls, path: Path) -> RecordedSession:
        """Open a session folder.

        Raises
        ------
        ConfigError
            When it is none, or says too little.
        """
        return cls(path, manifest.read(path))

    def configuration(self) -> Config:
        """Return the configuration that was in force.

        Raises
        ------
        ConfigError
            When it is missing, damaged, or of another version.
        """
        path = self.path / "config.json"
        try:
            values = parsed_json(read_bounded(path))
        except (OSError, ValueError) as error:
            raise ConfigError(f"{path}: the configuration of this session cannot be read: {error}") from error
        if isinstance(values, dict) and isinstance(values.get("exploit"), dict):
            values["exploit"].setdefault("track", False)  # recorded before talkers who move were followed
        return validated(Config, values, str(path))

    def memory(self, kind: type[T]) -> T | None:
        """Return what the session knew at its beginning; None when it knew nothing."""
        path = self.path / "memory.npz"
        return unpacked(path, kind) if path.exists() else None

    def inputs(self, audio: Audio, *, wire_everywhere: bool = False) -> Iterator[Input]:
        """Read the Inputs up to the first that is damaged or has no samples.

        Gain, polarity and roll-off of ``audio`` are corrected in what the source corrected when it was recorded, and
        in everything with ``wire_everywhere``.

        Raises
        ------
        ConfigError
            When there is no audio, or an order is unknown to this program.
        """
        wav, start = self._audio(), 0
        correction = ChannelMap.of(audio).correction(wav.rate)
        for values in input_log.completed(self.lines(), wav.rate):
            raw = wav.read(start, values["n"])
            start += values["n"]
            if raw.shape[1] < values["n"]:
                return
            wired = wire_everywhere or bool(values.get("raw"))
            if not wire_everywhere and "carried" in values:  # it began in mid-stream, or left something out
                correction.resume(values["carried"])
            yield input_log.input_of(values, correction.apply(raw).samples if wired else raw, raw if wired else None)

    def lines(self) -> Iterator[dict[str, Any]]:
        """Read the Inputs as they stand, without samples, up to the first that is damaged."""
        for text in _lines(self.path / "inputs.jsonl"):
            values = input_log.parsed(text)
            if values is None:
                return
            yield values

    def events(self) -> list[str]:
        """Return the lines of events.jsonl up to the first that is damaged."""
        found = []
        for text in _lines(self.path / "events.jsonl"):
            if not text.endswith(b"\n") or not _is_event(text):
                break
            found.append(text.decode("utf-8"))
        return found

    def scores(self) -> list[tuple[int, Score]]:
        """Return what the voice print has answered, each after how many Inputs."""
        found = []
        for text in _lines(self.path / "scores.jsonl"):
            try:
                values = parsed_json(text)
                found.append((int(values["input"]), Score(float(values["value"]), bool(values["accepted"]))))
            except (ValueError, KeyError, TypeError, OverflowError):
                break
        return found

    def contents(self) -> Contents:
        """Read everything once."""
        found = Contents(events=len(self.events()))
        samples, missing, rate = 0, 0, self.rate()
        for values in self.lines():
            samples += values["n"]
            missing += values["n"] if AudioFlag(values.get("flags", 0)) & AudioFlag.MISSING else 0
            found = replace(
                found,
                inputs=found.inputs + 1,
                orders=found.orders + len(values.get("orders", ())),
                lost=found.lost + values.get("lost", 0),
                rounded=found.rounded or bool(values.get("rounded")),
            )
        length = self.audio_length()
        notes = tuple(self._notes(found, samples, length))
        return replace(found, seconds=samples / rate, missing=missing / rate, audio=length / rate, notes=notes)

    def rate(self) -> int:
        """Return the sampling rate [Hz] of the audio file; 16000 when there is none."""
        try:
            return self._audio().rate
        except ConfigError:
            return 16_000

    def audio_length(self) -> int:
        """Return how many samples there are."""
        try:
            return self._audio().length
        except ConfigError:
            return 0

    def _audio(self) -> WavReader:
        return WavReader(self.path / "audio.wav")

    def _unreadable(self) -> Iterator[str]:
        for name in ("config.json", "events.jsonl", "audio.wav", "inputs.jsonl"):
            if not (self.path / name).is_file():
                yield f"{name}: missing"
        readers: dict[str, Callable[[], object]] = {
            "config.json": self.configuration,
            "memory.npz": lambda: unpacked(self.path / "memory.npz", _NoField, others=True),
            "voice.npz": lambda: unpacked(self.path / "voice.npz", _NoField, others=True),
            "audio.wav": self._audio,
        }
        if not is_running(self.path):  # the first samples of a voice may be on their way
            readers |= {name: partial(check_audio, self.path / name) for name in FILES if name.endswith(".flac")}
        for name, read in readers.items():
            if (self.path / name).is_file():
                try:
                    read()
                except (ConfigError, AudioError) as error:
                    yield str(error).removeprefix(f"{self.path}{os.sep}")

    def _notes(self, found: Contents, samples: int, length: int) -> Iterator[str]:
        known, rate = self.manifest, self.rate()
        if known.version != manifest.VERSION:
            yield f"session.json: expected version {manifest.VERSION}, got {known.version}: read as far as it goes"
        if known.end is None and is_running(self.path):
            yield "being recorded: read as far as it has come"
        elif known.end is None:
            yield "cut off: its end was not recorded; at most the last second is missing, after a power cut some 30 s"
        files = {"inputs.jsonl": found.inputs, "events.jsonl": found.events, "scores.jsonl": len(self.scores())}
        for name, read in files.items():
            lines = sum(1 for _ in _lines(self.path / name))
            if lines > read:
                yield f"{name}: damaged at line {read + 1}; {lines - read} lines are not read"
        if length < samples:
            yield f"audio.wav: {(samples - length) / rate:.2f} s shorter than the Inputs"
        elif length > samples:
            yield f"audio.wav: {(length - samples) / rate:.2f} s longer than the Inputs: the excess is not used"
        yield from self._unreadable()
        if not found.inputs and (self.path / "inputs.jsonl").is_file():
            yield "inputs.jsonl: holds no Input that can be read: there is nothing to replay"
        if found.rounded:
            yield "audio.wav: some samples did not fit into 24 bits: a replay may differ"


def _lines(path: Path) -> Iterator[bytes]:
    if not path.is_file():
        return
    with refused_as(ConfigError, f"{path}: cannot be read"), os.fdopen(open_regular(path), "rb") as file:
        yield from iter(lambda: file.readline(LONGEST), b"")


def _is_event(text: bytes) -> bool:
    try:
        values = parsed_json(text)
    except ValueError:
        return False
    if not (isinstance(values, dict) and isinstance(values.get("event"), str) and are_finite(values.get("time"))):
        return False
    return values["event"] != "TurnStarted" or are_finite(values.get("joint"))
