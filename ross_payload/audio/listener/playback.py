"""Where what is listened to goes: a sound output that asks for samples, or a file that takes them as time passes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ross_payload.audio.listener.feed import Feed, Progress
from ross_payload.audio.sound_devices import device_named, portaudio
from ross_payload.audio.track_files import AlignedTrack
from ross_payload.errors import AudioError, ConfigError, OutputError, refused_as
from ross_payload.interfaces import Clock, Samples
from ross_payload.streams import LISTENER_TIMEOUT_S

SUFFIXES = (".wav", ".flac")
LATENCY_S = 0.04  # asked of a sound output
TICK_S = 0.02  # between two looks at the time
LINE_S = 1.0  # between two lines
FLOOR_DB = -120.0
Pump = Callable[[], None]  # does what is due


class Meter:
    """Tells how loud what was heard is.

    >>> meter = Meter()
    >>> meter.note(np.full(100, 0.1, np.float32)), round(meter.level(), 3)
    (None, -20.0)
    """

    def __init__(self) -> None:
        self._power = self._count = 0.0

    def note(self, samples: Samples) -> None:
        """Take samples (n,)."""
        self._power += float(np.dot(samples, samples))
        self._count += len(samples)

    def level(self) -> float:
        """Return the rms since the latest call [dB re full scale]."""
        power, self._power = self._power / max(self._count, 1), 0.0
        self._count = 0.0
        return 10 * math.log10(power) if power > 10 ** (FLOOR_DB / 10) else FLOOR_DB


def checked_file(path: Path) -> Path:
    """Return the path of a file to be written.

    Raises
    ------
    ConfigError
        When it has another suffix, is there already, or its folder is not.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise ConfigError(f"--out: expected a file that ends in {' or '.join(SUFFIXES)}, got {path}")
    if path.exists():
        raise ConfigError(f"--out: {path} is there already: delete it, or give another name")
    if not path.parent.is_dir():
        raise ConfigError(f"--out: there is no folder {path.parent}")
    return path


@contextmanager
def to_file(feed: Feed, path: Path, meter: Meter, clock: Clock) -> Iterator[Pump]:
    """Write what comes, from the first sound on, to a file for its owner alone; one with nothing in it is removed.

    Raises
    ------
    ConfigError
        When the file cannot be made.
    OutputError
        When the disk is full or gone.
    """
    with refused_as(ConfigError, f"--out: {path} cannot be written"):
        track = AlignedTrack(path, feed.rate)
    began, heard = clock.now(), feed.progress(0.0).received

    def pump() -> None:
        nonlocal began, heard
        if not heard:  # the time before the first sound is not in the file
            began, heard = clock.now(), feed.progress(0.0).received
        samples = feed.read(int((clock.now() - began) * feed.rate) - track.length)
        meter.note(samples)
        track.write(track.length, samples)

    try:
        with closing(track):
            yield pump
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from error
    finally:
        if not feed.progress(0.0).received:
            path.unlink(missing_ok=True)


@contextmanager
def to_device(feed: Feed, name: str, meter: Meter) -> Iterator[Pump]:
    """Play what comes.

    Raises
    ------
    AudioError
        When the sound output is not there, busy, or has not the rate, or is gone.
    """
    module = portaudio()
    device = device_named(module, name, "output")

    def play(out: Any, count: int, _times: Any, _flags: Any) -> None:
        samples = feed.read(count)
        meter.note(samples)
        out[:] = samples[:, None]

    try:
        stream = module.OutputStream(
            device=device.number,
            samplerate=feed.rate,
            channels=min(device.channels, 2),
            dtype="float32",
            latency=LATENCY_S,
            callback=play,
        )
    except module.PortAudioError as error:
        why = str(error).partition("\n")[0]
        raise AudioError(f"the sound output '{name}' cannot be opened: {why}") from error

    def pump() -> None:
        if not stream.active:
            raise AudioError(f"the sound output '{name}' was disconnected")

    with stream:
        yield pump


def listen(
    feed: Feed,
    place: AbstractContextManager[Pump],
    *,
    meter: Meter,
    clock: Clock,
    wall: Callable[[], float],
    report: Callable[[str], None],
    duration: float | None,
    waits: bool = False,
) -> None:
    """Play until the sender ends or ``duration`` [s] is over, and tell once a second how it goes.

    Parameters
    ----------
    waits
        Go on when the sender has ended or is silent: it may begin again.

    Raises
    ------
    AudioError
        When nothing came at all, or nothing came any more for `LISTENER_TIMEOUT_S` though the sender did not end.
    """
    began = told = clock.now()
    progress = feed.progress(wall())
    with place as pump:
        while not _is_over(progress, waits=waits) and (duration is None or clock.now() < began + duration):
            clock.sleep(TICK_S)
            pump()
            before, progress = progress, feed.progress(wall())
            if progress.ended and not before.ended:
                report(f"{clock.now() - began:6.0f} s  {progress.words}")
            if clock.now() >= told + LINE_S:
                told += LINE_S
                report(_line(feed, meter, told - began, wall()))
    if not progress.received:
        raise AudioError(f"nothing came to {feed.where} in {clock.now() - began:.0f} s")
    if _is_lost(progress) and not waits:
        raise AudioError(f"nothing has come to {feed.where} for {progress.silent_s:.0f} s, and no end was said")


def _is_over(progress: Progress, *, waits: bool) -> bool:
    return progress.final or (not waits and (progress.ended or _is_lost(progress)))


def _is_lost(progress: Progress) -> bool:
    return progress.received and not progress.ended and progress.silent_s >= LISTENER_TIMEOUT_S


def _line(feed: Feed, meter: Meter, time: float, wall: float) -> str:
    progress, level = feed.progress(wall), meter.level()
    if not progress.received:
        return f"{time:6.0f} s  waits on {feed.where}"
    quiet = "" if progress.playing else "; waits for the next" if progress.ended else "; nothing comes"
    return f"{time:6.0f} s  {level:6.1f} dB  {progress.words}{quiet}"
