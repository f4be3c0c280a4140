"""Scoring a folder of estimates, whoever made them, with one protocol.

Separation: ``SCENE.wav``, one channel, as long as ``mixture.wav`` and in step with it, is the target as microphone 1
would hear it alone. Localization: ``azimuths.json`` has a list of azimuths [deg] for every scene. A scene without an
estimate, or with a silent one, counts as 0 dB, and as nobody found.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import soundfile

from ross_payload.atomic_files import json_text, replacing
from ross_payload.config import validated
from ross_payload.dsp.metrics import si_sdr
from ross_payload.errors import ConfigError, OutputError, refused_as, shown
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Real
from ross_sim.study.benchmark.benchmark_rows import (
    BenchmarkLocalization,
    BenchmarkSeparation,
    localization_table,
    separation_table,
)
from ross_sim.study.benchmark.build_audio import MANIFEST, MIXTURE, REFERENCE, TRUTH, json_of
from ross_sim.study.benchmark.methods import AZIMUTHS, HeardScene, Truth, scenes_of
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.rows.tables import Table
from ross_sim.study.runs.row_manifest import held
from ross_sim.study.runs.study_store import difference
from ross_sim.study.scenes.exploration import matched
from ross_sim.talkers.speech import why_unreadable

DIGITS = 3
MOST_TALKERS = 20  # that an estimate may name
LARGEST_DEG = 1e6  # angle that an estimate may name
NAME = re.compile(r"(?P<room>.+)-k(?P<k>\d{1,3})-[^-]+-(?P<orientation>[^-]+)")  # of a scene

SCENES = "scenes.json"  # in a folder of results: of which list, and whether a few of it
KINDS: dict[str, tuple[type[Any], Callable[[Sequence[Any]], Table]]] = {
    "separation": (BenchmarkSeparation, separation_table),
    "localization": (BenchmarkLocalization, localization_table),
}

Row = BenchmarkSeparation | BenchmarkLocalization


def score(audio: Path, estimates: Path, name: str) -> list[Row]:
    """Score what a folder has: voices, azimuths, or both.

    Raises
    ------
    ConfigError
        When there are no estimates of these scenes, or one does not fit; says what was expected.
    """
    voices, turns = scenes_of(audio, "separation"), scenes_of(audio, "localization")
    found = {scene.folder.name for scene in voices if (estimates / f"{scene.folder.name}.wav").is_file()}
    rows: list[Row] = [_separation(scene, estimates, name) for scene in voices] if found else []
    if (estimates / AZIMUTHS).is_file():
        rows += _turns(turns, estimates / AZIMUTHS, name)
    if not rows:
        example = f"{voices[0].folder.name}.wav, ... or " if voices else ""
        raise ConfigError(f"{estimates}: expected estimates, {example}{AZIMUTHS}, got none")
    return rows


def _of(scene: HeardScene) -> tuple[str, str, int, str]:
    """Name, room, K and orientation of a scene."""
    parts = NAME.fullmatch(scene.folder.name)
    if parts is None:
        raise ConfigError(
            f"{scene.folder}: expected a scene, ROOM-kK-LAYOUT-ORIENTATION, got {shown(scene.folder.name)}"
        )
    return scene.folder.name, parts["room"], int(parts["k"]), parts["orientation"]


def _separation(scene: HeardScene, estimates: Path, method: str) -> BenchmarkSeparation:
    name, room, k, orientation = _of(scene)
    mixture = scene.sound(MIXTURE)[0]
    reference = scene.sound(REFERENCE.format(scene.known["target"]))[0]
    before = round(si_sdr(mixture, reference), DIGITS)
    voice = _voice(estimates / f"{name}.wav", int(scene.known["rate_hz"]), mixture.size)
    if voice is None:
        return BenchmarkSeparation(method, name, room, k, orientation, before, before, missing=True)
    after = round(min(si_sdr(voice, reference), 100.0), DIGITS)
    return BenchmarkSeparation(method, name, room, k, orientation, before, after)


def _voice(path: Path, rate: int, n: int) -> Real | None:
    """An estimate (n,); None when there is none, or it is silent."""
    if not path.exists():
        return None
    try:
        samples, its_rate = soundfile.read(path, dtype="float64", always_2d=True)
    except (soundfile.LibsndfileError, OSError) as error:
        raise ConfigError(f"{path}: not a recording that can be read: {why_unreadable(error)}") from error
    if (its_rate, samples.shape) != (rate, (n, 1)):
        got = f"{samples.shape[0]} of {samples.shape[1]} at {its_rate} Hz"
        raise ConfigError(f"{path}: expected {n} samples of one channel at {rate} Hz, as the mixture has, got {got}")
    if not np.isfinite(samples).all():
        raise ConfigError(f"{path}: expected finite samples, got NaN or infinity")
    return np.asarray(samples[:, 0]) if np.ptp(samples) > 0 else None


def _turns(scenes: Sequence[HeardScene], path: Path, method: str) -> list[Row]:
    with refused_as(ConfigError, f"{path}: cannot be read"):
        told = json_of(path)
    names = {scene.folder.name for scene in scenes}
    for name in told:
        if name not in names:
            raise ConfigError(f"{path}: expected scenes that end with '-turning', got {shown(name)}")
    return [_turn(scene, told.get(scene.folder.name), path, method) for scene in scenes]


def _turn(scene: HeardScene, told: Any, path: Path, method: str) -> BenchmarkLocalization:
    name, room, k, _ = _of(scene)
    there = scene.folder / TRUTH
    with refused_as(ConfigError, f"{there}: cannot be read"):
        azimuths = np.deg2rad(validated(Truth, json_of(there), str(there)).azimuths_deg)
    good = isinstance(told, list) and len(told) <= MOST_TALKERS and all(map(_is_angle, told))
    if told is not None and not good:
        raise ConfigError(
            f"{path}: {name}: expected a list of at most {MOST_TALKERS} azimuths [deg], got {shown(told)}"
        )
    sources = tuple(SourceEstimate(math.radians(azimuth), 0.0, 1.0, True) for azimuth in told or ())
    errors = tuple(round(float(error), DIGITS) for error in matched(azimuths, Estimate(sources))[0])
    return BenchmarkLocalization(method, name, room, k, len(sources), errors, missing=told is None)


def _is_angle(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST_DEG <= value <= LARGEST_DEG


def kept(rows: Sequence[Row], out: Path, audio: Path) -> list[Table]:
    """Write rows into the files of a folder, where they take the place of the method's former ones; returns the tables.

    Raises
    ------
    ConfigError
        When a file there holds something else, or scores of other scenes than those of the folder ``audio``.
    OutputError
        When it cannot be written.
    """
    tables = []
    with refused_as(OutputError, f"{out}: cannot be written"):
        out.mkdir(parents=True, exist_ok=True)
    with refused_as(OutputError, f"{out}: cannot be written"), held(out, waits=True):
        _claim(out, {name: json_of(audio / MANIFEST).get(name) for name in ("list", "quick")})
        for stem, (kind, table) in KINDS.items():
            path = out / f"{stem}.csv"
            old = read_rows(path, [kind])[1] if path.exists() else []
            new = [row for row in rows if isinstance(row, kind)]
            every = [row for row in old if not new or row.method != new[0].method] + new
            if new:
                with replacing(path) as part:
                    part.write_bytes(as_csv(every, kind))
            if every:
                tables.append(table(every))
        with replacing(out / "tables.md") as part:
            part.write_text("\n".join(made.markdown() for made in tables), encoding="utf-8")
    return tables


def _claim(out: Path, scenes: dict[str, Any]) -> None:
    """Take a folder for scores of some scenes; scores of others would count as theirs."""
    path = out / SCENES
    if not any((out / f"{stem}.csv").exists() for stem in KINDS):
        with refused_as(OutputError, f"{out}: cannot be written"), replacing(path) as part:
            part.write_text(json_text(scenes), encoding="utf-8")
        return
    if not path.exists():
        raise ConfigError(f"--out {out}: holds scores, and no {SCENES} that says of what; choose another folder")
    with refused_as(ConfigError, f"{path}: cannot be read"):
        other = difference(json_of(path), scenes)
    if other:
        raise ConfigError(f"--out {out}: holds scores of other scenes ({other}); choose another folder")
