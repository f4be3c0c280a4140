"""Whole missions with random talkers: how many find everyone, recognise the target and gain enough, and why not.

``python -m ross_sim.study.missions --speech DIR [--draws 20] [--seed S] [--scenario demo] [--layouts random]``
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ross_payload.angles import difference
from ross_payload.interfaces import Real
from ross_payload.voiceprint import enrol
from ross_sim.casting import Company
from ross_sim.live import Silent
from ross_sim.scenario import Scenario, load
from ross_sim.session import Finished, perform
from ross_sim.speech import Voice, load_folder
from ross_sim.voices import synthetic_voices

APART = math.radians(25)  # talkers closer than this are not asked for [rad]
NEAR = 5.0  # an azimuth is found within this [deg]
GAIN = 12.0  # wanted SI-SDRi [dB]


@dataclass(frozen=True, slots=True)
class Draw:
    """One mission and what became of it."""

    seed: int
    talkers: tuple[str, ...]
    azimuths_deg: tuple[float, ...]
    target: str
    outcome: str
    k: int
    worst_error_deg: float | None
    si_sdri_db: float | None
    right: bool  # the group taken for the target holds the target
    times_real_time: float

    @property
    def reason(self) -> str:
        """Why this draw does not succeed; empty when it does."""
        if self.k != len(self.talkers):
            return f"K = {self.k}"
        if self.worst_error_deg is None or self.worst_error_deg > NEAR:
            return "azimuth"
        if self.outcome != "target_found":
            return self.outcome
        if not self.right:
            return "wrong voice"
        return "" if self.si_sdri_db is not None and self.si_sdri_db > GAIN else "gain"


def layout(rng: np.random.Generator, k: int) -> Real:
    """Random azimuths [rad], at least 25 degrees apart, (k,)."""
    while True:
        azimuths = rng.uniform(-np.pi, np.pi, k)
        apart = np.abs(difference(azimuths[:, None], azimuths[None])) + 2 * np.pi * np.eye(k)
        if apart.min() >= APART:
            return azimuths


def draw(scenario: Scenario, voices: Sequence[Voice], seed: int, same_layout: bool) -> Draw:
    """Fly one mission with random talkers, a random target and, unless told otherwise, random azimuths."""
    rng = np.random.default_rng(seed)
    chosen = [voices[int(i)] for i in rng.choice(len(voices), len(scenario.talkers), replace=False)]
    azimuths = layout(rng, len(chosen))
    if same_layout:
        azimuths = np.asarray(scenario.azimuths())
    talkers = tuple(
        talker.model_copy(update={"azimuth_deg": float(np.rad2deg(azimuth)), "name": None})
        for talker, azimuth in zip(scenario.talkers, azimuths, strict=True)
    )
    target = chosen[int(rng.integers(len(chosen)))]
    payload = scenario.payload.model_copy(update={"seed": seed})
    staged = scenario.model_copy(update={"talkers": talkers, "payload": payload})
    company = Company(tuple(chosen), target.name, enrol(target.enrolment, target.rate))
    return _judged(perform(staged, company, Silent(), None, None), company, np.rad2deg(azimuths), seed)


def _judged(finished: Finished, company: Company, azimuths: Real, seed: int) -> Draw:
    values = finished.report
    errors = [abs(source["azimuth_error_deg"] or 0.0) for source in values["sources"] if source["name"]]
    group = next((group for group in values["groups"] if group["target"]), None)
    return Draw(
        seed=seed,
        talkers=tuple(voice.name for voice in company.voices),
        azimuths_deg=tuple(round(float(azimuth), 1) for azimuth in azimuths),
        target=company.target,
        outcome=values["outcome"],
        k=values["k"],
        worst_error_deg=max(errors, default=None),
        si_sdri_db=group["si_sdri_db"] if group else None,
        right=bool(group and group["talkers"] == [company.target]),
        times_real_time=round(finished.timing["times_real_time"], 1),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one line per draw and the count of those that succeed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of recordings; default: synthetic voices")
    parser.add_argument("--scenario", default="demo")
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1000, help="of the first draw; the next have the next seeds")
    parser.add_argument("--same-layout", action="store_true", help="keep the scenario's azimuths")
    parser.add_argument("--json", type=Path, help="also write the rows there")
    asked = parser.parse_args(arguments)
    scenario = load(asked.scenario)
    rate = scenario.payload.audio.rate_hz
    voices = load_folder(asked.speech, rate) if asked.speech else synthetic_voices(rate)
    rows = []
    for seed in range(asked.seed, asked.seed + asked.draws):
        rows.append(draw(scenario, voices, seed, asked.same_layout))
        _print(rows[-1])
    good = [row for row in rows if not row.reason]
    gains = [row.si_sdri_db for row in rows if row.si_sdri_db is not None]
    sys.stdout.write(
        f"{len(good)} of {len(rows)} succeed; mean SI-SDRi {np.mean(gains) if gains else math.nan:.1f} dB\n"
    )
    if asked.json:
        asked.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    return 0


def _print(row: Draw) -> None:
    who = " ".join(f"{name}@{azimuth:.0f}" for name, azimuth in zip(row.talkers, row.azimuths_deg, strict=True))
    error = "-" if row.worst_error_deg is None else f"{row.worst_error_deg:.2f}"
    gain = "-" if row.si_sdri_db is None else f"{row.si_sdri_db:.1f}"
    sys.stdout.write(
        f"{row.seed} {who} target {row.target}: K {row.k}, worst {error} deg, {gain} dB, "
        f"{row.times_real_time:.0f} x{'  FAILS: ' + row.reason if row.reason else ''}\n"
    )
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
