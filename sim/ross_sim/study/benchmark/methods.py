"""Running a method of ours, or a plug-in, over the benchmark; what it finds is written as anybody's would be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import soundfile
from pydantic import BaseModel, Field, model_validator
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.atomic_files import json_text, replacing
from ross_payload.config import Degrees, Positive, validated
from ross_payload.dsp.steering import tdoa
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ConfigError, OutputError, refused_as, unknown
from ross_payload.interfaces import Explorer, Real, Separator
from ross_payload.plugin_checks import load_separator
from ross_sim.study.benchmark.build_audio import MIXTURE, NOISE, PEAK, REFERENCE, SCENE, built, json_of, write_wav
from ross_sim.study.benchmark.recordings import RATE
from ross_sim.study.oracle_separators import ideal_ratio_mask
from ross_sim.study.runs.study_design import explorer_named
from ross_sim.study.scenes.exploration import observed
from ross_sim.study.scenes.mixtures import Mixture, scene_of
from ross_sim.talkers.speech import why_unreadable

FRAME, EXPLORE_FRAME = 2048, 1024  # [samples], a quarter apart
AZIMUTHS = "azimuths.json"
ORACLE = "irm"  # the one that needs the references at microphone 1 only


class Known(BaseModel):
    """What stands in every ``scene.json``."""

    rate_hz: Annotated[int, Field(gt=0)]
    spacing_m: Positive
    speed_of_sound_m_s: Positive


class KnownMixture(Known):
    """And what is known of a mixture."""

    heading_deg: Degrees
    azimuths_deg: Annotated[tuple[Degrees, ...], Field(min_length=1)]
    target: Annotated[int, Field(ge=0)]

    @model_validator(mode="after")
    def _target_among_talkers(self) -> KnownMixture:
        if self.target >= len(self.azimuths_deg):
            raise ValueError(f"target: expected one of {len(self.azimuths_deg)} talkers, got {self.target}")
        return self


class KnownTurn(Known):
    """And of a turn."""

    headings_deg: Annotated[tuple[Degrees, ...], Field(min_length=1)]


class Truth(BaseModel):
    """What ``truth.json`` tells the scores."""

    azimuths_deg: Annotated[tuple[Degrees, ...], Field(min_length=1)]


KNOWN: dict[str, type[Known]] = {"separation": KnownMixture, "localization": KnownTurn}


@dataclass(frozen=True, slots=True, eq=False)
class HeardScene:
    """One scene as it was built."""

    folder: Path
    known: Mapping[str, Any]  # of scene.json

    def sound(self, name: str) -> Real:
        """Samples of a file, (n_channels, n)."""
        return wav(self.folder / name)

    @property
    def recording(self) -> Mixture:
        """The mixture of a scene to separate; the images at microphone 2 are not known, and 0."""
        azimuths = np.deg2rad(np.array(self.known["azimuths_deg"], float))
        spacing, speed_of_sound = self.known["spacing_m"], self.known["speed_of_sound_m_s"]
        tau = tdoa(azimuths, float(np.deg2rad(self.known["heading_deg"])), spacing, speed_of_sound)
        images = np.stack([self.sound(REFERENCE.format(k)) for k in range(azimuths.size)])
        images = np.concatenate([images, np.zeros_like(images)], axis=1)
        return Mixture(self.sound(MIXTURE), self.sound(NOISE), images, tau, int(self.known["target"]))


def wav(path: Path) -> Real:
    """Read samples of a file of the benchmark, (n_channels, n).

    Raises
    ------
    ConfigError
        When it cannot be read.
    """
    try:
        samples, _ = soundfile.read(path, dtype="float32", always_2d=True)
    except (soundfile.LibsndfileError, OSError) as error:
        raise ConfigError(f"{path}: not a recording that can be read: {why_unreadable(error)}") from error
    return np.asarray(samples.T)


def scenes_of(audio: Path, task: str) -> list[HeardScene]:
    """The scenes of a task, as they were built.

    Raises
    ------
    ConfigError
        When there is no benchmark, it is not complete, or what is known of a scene is wrong.
    """
    found = []
    for folder in built(audio):
        with refused_as(ConfigError, f"{folder / SCENE}: cannot be read"):
            known = json_of(folder / SCENE)
        if known.get("task") == task:
            validated(KNOWN[task], known, str(folder / SCENE))
            found.append(HeardScene(folder, known))
    return found


def separated(separator: Separator, recording: Mixture) -> Real | None:
    """The group that holds the target, (n,); None when none does."""
    stft = Stft(RATE, FRAME, FRAME // 4)
    groups = separator.batch(stft.analyse(recording.mixture), scene_of(recording, stft, known_noise=True))
    for members, signal in zip(groups.members, groups.signals, strict=True):
        if recording.target in members:
            return np.asarray(stft.synthesise(signal, recording.mixture.shape[1]))
    return None


def by_ideal_ratio_mask(recording: Mixture) -> Real:
    """What an oracle makes of it that knows every talker, (n,): microphone 1 through the target's ideal ratio mask."""
    noise = recording.mixture - recording.images.sum(axis=0)
    return np.asarray(ideal_ratio_mask(recording.images, noise, Stft(RATE, FRAME, FRAME // 4))[recording.target])


def localized(explorer: Explorer, scene: HeardScene) -> list[float]:
    """Azimuths [deg] of the talkers that an explorer finds in a turn; nobody tells it K or the noise."""
    headings = np.deg2rad(np.array(scene.known["headings_deg"], float))
    received = np.stack(np.split(scene.sound(MIXTURE), headings.size, axis=1))
    stft = Stft(RATE, EXPLORE_FRAME, EXPLORE_FRAME // 4)
    estimate = explorer.estimate(list(observed(explorer, stft, received, headings)))
    return [round(float(np.rad2deg(source.azimuth)), 3) for source in estimate.sources]


def run(name: str, audio: Path, out: Path, done: Callable[[str], None] = lambda _: None) -> str:
    """Run a separator, an explorer or the oracle ``irm`` over all scenes of its task; returns the task.

    Raises
    ------
    ConfigError
        When there is no such method, or no benchmark.
    OutputError
        When the estimates cannot be written.
    """
    separators = plugins.available("ross_payload.separators")
    explorers = plugins.available("ross_payload.explorers")
    if name not in (ORACLE, *separators, *explorers):
        raise ConfigError(unknown("method", name, [ORACLE, *separators, *explorers]))
    with refused_as(OutputError, f"{out}: cannot be written"), threadpool_limits(1), np.errstate(all="ignore"):
        if name in explorers:
            return _localize(explorer_named(name), audio, out, done)
        scenes = scenes_of(audio, "separation")
        separator = None if name == ORACLE else load_separator(name)
        out.mkdir(parents=True, exist_ok=True)
        for scene in scenes:
            recording = scene.recording
            voice = by_ideal_ratio_mask(recording) if separator is None else separated(separator, recording)
            path = out / f"{scene.folder.name}.wav"
            path.unlink(missing_ok=True)
            if voice is not None and np.ptp(voice) > 0:
                with replacing(path) as part:
                    write_wav(part, PEAK / np.abs(voice).max() * voice[None])
            done(scene.folder.name)
        return "separation"


def _localize(explorer: Explorer, audio: Path, out: Path, done: Callable[[str], None]) -> str:
    found = {}
    for scene in scenes_of(audio, "localization"):
        found[scene.folder.name] = localized(explorer, scene)
        done(scene.folder.name)
    out.mkdir(parents=True, exist_ok=True)
    with replacing(out / AZIMUTHS) as path:
        path.write_text(json_text(found), encoding="utf-8")
    return "localization"
