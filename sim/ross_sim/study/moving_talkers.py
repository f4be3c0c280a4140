"""Talkers who move while the array listens: how well they are followed, and what that costs the target's voice.

``python -m ross_sim.study.moving_talkers --speech DIR [--start explored] [--draws 6] [--seed S] [--settings S1,S2]``

Every draw is a whole mission in lock-step: the array is told the true azimuths, or explores (``--start explored``),
turns to a talker and listens. From then on one talker walks to and fro in the gap between two others, at least
25 degrees away from both and 60 degrees to either side at most; the others stay. The same mission is flown again with a
tracker that is told the true azimuths all the time: what the target's voice loses against that is what tracking costs.
With ``--known FOLDER`` such missions are flown once, and what they gave is kept there.
With ``--tracker-alone`` every mission is flown once, and separated by the cheapest separator: nothing that is separated
acts on the tracks, since every score is accepted.

Whoever is nearest is listened to (the voice print accepts everybody), so that the figures are about tracking alone.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from ross_payload.angles import difference, wrap
from ross_payload.config import validated
from ross_payload.events import Event, OrientationHeard, Outcome
from ross_payload.interfaces import Input, Real
from ross_payload.localization.talker_motion import RATES, around
from ross_payload.localization.track_hypotheses import Hypothesis
from ross_payload.localization.tracking import PLACE
from ross_payload.mission.heading_hold import LOOKING, REALIGNED
from ross_payload.mission.source_tracking import SourceTracker
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_sim.scenario import Scenario
from ross_sim.sitl.mission_session import Finished, perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.talker_selection import TalkerSelection
from ross_sim.study.option_types import NATURAL, POSITIVE, CommaSeparated, argument
from ross_sim.study.rows.moving_rows import MovingRow, moving, rms
from ross_sim.study.rows.result_rows import number
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.scenes.mixtures import spread
from ross_sim.study.scenes.room_settings import SETTINGS, check_rooms
from ross_sim.study.script_errors import expect_writable, told_by, write_result
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_voices import voices_of

RATE = 16000  # [Hz]
SETS_OUT = {"true": 12.0, "explored": 45.0}  # when somebody sets out, by what is known at the start [s]
WALKS = 60.0  # for how long [s]
APART, WIDEST = 25.0, 60.0  # from the neighbours at least, and to either side at most [deg]
SLOWEST, FASTEST = 0.1, 180.0  # who walks [deg/s]
ANYBODY = -1e6  # criterion of a voice print that accepts everybody


@dataclass(frozen=True, slots=True)
class Case:
    """One mission that is flown: where, how fast somebody walks, and what is known at the start."""

    setting: str
    speed_deg_s: float
    seed: int
    k: int = 3
    start: str = "true"  # azimuths are told, or "explored"

    @property
    def sets_out(self) -> float:
        """When somebody sets out [s]."""
        return SETS_OUT[self.start]


class Counter(MissionView):
    """Counts explorations and small turns from the time on at which somebody sets out."""

    def __init__(self, since: float) -> None:
        self.since = since
        self.explorations = self.turns = 0

    def on_event(self, event: Event, hop: Input) -> None:
        """Count."""
        if event.time >= self.since:
            self.explorations += isinstance(event, OrientationHeard) and event.index == 0
            self.turns += getattr(event, "reason", "") in (REALIGNED, LOOKING)


def told(truth: Callable[[float], Real], sets_out: float) -> type[SourceTracker]:
    """Return a tracker that is told the true azimuth of every source at a mission time [s]."""

    class ToldTracker(SourceTracker):
        """Knows where everybody is."""

        def corrected(self, time: float) -> None:
            """Take the truth for what was heard."""
            SourceTracker.corrected(self, time)
            now, soon = truth(time - self.behind), truth(time - self.behind + 0.1)
            near = np.abs(difference(self.anchor.azimuths[:, None], truth(0.0))).argmin(1)
            rates = np.abs(RATES - difference(soon, now)[near, None] * 10).argmin(axis=1)
            left = {
                k: np.outer(np.eye(len(RATES))[rates[k]], around(float(now[near[k]]), PLACE)) for k in range(len(near))
            }
            self.tracks = replace(self.tracks, hypotheses=(Hypothesis(1.0, left, np.ones(len(near))),))
            self.moved = [bool(time >= sets_out)] * self.anchor.k

    return ToldTracker


def staged(case: Case, rng: np.random.Generator) -> tuple[Scenario, int]:
    """Draw a layout; return the scenario and who walks: the one with the widest gap between its neighbours."""
    azimuths = np.rad2deg(spread(case.k, rng))
    gaps = [np.sort((np.delete(azimuths, i) - azimuths[i]) % 360) for i in range(case.k)]
    walker = int(np.argmax([gap[0] + 360 - gap[-1] for gap in gaps]))
    ends = min(gaps[walker][0] - APART, WIDEST), max(gaps[walker][-1] - 360 + APART, -WIDEST)
    talkers: list[dict[str, object]] = [{"azimuth_deg": float(azimuth)} for azimuth in azimuths]
    path, time, off = [{"at_s": case.sets_out, "azimuth_deg": float(azimuths[walker])}], case.sets_out, 0.0
    while time < case.sets_out + WALKS + 20:
        goal = ends[0] if len(path) % 2 else ends[1]
        time, off = time + abs(goal - off) / case.speed_deg_s, goal
        path.append({"at_s": time, "azimuth_deg": float(azimuths[walker] + off)})
    talkers[walker]["path"] = path
    room = SETTINGS[case.setting]
    payload: dict[str, object] = {
        "audio": {"rate_hz": RATE},
        "explore": {"min_rotations": 4, "max_rotations": 6},
        "exploit": {"runs": 7, "criterion": ANYBODY},
    }
    if case.start == "true":
        payload["informed"] = {"azimuths_deg": azimuths.tolist()}
    values = {
        "title": f"{case.setting}, {case.speed_deg_s:g} deg/s",
        "room": {"size_m": room.size, "t60_s": room.t60},
        "talkers": talkers,
        "noise": {"snr_db": 15},
        "payload": payload,
    }
    return validated(Scenario, values, "study"), walker


def row(case: Case, voices: Sequence[TalkerVoice], kept: Path | None = None, *, alone: bool = False) -> MovingRow:
    """Fly one mission twice; what known azimuths give is kept in a folder, where there is one.

    For the tracker ``alone`` it is flown once, and there is no SI-SDR.
    """
    rng = np.random.default_rng([case.seed, case.k])
    scenario, walker = staged(case, rng)
    chosen = tuple(voices[int(i)] for i in rng.choice(len(voices), case.k, replace=False))
    exploit = scenario.payload.exploit
    if alone:
        exploit = exploit.model_copy(update={"separator": "duet"})
    payload = scenario.payload.model_copy(update={"seed": case.seed, "exploit": exploit})
    scenario = scenario.model_copy(update={"payload": payload})
    model = ModelFolder.default().in_use(payload.voice_print.model)
    company = TalkerSelection(chosen, chosen[0].name, enrol(chosen[0].enrolment, chosen[0].rate, model))
    counter, name = Counter(case.sets_out), chosen[walker].name
    heard = _whole(perform(scenario, company, counter, None, None))
    tracks = [each for each in heard.report["tracks"] if 0 <= each["time_s"] - case.sets_out <= WALKS]
    mine = np.array([[t["azimuth_error_deg"], t["sigma_deg"]] for t in tracks if t["name"] == name]).reshape(-1, 2)
    rest = np.array([t["azimuth_error_deg"] for t in tracks if t["name"] not in (name, None)])
    target: list[str] = next((p["talkers"] for p in heard.report["periods"]), [])
    return MovingRow(
        setting=case.setting,
        speed_deg_s=case.speed_deg_s,
        seed=case.seed,
        k=case.k,
        start=case.start,
        walker=name,
        walker_is_target=target == [name],
        walker_rms_deg=number(rms(mine[:, 0])),
        others_rms_deg=number(rms(rest)),
        normalised=number(rms(mine[:, 0] / mine[:, 1])),
        followed=number(float(np.mean(np.abs(mine[:, 0]) < 15.0))) if len(mine) else math.nan,
        turns=counter.turns,
        explorations=counter.explorations,
        si_sdr_db=None if alone else number(quality(heard, case)),
        known_si_sdr_db=None if alone else number(_known(case, scenario, company, kept)),
    )


def _known(case: Case, scenario: Scenario, company: TalkerSelection, kept: Path | None) -> float:
    """Mean SI-SDR [dB] of the target with a tracker that is told where everybody is."""
    names = "-".join(voice.name for voice in company.voices)
    setting, speed, seed = case.setting, case.speed_deg_s, case.seed
    file = None if kept is None else kept / f"{setting}-{speed:g}-{seed}-{case.start}-{names}.json"
    if file is not None and file.exists():
        return float(json.loads(file.read_text()))

    def truth(time: float) -> Real:
        return np.array([wrap(float(azimuth)) for azimuth in scenario.azimuths_at(np.array([time]))[:, 0]])

    mission = _whole(perform(scenario, company, MissionView(), None, None, tracker=told(truth, case.sets_out)))
    found = quality(mission, case)
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(found))
    return found


def _whole(mission: Finished) -> Finished:
    """A mission that was stopped, as Ctrl-C stops every mission, is no row of a study."""
    if mission.result.outcome is Outcome.STOPPED:
        raise KeyboardInterrupt
    return mission


def quality(mission: Finished, case: Case) -> float:
    """Mean SI-SDR [dB] of the target over the periods while somebody walks."""
    periods = [each for each in mission.report["periods"] if 0 < each["time_s"] - case.sets_out <= WALKS + 10]
    values = [each["si_sdr_db"] for each in periods if each["si_sdr_db"] is not None]
    return float(np.mean(values)) if values else math.nan


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--speech", type=Path, help="folder of recordings; default: synthetic voices")
    parser.add_argument("--start", choices=SETS_OUT, default="true", help="azimuths are told, or explored first")
    parser.add_argument("--draws", type=argument(POSITIVE), default=6)
    parser.add_argument(
        "--seed", type=argument(NATURAL), default=0, help="of the first draw; the next have the next seeds"
    )
    parser.add_argument(
        "--settings", type=argument(CommaSeparated()), default="S1,S2", help="rooms, separated by commas"
    )
    parser.add_argument(
        "--speeds",
        type=argument(CommaSeparated(float, low=SLOWEST, high=FASTEST)),
        default="5,10",
        help="[deg/s], separated by commas",
    )
    parser.add_argument("--talkers", type=argument(POSITIVE), default=3)
    parser.add_argument("--known", type=Path, help="folder where missions with known azimuths are kept")
    parser.add_argument("--tracker-alone", action="store_true", help="fly once: what is lost is not measured")
    parser.add_argument("--out", type=Path, help="file for the rows (.csv), for `ross study table`")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one line per mission, and the table; 130 when it was interrupted."""
    parser = _parser()
    asked = parser.parse_args(arguments)
    with told_by(parser):
        if asked.out:
            expect_writable(asked.out)
        check_rooms(asked.settings)
        voices = voices_of(asked.speech, RATE)
    rows: list[MovingRow] = []
    try:
        seeds = range(asked.seed, asked.seed + asked.draws)
        for setting, speed, seed in product(asked.settings, asked.speeds, seeds):
            case = Case(setting, speed, seed, asked.talkers, asked.start)
            rows.append(row(case, voices, asked.known, alone=asked.tracker_alone))
            sys.stdout.write(f"{rows[-1]}\n")
            sys.stdout.flush()
    except KeyboardInterrupt:
        sys.stderr.write(f"interrupted after {len(rows)} missions\n")
        return int(Outcome.STOPPED)
    sys.stdout.write(moving(rows).markdown())
    if asked.out:
        with told_by(parser):
            write_result(asked.out, as_csv(rows, MovingRow))
    return 0


if __name__ == "__main__":
    sys.exit(main())
