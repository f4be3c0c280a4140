"""Talkers who move while the array listens: how well they are followed, and what that costs the target's voice.

``python -m ross_sim.study.moving_talkers --speech DIR [--draws 6] [--seed S] [--settings S1,S2] [--speeds 5,10]``

Every draw is a whole mission in lock-step: the array explores, turns to a talker and listens. From then on one talker
walks to and fro in the gap between two others, at least 25 degrees away from both and 60 degrees to either side at
most; the others stay. The same mission is flown again with a tracker that is told the true azimuths: what the target's
voice loses against that is what tracking costs.

Whoever is nearest is listened to (the voice print accepts everybody), so that the figures are about tracking alone.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.config import validated
from ross_payload.events import Event, OrientationHeard
from ross_payload.interfaces import Input, Real
from ross_payload.mission.source_tracking import SourceTracker
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_sim.scenario import Scenario
from ross_sim.sitl.mission_session import Finished, perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.talker_selection import TalkerSelection
from ross_sim.study.mixtures import spread
from ross_sim.study.room_settings import SETTINGS
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_voices import voices_of

RATE = 16000  # [Hz]
SETS_OUT, WALKS = 45.0, 60.0  # when somebody sets out, and for how long [s]
APART, WIDEST = 25.0, 60.0  # from the neighbours at least, and to either side at most [deg]
ANYBODY = -1e6  # criterion of a voice print that accepts everybody


@dataclass(frozen=True, slots=True)
class Row:
    """One mission, and the same with known azimuths."""

    setting: str
    speed_deg_s: float
    seed: int
    walker_is_target: bool
    walker_rms_deg: float  # of the azimuth while it walks
    others_rms_deg: float
    normalised: float  # root mean square of the walker's errors over their sigmas
    turns: int  # while listening
    explorations: int  # new ones while somebody walks
    si_sdr_db: float  # mean over the periods while somebody walks
    known_si_sdr_db: float  # the same with known azimuths
    followed: float  # share of the time in which the walker's error is below 15 deg

    @property
    def lost_db(self) -> float:
        """What is lost against known azimuths."""
        return self.known_si_sdr_db - self.si_sdr_db


class Counter(MissionView):
    """Counts explorations and small turns from the time on at which somebody sets out."""

    def __init__(self) -> None:
        self.explorations = self.turns = 0

    def on_event(self, event: Event, hop: Input) -> None:
        """Count."""
        if event.time >= SETS_OUT:
            self.explorations += isinstance(event, OrientationHeard) and event.index == 0
            self.turns += getattr(event, "reason", "") == "sources have moved"


def told(truth: Callable[[float], Real]) -> type[SourceTracker]:
    """Return a tracker that is told the true azimuth of every source at a mission time [s]."""

    class ToldTracker(SourceTracker):
        """Knows where everybody is."""

        def corrected(self, time: float) -> None:
            """Take the truth for what was heard."""
            SourceTracker.corrected(self, time)
            now, soon = truth(time), truth(time + 0.1)
            near = np.abs(difference(np.array([s.azimuth for s in self.anchor.sources])[:, None], truth(0.0))).argmin(1)
            shape = self.tracks.particles.rates.shape
            self.tracks = replace(
                self.tracks,
                particles=replace(
                    self.tracks.particles,
                    azimuths=np.broadcast_to(now[near], shape).copy(),
                    rates=np.broadcast_to(difference(soon, now)[near] * 10, shape).copy(),
                ),
            )
            self.moved = [bool(time >= SETS_OUT)] * self.anchor.k

    return ToldTracker


def staged(setting: str, speed: float, k: int, rng: np.random.Generator) -> tuple[Scenario, int]:
    """Draw a layout; return the scenario and who walks: the one with the widest gap between its neighbours."""
    azimuths = np.rad2deg(spread(k, rng))
    gaps = [np.sort((np.delete(azimuths, i) - azimuths[i]) % 360) for i in range(k)]
    walker = int(np.argmax([gap[0] + 360 - gap[-1] for gap in gaps]))
    ends = min(gaps[walker][0] - APART, WIDEST), max(gaps[walker][-1] - 360 + APART, -WIDEST)
    talkers: list[dict[str, object]] = [{"azimuth_deg": float(azimuth)} for azimuth in azimuths]
    path, time, off = [{"at_s": SETS_OUT, "azimuth_deg": float(azimuths[walker])}], SETS_OUT, 0.0
    while time < SETS_OUT + WALKS + 20:
        goal = ends[0] if len(path) % 2 else ends[1]
        time, off = time + abs(goal - off) / speed, goal
        path.append({"at_s": time, "azimuth_deg": float(azimuths[walker] + off)})
    talkers[walker]["path"] = path
    room = SETTINGS[setting]
    values = {
        "title": f"{setting}, {speed:g} deg/s",
        "room": {"size_m": room.size, "t60_s": room.t60},
        "talkers": talkers,
        "noise": {"snr_db": 15},
        "payload": {
            "audio": {"rate_hz": RATE},
            "explore": {"min_rotations": 4, "max_rotations": 6},
            "exploit": {"runs": 7, "criterion": ANYBODY},
        },
    }
    return validated(Scenario, values, "study"), walker


def row(setting: str, speed: float, k: int, seed: int, voices: Sequence[TalkerVoice]) -> Row:
    """Fly one mission twice."""
    rng = np.random.default_rng([seed, k])
    scenario, walker = staged(setting, speed, k, rng)
    chosen = tuple(voices[int(i)] for i in rng.choice(len(voices), k, replace=False))
    payload = scenario.payload.model_copy(update={"seed": seed})
    scenario = scenario.model_copy(update={"payload": payload})
    model = ModelFolder.default().in_use(payload.voice_print.model)
    company = TalkerSelection(chosen, chosen[0].name, enrol(chosen[0].enrolment, chosen[0].rate, model))

    def truth(time: float) -> Real:
        return np.array([wrap(float(azimuth)) for azimuth in scenario.azimuths_at(np.array([time]))[:, 0]])

    counter = Counter()
    heard = perform(scenario, company, counter, None, None)
    known = perform(scenario, company, MissionView(), None, None, tracker=told(truth))
    name = chosen[walker].name
    tracks = [each for each in heard.report["tracks"] if SETS_OUT <= each["time_s"] <= SETS_OUT + WALKS]
    mine = np.array([[t["azimuth_error_deg"], t["sigma_deg"]] for t in tracks if t["name"] == name]).reshape(-1, 2)
    rest = np.array([t["azimuth_error_deg"] for t in tracks if t["name"] not in (name, None)])
    target: list[str] = next((p["talkers"] for p in heard.report["periods"]), [])
    return Row(
        setting=setting,
        speed_deg_s=speed,
        seed=seed,
        walker_is_target=target == [name],
        walker_rms_deg=_rms(mine[:, 0]),
        others_rms_deg=_rms(rest),
        normalised=_rms(mine[:, 0] / mine[:, 1]),
        turns=counter.turns,
        explorations=counter.explorations,
        si_sdr_db=quality(heard),
        known_si_sdr_db=quality(known),
        followed=float(np.mean(np.abs(mine[:, 0]) < 15.0)) if len(mine) else math.nan,
    )


def quality(mission: Finished) -> float:
    """Mean SI-SDR [dB] of the target over the periods while somebody walks."""
    periods = [each for each in mission.report["periods"] if SETS_OUT < each["time_s"] <= SETS_OUT + WALKS + 10]
    values = [each["si_sdr_db"] for each in periods if each["si_sdr_db"] is not None]
    return float(np.mean(values)) if values else math.nan


def table(rows: Sequence[Row]) -> list[str]:
    """Lines of the table, one per room and speed."""
    lines = [
        "| room, speed | missions | walker, rms [deg] | median | others | within 15 deg | error / sigma | turns "
        "| new explorations | lost [dB] | median |",
        "| --- " * 11 + "|",
    ]
    for setting, speed in dict.fromkeys((each.setting, each.speed_deg_s) for each in rows):
        some = [each for each in rows if (each.setting, each.speed_deg_s) == (setting, speed)]
        errors, lost = np.array([each.walker_rms_deg for each in some]), np.array([each.lost_db for each in some])
        cells = [
            f"{setting}, {speed:g} deg/s",
            f"{len(some)}",
            f"{_rms(errors):.1f}",
            f"{np.median(errors):.1f}",
            f"{_rms(np.array([each.others_rms_deg for each in some])):.1f}",
            f"{100 * np.mean([each.followed for each in some]):.0f} %",
            f"{_rms(np.array([each.normalised for each in some])):.2f}",
            f"{np.mean([each.turns for each in some]):.1f}",
            f"{sum(each.explorations for each in some)}",
            f"{np.mean(lost):.1f}",
            f"{np.median(lost):.1f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _rms(values: Real) -> float:
    return float(np.sqrt(np.mean(np.asarray(values, dtype=float) ** 2))) if len(values) else math.nan


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one line per mission, and the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of recordings; default: synthetic voices")
    parser.add_argument("--draws", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0, help="of the first draw; the next have the next seeds")
    parser.add_argument("--settings", default="S1,S2", help="rooms, separated by commas")
    parser.add_argument("--speeds", default="5,10", help="[deg/s], separated by commas")
    parser.add_argument("--talkers", type=int, default=3)
    parser.add_argument("--json", type=Path, help="also write the rows there")
    asked = parser.parse_args(arguments)
    voices = voices_of(asked.speech, RATE)
    rows = []
    for setting in asked.settings.split(","):
        for speed in map(float, asked.speeds.split(",")):
            for seed in range(asked.seed, asked.seed + asked.draws):
                rows.append(row(setting, speed, asked.talkers, seed, voices))
                sys.stdout.write(f"{rows[-1]}\n")
                sys.stdout.flush()
    sys.stdout.write("\n".join(table(rows)) + "\n")
    if asked.json:
        asked.json.write_text(json.dumps([asdict(each) for each in rows], indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
