"""One run of a study of missions: `ross study missions`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import ross_payload
import ross_sim
import ross_sim.study
from ross_payload.config import validated
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_sim.scenario import Scenario
from ross_sim.study.rows.mission_rows import MissionResult, MissionRow, decode_missions
from ross_sim.study.rows.mission_table import missions
from ross_sim.study.rows.tables import Table
from ross_sim.study.runs.dask_engine import Basis
from ross_sim.study.runs.mission_design import MissionStudy, MissionTask, check_draws, mission_tasks, scenario_of
from ross_sim.study.runs.mission_draw import attempt_draw, voices_at
from ross_sim.study.runs.study_design import ALL, Shard, mixed
from ross_sim.study.runs.study_run import Work, carried_out, write_rows
from ross_sim.study.runs.study_store import Code, Store, manifest
from ross_sim.study.runs.talker_placement import heard_as
from ross_sim.study.runs.task_engine import EngineChoice

CODE: Code = {  # what the numbers depend on: everything that a mission in lock-step passes through
    ross_payload: (
        *(f"{room}/*.py" for room in ("config", "dsp", "localization", "separation", "alignment", "voiceprint")),
        *(f"{room}/*.py" for room in ("mission", "actuators", "actuators/*", "mount", "listening")),
        *(f"{room}/*.py" for room in ("audio", "audio/sinks", "calibration")),
        "localization/*.json",
        "localization/*.npz",
        "separation/*.npz",
        "voiceprint/*.npz",
        "service/assemble.py",
        "service/runner.py",
        "*.py",
    ),
    ross_sim: ("*.py", "acoustics/*.py", "talkers/*.py", "devices/*.py", "autopilot/*.py", "sitl/*.py"),
    ross_sim.study: (
        *("runs/mission_design.py", "runs/mission_draw.py", "rows/mission_rows.py"),
        *("scenes/mixtures.py", "scenes/room_settings.py"),
    ),
}


def conduct_missions(
    changes: dict[str, Any], *, out: Path, speech: Path | None, engine: EngineChoice, shard: Shard = ALL
) -> int:
    """Fly a study of missions or a shard of it, or what is left of that; returns the exit code."""
    study = validated(MissionStudy, changes, "ross study missions")
    speech = speech and speech.absolute()
    basis = Basis(partial(missions_manifest, study, speech), missions_manifest(study, speech))
    with Store(out, basis.wanted, decode_missions) as store:
        every: list[MissionTask] = shard.of_all(mission_tasks(study))
        left = mixed(task for task in every if task.id not in store.results)
        work = Work(partial(attempt_draw, study=study, speech=speech), left, len(every), basis, engine)
        return carried_out(work, store, lambda: write(store, study) if shard == ALL else [])


def missions_manifest(study: MissionStudy, speech: Path | None) -> dict[str, Any]:
    """Everything that the rows of a study depend on, as it is in this process.

    Raises
    ------
    ConfigError
        When scenarios or voices are not there, or too few.
    """
    scenarios = {name: scenario_of(name, study.settings) for name in study.scenarios}
    voices = voices_at(speech, min(scenario.payload.audio.rate_hz for scenario in scenarios.values()))
    check_draws(study, voices)
    wanted = manifest(study, heard_as(voices), CODE, [each for one in scenarios.values() for each in _plugins(one)])
    wanted["scenarios"] = {name: scenario.model_dump(mode="json") for name, scenario in scenarios.items()}
    models, choices = ModelFolder.default(), {each.payload.voice_print.model for each in scenarios.values()}
    wanted["voice models"] = {choice: models.in_use(choice).fingerprint for choice in sorted(choices)}
    return wanted


def _plugins(scenario: Scenario) -> list[tuple[str, str]]:
    """Group and name of the plug-ins that a mission in a scenario uses."""
    payload = scenario.payload
    return [
        ("ross_payload.explorers", payload.explore.method),
        ("ross_payload.separators", payload.exploit.separator),
        ("ross_payload.separators", payload.listening.separator),
        ("ross_payload.actuators", payload.actuator.kind),
        ("ross_sim.far_ends", payload.actuator.kind),
    ]


def write(store: Store[MissionResult], study: MissionStudy) -> list[Table]:
    """Write rows and table; the order of the rows is the study's, whatever came first."""
    done = [store.results[task.id] for task in mission_tasks(study) if task.id in store.results]
    rows = [row for result in done for row in result.missions]
    table = missions(rows)
    write_rows(store, "missions", rows, MissionRow)
    store.write("tables.md", table.markdown().encode())
    return [table]
