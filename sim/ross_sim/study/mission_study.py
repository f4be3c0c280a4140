"""Whole missions with random talkers: how many find everyone, recognise the target and gain enough, and why not.

``python -m ross_sim.study.mission_study --speech DIR [--draws 20] [--seed S] [--scenario demo]
[--set TABLE.KEY=VALUE]``
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

from ross_payload.config import validated
from ross_payload.interfaces import Real
from ross_payload.sessions.config_changes import assign
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_sim.scenario import Scenario, load
from ross_sim.sitl.mission_session import Finished, perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.talker_selection import TalkerSelection
from ross_sim.study.mixtures import spread
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_voices import voices_of

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
    heard_from_s: float | None  # mission time from which on the target is heard clean
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


def draw(scenario: Scenario, voices: Sequence[TalkerVoice], seed: int, same_layout: bool) -> Draw:
    """Fly one mission with random talkers, a random target and, unless told otherwise, random azimuths."""
    rng = np.random.default_rng(seed)
    chosen = [voices[int(i)] for i in rng.choice(len(voices), len(scenario.talkers), replace=False)]
    azimuths = spread(len(chosen), rng)
    if same_layout:
        azimuths = np.asarray(scenario.azimuths())
    talkers = tuple(
        talker.model_copy(update={"azimuth_deg": float(np.rad2deg(azimuth)), "name": None})
        for talker, azimuth in zip(scenario.talkers, azimuths, strict=True)
    )
    target = chosen[int(rng.integers(len(chosen)))]
    payload = scenario.payload.model_copy(update={"seed": seed})
    staged = scenario.model_copy(update={"talkers": talkers, "payload": payload})
    model = ModelFolder.default().in_use(payload.voice_print.model)
    company = TalkerSelection(tuple(chosen), target.name, enrol(target.enrolment, target.rate, model))
    return _judged(perform(staged, company, MissionView(), None, None), company, np.rad2deg(azimuths), seed)


def _judged(finished: Finished, company: TalkerSelection, azimuths: Real, seed: int) -> Draw:
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
        heard_from_s=values["heard_from_s"],
        right=bool(group and group["talkers"] == [company.target]),
        times_real_time=round(finished.timing["times_real_time"], 1),
    )


def changed(scenario: Scenario, settings: Sequence[str], talkers: int | None) -> Scenario:
    """Change keys of the payload, each "table.key=value" in TOML, and the number of talkers.

    Raises
    ------
    ConfigError
        When a key or a value is wrong.
    """
    values = scenario.model_dump()
    for setting in settings:
        assign(values["payload"], setting)
    if talkers is not None:
        values["talkers"] = [{"azimuth_deg": 360.0 * k / talkers} for k in range(talkers)]
    return validated(Scenario, values, "--set")


def summary(rows: Sequence[Draw]) -> str:
    """Count the draws that succeed; means of those whose target was heard."""
    heard = [row for row in rows if row.si_sdri_db is not None and row.heard_from_s is not None]
    found = sum(row.k == len(row.talkers) for row in rows)
    right = sum(row.right for row in rows)
    good = sum(not row.reason for row in rows)
    gain = np.mean([row.si_sdri_db or 0.0 for row in heard]) if heard else math.nan
    since = np.mean([row.heard_from_s or 0.0 for row in heard]) if heard else math.nan
    return (
        f"{good} of {len(rows)} succeed; K right {found}, target right {right}; "
        f"mean SI-SDRi {gain:.1f} dB, heard from {since:.1f} s on"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one line per draw and the count of those that succeed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of recordings; default: synthetic voices")
    parser.add_argument("--scenario", default="demo")
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1000, help="of the first draw; the next have the next seeds")
    parser.add_argument("--same-layout", action="store_true", help="keep the scenario's azimuths")
    parser.add_argument("--talkers", type=int, help="as many as this, at random azimuths, instead of the scenario's")
    parser.add_argument(
        "--set", action="append", default=[], help="change a key of the payload: explore.pipelined=true"
    )
    parser.add_argument("--json", type=Path, help="also write the rows there")
    asked = parser.parse_args(arguments)
    scenario = changed(load(asked.scenario), asked.set, asked.talkers)
    rate = scenario.payload.audio.rate_hz
    voices = voices_of(asked.speech, rate)
    rows = []
    for seed in range(asked.seed, asked.seed + asked.draws):
        rows.append(draw(scenario, voices, seed, asked.same_layout))
        _print(rows[-1])
    sys.stdout.write(summary(rows) + "\n")
    if asked.json:
        asked.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    return 0


def _print(row: Draw) -> None:
    who = " ".join(f"{name}@{azimuth:.0f}" for name, azimuth in zip(row.talkers, row.azimuths_deg, strict=True))
    error = "-" if row.worst_error_deg is None else f"{row.worst_error_deg:.2f}"
    gain = "-" if row.si_sdri_db is None else f"{row.si_sdri_db:.1f}"
    sys.stdout.write(
        f"{row.seed} {who} target {row.target}: K {row.k}, worst {error} deg, {gain} dB, "
        f"from {'-' if row.heard_from_s is None else f'{row.heard_from_s:.1f}'} s, "
        f"{row.times_real_time:.0f} x{'  FAILS: ' + row.reason if row.reason else ''}\n"
    )
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
