"""Fit what `joint` tells while the array turns: ``python -m ross_sim.study.turning_evidence FOLDER OUT.json``.

As `fit_talker_evidence`, to an array that turns back and forth for 18 s at 12, 20 or 30 deg/s. Rooms, talkers,
loudness and noise are drawn as in `evidence_scenes`. Mixtures are fitted after 2, 3, 4 and 6 periods of 3 s.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Real, Samples, TurningExplorer
from ross_payload.localization.joint import Joint
from ross_sim.acoustics.room import RoomSpec, respond
from ross_sim.study.evidence_scenes import (
    FULL,
    LEVEL,
    LOUDER_DB,
    PLACES,
    ROOMS,
    SNRS_DB,
    azimuths_around,
    draw_apart,
    number_of,
)
from ross_sim.study.exploration import BEFORE, FRAME, UNIT
from ross_sim.study.fit_talker_evidence import Descent, descent, main
from ross_sim.study.mixtures import RATE, SNR_DB
from ross_sim.study.room_settings import SPACING, SPEED_OF_SOUND
from ross_sim.study.turning_render import GRID, Speech, Turning, images, observed_turning

PERIODS = (2, 3, 4, 6)  # after which mixtures are fitted
RATES_DEG = (12.0, 20.0, 30.0)  # [deg/s]
SECONDS = UNIT * PERIODS[-1]
SCENES = {1: 2, 2: 4, 3: 6, 4: 7, 5: 8}  # in every room, by the number of talkers
SILENT = 12  # scenes of noise alone


@dataclass(frozen=True, slots=True, eq=False)
class TurningScene:
    """What the array hears while it turns, and who talks."""

    name: str
    heard: Samples  # (2, n)
    headings: Real  # at both ends of every quantum [rad], (n_quanta + 1,)
    azimuths: Real  # [rad], (k,)


def scenes(rooms: Sequence[str], voices: Sequence[Samples], seed: int, folder: Path | None) -> Iterator[TurningScene]:
    """Make the scenes of some rooms, or read those that ``folder`` keeps; voices are (n,) at `RATE`."""
    for index in range(SILENT):
        rng = np.random.default_rng([seed, index])
        headings = Turning(math.radians(rng.choice(RATES_DEG))).headings(SECONDS)
        noise = LEVEL * rng.standard_normal((2, round(SECONDS * RATE)))
        yield TurningScene(f"silent-0-{index}-{seed}", noise.astype(np.float32), headings, np.zeros(0))
    for room in rooms:
        names = [(k, n, f"turning-{room}-{k}-{n}-{seed}.npz") for k, count in SCENES.items() for n in range(count)]
        missing = folder is None or any(not (folder / name).exists() for _, _, name in names)
        azimuths, responses = simulated(room, seed) if missing else (np.zeros(0), np.zeros(0, np.float32))
        for k, n, name in names:
            path = None if folder is None else folder / name
            if path is not None and path.exists():
                with np.load(path, allow_pickle=False) as kept:
                    whole, headings, places = kept["x"], kept["h"], kept["az"]
            else:
                rng = np.random.default_rng([seed, number_of(room), k, n])
                whole, headings, places = mixed(azimuths, responses, voices, k, odd=n % 4 == 3, rng=rng)
                if path is not None:
                    np.savez(path, allow_pickle=False, x=whole, h=headings, az=places)
            short = name.removesuffix(".npz").removeprefix("turning-")
            yield TurningScene(short, whole.astype(np.float32) / FULL, headings, places)


def simulated(room: str, seed: int) -> tuple[Real, Samples]:
    """Azimuths [rad] of the places of a room, (n,), and the responses from there on `GRID`, (n_half, 2, n, n_taps)."""
    setting, rng = ROOMS[room], np.random.default_rng([seed, number_of(room)])
    azimuths = azimuths_around(PLACES, rng)
    places = tuple(map(tuple, setting.places(azimuths, rng).tolist()))
    spec = RoomSpec(setting.size, setting.t60, RATE, setting.centre, SPACING, places, SPEED_OF_SOUND)
    return azimuths, respond(spec, GRID.tolist())


def mixed(
    azimuths: Real, responses: Samples, voices: Sequence[Samples], k: int, *, odd: bool, rng: np.random.Generator
) -> tuple[Samples, Real, Real]:
    """What both microphones hear of ``k`` random voices, 16 bits (2, n), the headings, and the azimuths [rad], (k,)."""
    chosen = draw_apart(azimuths, k, rng)
    louder = 10 ** (rng.uniform(-LOUDER_DB, LOUDER_DB, k) / 20) if odd else np.ones(k)
    snr = rng.uniform(*SNRS_DB) if odd else SNR_DB
    talkers = [voices[index] for index in rng.permutation(len(voices))[:k]]
    headings, before = Turning(math.radians(rng.choice(RATES_DEG))).headings(SECONDS), round(BEFORE * RATE)
    n = round(SECONDS * RATE) + before
    speech = [Speech(np.resize(np.roll(voice, -int(rng.integers(len(voice)))), n), before) for voice in talkers]
    heard = images(speech, responses[:, :, chosen], headings, RATE)
    heard *= (louder / np.sqrt(np.mean(heard[:, 0] ** 2, axis=-1)))[:, None, None]
    mixture = heard.sum(axis=0)
    mixture += np.sqrt(np.mean(mixture[0] ** 2)) * 10 ** (-snr / 20) * rng.standard_normal(mixture.shape)
    whole = np.round(mixture * LEVEL / np.sqrt(np.mean(mixture**2)) * FULL)
    return np.clip(whole, -FULL, FULL).astype(np.int16), headings, azimuths[chosen]


def descents(scene: TurningScene, joint: Joint) -> Iterator[Descent]:
    """Explore a scene."""
    stft = Stft(RATE, FRAME, FRAME // 4)
    seen = list(observed_turning(cast(TurningExplorer, joint), stft, scene.heard, scene.headings, UNIT))
    for periods in PERIODS:
        yield descent(scene.name, scene.azimuths, joint, seen[:periods], periods)


def explored(rooms: Sequence[str], voices: Sequence[Samples], seed: int, folder: Path | None) -> Iterator[Descent]:
    """Explore the scenes of some rooms while turning; ``folder`` keeps the scenes."""
    joint = Joint(SPACING, SPEED_OF_SOUND)
    for scene in scenes(rooms, voices, seed, folder):
        yield from descents(scene, joint)


if __name__ == "__main__":
    sys.exit(main(None, explored, __doc__))
