"""How well the explorer counts and places talkers: `python -m ross_sim.study.exploration --speech DIR`.

K talkers of equal power at microphone 1, at least 25 deg apart, speak from random places of their recordings around the
array in the middle of a room (`rooms`); white noise is 15 dB below the mixture. The array listens 3 s at every
orientation and turns 15 deg in between; nobody tells K but `--known`. A row gives, over all K: how often K is right,
how often K is right and all azimuths are within 10 deg, how many talkers are found within 10 deg, and the mean error of
those.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.signal import oaconvolve
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.angles import difference
from ross_payload.dsp.joint import Joint
from ross_payload.dsp.stft import Stft
from ross_payload.events import Estimate
from ross_payload.interfaces import Explorer, Real, Samples
from ross_sim.speech import load_folder
from ross_sim.study.rooms import PLANES, SETTINGS, SPACING, SPEED_OF_SOUND, Setting

TALKERS = ("ls3005", "ls3331", "ls2414", "ls3080", "ls533")
COUNTS = (2, 3, 4, 5)  # K
APART = np.deg2rad(25.0)
SNR_DB = 15.0  # mixture over noise, at microphone 1
RATE, FRAME = 24000, 1024
UNIT, STEP = 3.0, np.deg2rad(15.0)  # [s], [rad]
BEFORE = 1.0  # of speech before every orientation, so that its reverberation is there [s]
NEAR_DEG = 10.0
WORKERS = 2


@dataclass(frozen=True, slots=True)
class Task:
    """One layout of talkers in one room, and who looks for them."""

    setting: str
    k: int
    layout: int
    seed: int
    explorer: str = "joint"
    known: bool = False  # the explorer is told K; `joint` only


@dataclass(frozen=True, slots=True)
class Row:
    """What the explorer believes of one layout after some rotations."""

    setting: str
    k: int
    layout: int
    rotations: int
    found: int  # K as estimated
    errors_deg: tuple[float, ...]  # per talker; 180 when missed
    scaled: tuple[float, ...]  # error over sigma of the talkers found within 10 deg
    stopped: bool  # by the explorer's own stop rule, else after a fixed number
    cost: float  # CPU seconds per second of audio

    @property
    def right(self) -> bool:
        """K is right and every azimuth is near."""
        return self.found == self.k and max(self.errors_deg) <= NEAR_DEG


def layout_of(k: int, rng: np.random.Generator) -> Real:
    """Draw azimuths [rad], (k,), uniform on the circle and at least 25 deg apart."""
    while True:
        azimuths = rng.uniform(-np.pi, np.pi, k)
        apart = np.abs(difference(azimuths[:, None], azimuths)) + 2 * np.pi * np.eye(k)
        if apart.min() >= APART:
            return azimuths


def render(
    voices: Sequence[Samples],
    azimuths: Real,
    setting: Setting,
    headings: Real,
    rng: np.random.Generator,
    *,
    seconds: float = UNIT,
    rate: int = RATE,
) -> Real:
    """What both microphones hear for some seconds at every heading, (n_headings, 2, n_samples)."""
    unit, before = round(seconds * rate), round(BEFORE * rate)
    places = setting.places(azimuths, np.random.default_rng(np.abs(azimuths * 1e6).astype(int)))
    responses = setting.responses(places, headings.tolist(), rate)
    heard = np.zeros((len(headings), 2, unit))
    for source, voice in enumerate(voices):
        speech = np.resize(np.roll(voice, -int(rng.integers(len(voice)))), unit * len(headings) + before)
        pieces = np.stack([speech[r * unit : (r + 1) * unit + before] for r in range(len(headings))])
        image = oaconvolve(pieces[:, None], responses[:, :, source], axes=-1)[..., before : before + unit]
        heard += image / np.sqrt(np.mean(image[:, 0] ** 2))
    noise = np.sqrt(np.mean(heard[:, 0] ** 2)) * 10 ** (-SNR_DB / 20)
    mixture = heard + noise * rng.standard_normal(heard.shape)
    return np.asarray(0.05 / np.sqrt(np.mean(mixture**2)) * mixture)


def matched(azimuths: Real, estimate: Estimate) -> tuple[Real, Real]:
    """Error [deg] and sigma [deg] of every talker's own estimate, (k,); 180 and infinite for a talker without one."""
    errors, sigmas = np.full(len(azimuths), 180.0), np.full(len(azimuths), np.inf)
    found = np.array([source.azimuth for source in estimate.sources])
    apart = np.rad2deg(np.abs(difference(azimuths[:, None], found)))
    talkers, sources = linear_sum_assignment(np.minimum(apart, 60.0))
    errors[talkers] = apart[talkers, sources]
    sigmas[talkers] = [np.rad2deg(estimate.sources[source].sigma) for source in sources]
    return errors, sigmas


def explore(task: Task, voices: Sequence[Samples], rotations: Sequence[int]) -> list[Row]:
    """Explore one layout; one row per number of rotations."""
    rng = np.random.default_rng([task.seed, task.k, task.layout])  # every room has the same layouts
    azimuths = layout_of(task.k, rng)
    chosen = [voices[i] for i in rng.permutation(len(voices))[: task.k]]
    headings = STEP * np.arange(max(rotations) + 1)
    heard = render(chosen, azimuths, SETTINGS[task.setting], headings, rng).astype(np.float32)
    stft = Stft(RATE, FRAME, FRAME // 4)
    explorer: Explorer = plugins.load("ross_payload.explorers", task.explorer).make(SPACING, SPEED_OF_SOUND)
    told = explorer if task.known and isinstance(explorer, Joint) else None
    observations, rows, stopped, began = [], [], False, time.process_time()
    for r, heading in enumerate(headings):
        observations.append(explorer.observe(stft.analyse(heard[r]), stft.frequencies, float(heading), None))
        if told and r not in rotations:
            continue
        estimate = told.place(observations, task.k) if told else explorer.estimate(observations)
        cost = (time.process_time() - began) / (UNIT * (r + 1))
        row = partial(_row, task, azimuths, r, estimate, cost)
        if not stopped and (estimate.certain or r == max(rotations)):
            stopped = True
            rows.append(row(stopped=True))
        if r in rotations:
            rows.append(row(stopped=False))
    return rows


def _row(task: Task, azimuths: Real, rotations: int, estimate: Estimate, cost: float, *, stopped: bool) -> Row:
    errors, sigmas = matched(azimuths, estimate)
    near = errors <= NEAR_DEG
    scaled = tuple((errors[near] / sigmas[near]).tolist())
    return Row(task.setting, task.k, task.layout, rotations, estimate.k, tuple(errors.tolist()), scaled, stopped, cost)


def table(rows: Sequence[Row]) -> str:
    """One line per number of rotations and setting, those of the stop rule last."""
    lines = ["rotations  room   K right   all right   recall   error [deg]   error/sigma (rms)   all right by K"]
    fixed = [row for row in rows if not row.stopped]
    settings = list(dict.fromkeys(row.setting for row in rows))
    for count, setting in product(sorted({row.rotations for row in fixed}, reverse=True), settings):
        chosen = [row for row in fixed if row.rotations == count and row.setting == setting]
        lines.append(f"{count:9d}  {setting:4s}  {_summary(chosen)}")
    for setting in settings:
        chosen = [row for row in rows if row.stopped and row.setting == setting]
        lines.append(f"stop {np.mean([row.rotations for row in chosen]):4.1f}  {setting:4s}  {_summary(chosen)}")
    last = max(row.rotations for row in fixed)
    cost = np.mean([row.cost for row in fixed if row.rotations == last])
    return "\n".join([*lines, f"CPU per second of audio, everything: {cost:.4f} s"])


def _summary(rows: Sequence[Row]) -> str:
    errors = np.concatenate([row.errors_deg for row in rows])
    scaled = np.concatenate([row.scaled for row in rows])
    by_k = " ".join(
        f"K{k} {np.mean([row.right for row in rows if row.k == k]):.2f}" for k in sorted({row.k for row in rows})
    )
    return (
        f"{np.mean([row.found == row.k for row in rows]):8.2f}  {np.mean([row.right for row in rows]):10.2f}"
        f"  {np.mean(errors <= NEAR_DEG):7.3f}  {np.mean(errors[errors <= NEAR_DEG]):12.2f}"
        f"  {np.sqrt(np.mean(scaled**2)):18.2f}   {by_k}"
    )


def sweep(tasks: Sequence[Task], voices: Sequence[Samples], rotations: Sequence[int]) -> list[Row]:
    """Explore every layout, in two processes with one numeric thread each."""
    with ProcessPoolExecutor(WORKERS, initializer=threadpool_limits, initargs=(1,)) as pool:
        return [row for rows in pool.map(partial(explore, voices=voices, rotations=rotations), tasks) for row in rows]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, default=Path("../shared/speech"), help="folder of recordings")
    parser.add_argument("--rooms", nargs="+", choices=tuple(SETTINGS), default=list(PLANES))
    parser.add_argument("--explorer", choices=("joint", "markov", "markov-plain"), default="joint")
    parser.add_argument("--known", action="store_true", help="tell the explorer K; joint only")
    parser.add_argument("--counts", type=int, nargs="+", choices=COUNTS, default=list(COUNTS), help="of talkers, K")
    parser.add_argument("--layouts", type=int, default=14, help="per K and room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rotations", type=int, nargs="+", default=[2, 4, 8, 12])
    parser.add_argument("--quick", action="store_true", help="3 layouts, 4 rotations")
    parser.add_argument("--json", type=Path, help="also write the rows there")
    asked = parser.parse_args(arguments)
    count, rotations = (3, [4]) if asked.quick else (asked.layouts, asked.rotations)
    voices = {voice.name: voice.speech for voice in load_folder(asked.speech, RATE)}
    chosen = [voices[name] for name in TALKERS if name in voices] or list(voices.values())
    counts = [k for k in asked.counts if k <= len(chosen)]
    tasks = [
        Task(setting, k, n, asked.seed, asked.explorer, asked.known)
        for setting, k, n in product(asked.rooms, counts, range(count))
    ]
    rows = sweep(tasks, chosen, rotations)
    sys.stdout.write(table(rows) + "\n")
    if asked.json:
        asked.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
