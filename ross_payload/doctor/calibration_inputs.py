"""What was heard at every heading, from a recording: a session folder, or a WAV with a table of joint angles."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from ross_payload.angles import wrap
from ross_payload.audio.audio_files import read_audio
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.bounded_files import read_bounded
from ross_payload.calibration.cross_spectrum import HeadingSpectrum, heading_spectrum
from ross_payload.config import Config
from ross_payload.errors import ConfigError, refused_as, shown
from ross_payload.interfaces import Attitude, Input, Samples
from ross_payload.sessions.session_reader import RecordedSession

REST = math.radians(0.2)  # hops at headings within this are heard at one [rad]
LONGEST_S = 10.0  # of listening at one heading that is used [s]
COLUMNS = ("from_s", "to_s", "joint_deg")


def from_session(config: Config, path: Path) -> tuple[list[HeadingSpectrum], bool]:
    """Return what was heard at every heading at rest of a session, and whether in the earth frame.

    Of two frames the one with more headings is used. Gain, polarity, roll-off and heading offset are those of
    ``config``, whatever they were when it was recorded.

    Raises
    ------
    ConfigError
        When it is no session, or was heard through other channels or at another rate.
    """
    session = RecordedSession.open(path)
    recorded = session.configuration()
    now, then = ChannelMap.of(config.audio).channels, ChannelMap.of(recorded.audio).channels
    if now != then:
        raise ConfigError(f"{path}: expected channels {list(now)} (audio.channels), got a recording of {list(then)}")
    if recorded.audio.rate_hz != config.audio.rate_hz:
        raise ConfigError(f"{path}: expected {config.audio.rate_hz} Hz (audio.rate_hz), got {recorded.audio.rate_hz}")
    correction, rate = config.offset - recorded.offset, config.audio.rate_hz
    heard: dict[bool, list[HeadingSpectrum]] = {False: [], True: []}  # by frame: those of two do not go together
    for heading, samples, known in _rests(session.inputs(config.audio, wire_everywhere=True), round(LONGEST_S * rate)):
        found = heading_spectrum(samples, rate, heading + correction)
        if found is not None:
            heard[known].append(found)
    earth = len(heard[True]) > len(heard[False])
    return heard[earth], earth


def from_wav(config: Config, path: Path, table: Path, base: Attitude) -> list[HeadingSpectrum]:
    """Return what was heard in every stretch of a WAV that a table gives the joint angle of.

    The table is CSV with the columns from_s, to_s and joint_deg: degrees counter-clockwise from the zero of the joint.

    Raises
    ------
    RossError
        When a file is missing or is not what it should be.
    """
    samples, rate = read_audio(path)
    wiring = ChannelMap.of(config.audio)
    if rate != config.audio.rate_hz:
        raise ConfigError(f"{path}: expected {config.audio.rate_hz} Hz (audio.rate_hz), got {rate} Hz")
    if samples.shape[1] < wiring.needed:
        raise ConfigError(f"{path}: expected at least {wiring.needed} channels, got {samples.shape[1]}")
    both, heard = np.ascontiguousarray(samples[:, list(wiring.channels)].T, dtype=np.float32), []
    stretches: list[tuple[float, float, float]] = []
    for number, begin, end, joint in _table(table):
        if not 0 <= begin < end <= len(samples) / rate:
            length = f"{len(samples) / rate:g}"
            raise ConfigError(
                f"{table}: line {number}: expected 0 <= from_s < to_s <= {length}, got {begin:g}, {end:g}"
            )
        for other in stretches:
            if begin < other[1] and other[0] < end and joint != other[2]:
                raise ConfigError(
                    f"{table}: line {number}: expected one angle at a time, got {joint:g} and {other[2]:g}"
                )
        stretches.append((begin, end, joint))
        part = wiring.correction(rate).apply(both[:, round(begin * rate) : round(end * rate)]).samples
        found = heading_spectrum(part, rate, base.yaw + math.radians(joint) + config.offset)
        if found is not None:
            heard.append(found)
    return heard


def _table(path: Path) -> Iterator[tuple[int, float, float, float]]:
    """Line, from [s], to [s] and joint angle [deg] of every stretch."""
    with refused_as(ConfigError, f"{path}: cannot be read"):
        data = read_bounded(path)
    try:
        reader = csv.reader(data.decode("utf-8-sig").splitlines(), skipinitialspace=True)
        lines = [(reader.line_num, [cell.strip() for cell in line]) for line in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: expected CSV in UTF-8, got something else") from error
    lines = [(number, line) for number, line in lines if any(line)]
    names = lines[0][1] if lines else []
    wanted = ", ".join(COLUMNS)
    for name in COLUMNS:
        if names.count(name) > 1:
            raise ConfigError(f"{path}: expected one column {name}, got {names.count(name)}")
    there = "" if set(COLUMNS) <= set(names) else f", got the columns {shown(', '.join(names))}"
    for number, line in lines[1:]:
        cells = dict(zip(names, line, strict=False))
        try:
            values = [float(cells[name]) for name in COLUMNS]
        except (KeyError, ValueError) as error:
            raise ConfigError(f"{path}: line {number}: expected numbers in the columns {wanted}{there}") from error
        if any(line[len(names) :]):  # as with decimal commas
            raise ConfigError(f"{path}: line {number}: expected {len(names)} columns, got {len(line)}")
        if not all(map(math.isfinite, values)):
            raise ConfigError(f"{path}: line {number}: expected finite numbers, got {values}")
        yield number, values[0], values[1], values[2]


def _rests(inputs: Iterable[Input], longest: int) -> Iterator[tuple[float, Samples, bool]]:
    """Heading [rad], samples (2, n) and frame of every stretch at rest."""
    blocks: list[Samples] = []
    heading, earth = 0.0, False
    for hop in inputs:
        here = hop.pointing.heading
        same = abs(wrap(here - heading)) < REST and abs(wrap(hop.heading_start - heading)) < REST
        if blocks and not (hop.settled and same and hop.pointing.earth == earth):
            yield heading, np.concatenate(blocks, axis=1)[:, -longest:], earth
            blocks = []
        if hop.settled:
            if not blocks:
                heading, earth = here, hop.pointing.earth
            blocks.append(hop.block.samples)
    if blocks:
        yield heading, np.concatenate(blocks, axis=1)[:, -longest:], earth
