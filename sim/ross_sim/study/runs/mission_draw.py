"""One draw of a study of missions: flown as `ross sitl` flies, and judged by the truth."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

from ross_payload import __version__
from ross_payload.computing import computing
from ross_payload.errors import RossError
from ross_payload.voiceprint import enrol
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_sim.sitl.mission_session import Finished, perform
from ross_sim.sitl.mission_view import MissionView
from ross_sim.sitl.talker_selection import TalkerSelection
from ross_sim.study.rows.mission_rows import ABSENT, MISSED_DEG, PRESENT, MissionResult, MissionRow
from ross_sim.study.rows.result_rows import number
from ross_sim.study.runs.mission_design import MissionStudy, MissionTask, Staging, scenario_of, staged
from ross_sim.study.runs.study_case import Failure
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_voices import voices_of


@lru_cache(maxsize=4)
def voices_at(folder: Path | None, rate: int) -> tuple[TalkerVoice, ...]:
    """Read the voices, once in every process."""
    return voices_of(folder, rate)


def attempt_draw(task: MissionTask, study: MissionStudy, speech: Path | None) -> MissionResult | Failure:
    """Fly one draw; one that fails does not take the others with it."""
    try:
        return fly(task, study, speech)
    except RossError as error:
        return Failure(task.id, str(error))
    except Exception as error:
        return Failure(task.id, repr(error))


def fly(task: MissionTask, study: MissionStudy, speech: Path | None) -> MissionResult:
    """Fly the missions of a draw, one for every target, on one thread: draws have the other cores.

    The impulse responses of a room that is drawn serve no other draw: they are kept until both missions are over.
    """
    rate = scenario_of(task.scenario, study.settings).payload.audio.rate_hz
    staging = staged(study, task, voices_at(speech, rate))
    if study.places == "written":
        with computing(threads=1):
            return MissionResult(task.id, tuple(_mission(task, study, staging, target) for target in study.targets))
    with TemporaryDirectory(prefix="ross-rooms-") as cache, computing(threads=1):
        rows = [_mission(task, study, staging, target, Path(cache)) for target in study.targets]
    return MissionResult(task.id, tuple(rows))


def _mission(
    task: MissionTask, study: MissionStudy, staging: Staging, target_is: str, cache: Path | None = None
) -> MissionRow:
    target, payload = staging.wanted[target_is], staging.scenario.payload
    model = ModelFolder.default().in_use(payload.voice_print.model)
    voiceprint = enrol(target.enrolment, target.rate, model)
    scenario = staging.scenario
    if target_is == ABSENT:  # the first voice that is in no part
        scenario = scenario.model_copy(update={"target": len(staging.talkers)})
    else:
        scenario = scenario.model_copy(update={"target": target.name})
    voices = (*staging.talkers, *([] if target in staging.talkers else [target]))
    company = TalkerSelection(voices, target.name, voiceprint)
    finished = perform(scenario, company, MissionView(), None, None, cache=cache)
    if finished.report["outcome"] == "stopped":  # by Ctrl-C, which asks every mission to stop
        raise KeyboardInterrupt
    return _judged(finished, task, study, staging, target_is)


def _judged(finished: Finished, task: MissionTask, study: MissionStudy, staging: Staging, target_is: str) -> MissionRow:
    values = finished.report
    names = tuple(voice.name for voice in staging.talkers)
    errors = {source["name"]: abs(source["azimuth_error_deg"]) for source in values["sources"] if source["name"]}
    group = next((group for group in values["groups"] if group["target"]), None)
    right = bool(group and group["talkers"] == [values["target"]])
    if target_is == ABSENT:
        right = values["outcome"] == "no_target"
    heard = values["outcome"] == "target_found" and target_is == PRESENT
    return MissionRow(
        task=task.id,
        scenario=task.scenario,
        k=task.k,
        draw=task.draw,
        seed=study.seed + task.draw,
        version=__version__,
        target_is=target_is,
        talkers=names,
        azimuths_true_deg=staging.azimuths_deg,
        target=values["target"],
        outcome=values["outcome"],
        target_right=right,
        k_estimated=values["k"],
        errors_deg=tuple(errors.get(name, MISSED_DEG) for name in names),
        rotations=values["rotations"],
        restarts=values["restarts"],
        heard_from_s=values["heard_from_s"] if heard else None,
        right_from_s=values["right_from_s"] if target_is == PRESENT else None,
        si_sdri_db=number(group["si_sdri_db"]) if heard and group else None,
        mission_s=values["mission_s"],
        cpu_s=round(finished.timing["payload_cpu_s"], 3),
    )
