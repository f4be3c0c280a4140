"""Building the audio of the benchmark: every scene a folder with WAV files of 16 bits, and what is known of it as JSON.

Scenes are made as in `ross study` (`mixtures`, `exploration`), with the places of the list. A folder appears whole; a
build that was stopped goes on when the same command is given again, and one that had ended makes anew what differs from
its hashes.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import soundfile
from threadpoolctl import threadpool_limits

from ross_payload.atomic_files import PART, json_text, replacing
from ross_payload.bounded_files import parsed_json, read_bounded
from ross_payload.errors import ConfigError, OutputError, refused_as, shown
from ross_payload.interfaces import Real, Samples
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.study.benchmark.recordings import FULL_SCALE, RATE, found
from ross_sim.study.benchmark.scene_list import ALIGNED, RANDOM, SECONDS, TURNING, BenchmarkScene, SceneList
from ross_sim.study.runs.row_manifest import held
from ross_sim.study.scenes.exploration import render
from ross_sim.study.scenes.mixtures import LEAD_IN, record
from ross_sim.study.scenes.room_settings import DISTANCE, SETTINGS, SPACING, SPEED_OF_SOUND, Setting

PEAK = 0.5  # of the loudest sample of a scene, re full scale
UNIT, STEP_DEG, ORIENTATIONS = 3.0, 30.0, 7  # of a turn: [s], [deg]
MANIFEST, SUMS, SCENE, TRUTH = "benchmark.json", "SHA256SUMS", "scene.json", "truth.json"
MIXTURE, NOISE, REFERENCE = "mixture.wav", "noise.wav", "reference-{}.wav"
ORDER = (ALIGNED, RANDOM, TURNING)  # the noise of every orientation is another


@dataclass(frozen=True, slots=True)
class Placed(Setting):
    """A room in which the talkers' places are given."""

    spots: tuple[tuple[float, ...], ...] = ()  # [m]

    def places(self, azimuths: Real, rng: np.random.Generator) -> Real:
        """Where the talkers stand [m], (n_sources, dim); nothing is drawn."""
        return np.array(self.spots)

    def responses(self, places: Real, headings: Sequence[float], rate: int) -> Samples:
        """Impulse responses (n_headings, 2, n_sources, n_taps), which nobody else needs."""
        centre, spots = self.centre, tuple(map(tuple, places.tolist()))
        return respond(RoomSpec(self.size, self.t60, rate, centre, SPACING, spots, SPEED_OF_SOUND), headings)


def placed(scene: BenchmarkScene) -> Placed:
    """The room of a scene with its talkers."""
    setting, layout = SETTINGS[scene.room], scene.layout
    azimuths = np.deg2rad(layout.azimuths_deg)
    distances = np.full(layout.k, DISTANCE) if setting.flat else np.array(layout.distances_m)
    x, y = setting.centre[:2]
    spots = np.stack([x + distances * np.cos(azimuths), y + distances * np.sin(azimuths)], axis=1)
    if not setting.flat:
        spots = np.column_stack([spots, layout.heights_m])
    return Placed(setting.name, setting.size, setting.t60, tuple(map(tuple, spots.tolist())))


def headings_deg(scene: BenchmarkScene) -> list[float]:
    """Where the array points, once or one after another [deg]."""
    if scene.orientation != TURNING:
        return [scene.heading_deg]
    return [round(scene.heading_deg + STEP_DEG * step, 2) for step in range(ORIENTATIONS)]


def sounds_of(scene: BenchmarkScene, voices: Mapping[str, Real]) -> dict[str, Real]:
    """What is heard in a scene, (n_channels, n) by file; nothing is louder than `PEAK`."""
    layout, room = scene.layout, placed(scene)
    azimuths, headings = np.deg2rad(layout.azimuths_deg), np.deg2rad(headings_deg(scene))
    rng, spoken = np.random.default_rng([layout.seed, ORDER.index(scene.orientation)]), []
    for talker, start in zip(layout.talkers, layout.starts, strict=True):
        spoken.append(voices[talker][start : start + round(SECONDS * RATE)])
    if scene.orientation == TURNING:
        whole = [voices[talker].astype(np.float32) for talker in layout.talkers]
        received = render(whole, azimuths, room, headings, rng, seconds=UNIT, rate=RATE)
        sounds = {MIXTURE: np.concatenate(list(received), axis=1)}
    else:
        recording = record(spoken, azimuths, layout.target, float(headings[0]), room, rng=rng, rate=RATE)
        references = {REFERENCE.format(k): image[:1] for k, image in enumerate(recording.images)}
        sounds = {MIXTURE: recording.mixture, NOISE: recording.lead_in, **references}
    gain = PEAK / max(float(np.abs(sound).max()) for sound in sounds.values())
    return {name: gain * sound for name, sound in sounds.items()}


def known_of(scene: BenchmarkScene) -> tuple[dict[str, Any], dict[str, Any]]:
    """What a method may know of a scene, and the truth that it is to find."""
    layout, turning = scene.layout, scene.orientation == TURNING
    task = "localization" if turning else "separation"
    common = {
        "scene": scene.name, "task": task, "rate_hz": RATE, "spacing_m": SPACING, "speed_of_sound_m_s": SPEED_OF_SOUND,
    }  # fmt: skip
    truth = {"azimuths_deg": list(layout.azimuths_deg), "talkers": list(layout.talkers), "target": layout.target}
    if turning:
        return {**common, "headings_deg": headings_deg(scene), "seconds_each": UNIT}, truth
    known = {"azimuths_deg": list(layout.azimuths_deg), "target": layout.target, "noise_lead_in_s": LEAD_IN}
    return {**common, "heading_deg": scene.heading_deg, **known}, truth


@dataclass(frozen=True, slots=True)
class Built:
    """What a build has come to."""

    scenes: int
    mended: tuple[str, ...]  # scenes whose files were no longer those of an earlier build, and were made anew


def build(
    scenes: SceneList, recordings: Path, out: Path, *, quick: bool = False, done: Callable[[str], None] = lambda _: None
) -> Built:
    """Build every scene that is not there yet, or no longer as it was built.

    Raises
    ------
    ConfigError
        When recordings are missing or differ, the folder holds something else, or another build writes there.
    OutputError
        When it cannot be written.
    """
    wanted = scenes.scenes(quick)
    needed = {talker for scene in wanted for talker in scene.layout.talkers}
    voices = found(recordings, [each for each in scenes.recordings if each.utterance in needed])
    names, sources = [scene.name for scene in wanted], {f"{each.corpus}, {each.licence}" for each in scenes.recordings}
    _open(out, {"sources": sorted(sources), "list": scenes.fingerprint, "quick": quick, "scenes": names})
    with refused_as(OutputError, f"{out}: cannot be written"), held(out, waits=False), threadpool_limits(1):
        before, sums, mended = _sums(out), list[str](), list[str]()
        for scene in wanted:
            there = _hashed(out, scene.name)
            own = before.get(scene.name, []) if before else there
            if not own or not set(own) <= set(there):
                ours = _write(out, scene, sounds_of(scene, voices))
                own = [line for line in _hashed(out, scene.name) if line.rpartition("/")[2] in ours]
                if before:
                    mended.append(scene.name)
            sums += own
            done(scene.name)
        with replacing(out / SUMS) as path:
            path.write_text("".join(f"{line}\n" for line in sums), encoding="utf-8")
    return Built(len(wanted), tuple(mended))


def built(out: Path) -> list[Path]:
    """The folders of a benchmark that was built, one for every scene.

    Raises
    ------
    ConfigError
        When there is none, or it is not complete.
    """
    with refused_as(ConfigError, f"{out}: expected a benchmark that 'ross study benchmark build' made"):
        names = json_of(out / MANIFEST).get("scenes", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ConfigError(f"{out / MANIFEST}: scenes: expected a list of names, got {shown(names)}")
    if not (out / SUMS).is_file():
        raise ConfigError(f"{out}: is not complete: give the command that builds it again")
    return [out / name for name in names]


def json_of(path: Path) -> dict[str, Any]:
    """Read an object from a file of JSON.

    Raises
    ------
    ConfigError
        When it is something else.
    """
    try:
        values = parsed_json(read_bounded(path))
    except ValueError as error:
        raise ConfigError(f"{path}: expected JSON: {error}") from error
    if not isinstance(values, dict):
        raise ConfigError(f"{path}: expected an object, got {type(values).__name__}")
    return values


def _open(out: Path, manifest: dict[str, Any]) -> None:
    """Begin a folder, or go on in one that was begun for the same scenes."""
    path = out / MANIFEST
    if path.is_file():
        if json_of(path) != manifest:
            raise ConfigError(f"{out}: holds other scenes: give another folder, or remove it")
        return
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise ConfigError(f"{out}: expected an empty folder, or one that a build was begun in")
    with refused_as(OutputError, f"{out}: cannot be written"):
        out.mkdir(parents=True, exist_ok=True)
        with replacing(path) as part:
            part.write_text(json.dumps(manifest) + "\n", encoding="utf-8")


def _write(out: Path, scene: BenchmarkScene, sounds: Mapping[str, Real]) -> set[str]:
    """Write a scene: a folder that appears whole, or files in one that is there, beside others; return their names."""
    part, folder = out / f".{PART}-{scene.name}", out / scene.name
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    try:
        for name, sound in sounds.items():
            write_wav(part / name, sound)
        for name, values in zip((SCENE, TRUTH), known_of(scene), strict=True):
            (part / name).write_text(json_text(values), encoding="utf-8")
        written = _files(part)
        if folder.is_dir():
            for path in written:
                path.replace(folder / path.name)
        else:
            part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return {path.name for path in written}


def _sums(out: Path) -> dict[str, list[str]]:
    """The lines of an earlier build that has ended about every scene; none when there was none."""
    lines = dict[str, list[str]]()
    if (out / SUMS).is_file():
        for line in (out / SUMS).read_bytes().decode("utf-8", "replace").splitlines():
            lines.setdefault(line.partition("  ")[2].partition("/")[0], []).append(line)
    return lines


def _hashed(out: Path, scene: str) -> list[str]:
    """What the list of hashes has to say about the files of a scene; nothing of one that is not there."""
    folder = out / scene
    return [f"{_sha256(path)}  {scene}/{path.name}" for path in _files(folder)] if folder.is_dir() else []


def write_wav(path: Path, sound: Real) -> None:
    """Write samples (n_channels, n) within -1 to 1 as a WAV file of 16 bits.

    Raises
    ------
    OutputError
        When it cannot be written.
    """
    whole = np.round(FULL_SCALE * np.clip(sound, -1.0, 1.0 - 1 / FULL_SCALE)).astype(np.int16)
    memory = io.BytesIO()  # libsndfile does not say that a disk is full
    soundfile.write(memory, whole.T, RATE, subtype="PCM_16", format="WAV")
    with refused_as(OutputError, f"{path}: cannot be written"):
        path.write_bytes(memory.getvalue())


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_file())


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
