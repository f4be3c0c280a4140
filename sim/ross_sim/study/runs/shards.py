"""A study in parts: every computer does a share of its tasks, and the shares become one study again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ross_payload.bounded_files import parsed_json, read_bounded
from ross_payload.config import validated
from ross_payload.errors import ConfigError, reason
from ross_sim.study.rows.mission_rows import decode_missions
from ross_sim.study.rows.result_rows import decode
from ross_sim.study.rows.tables import Table
from ross_sim.study.runs import missions_run, study_run
from ross_sim.study.runs.mission_design import MissionStudy, mission_tasks
from ross_sim.study.runs.study_design import Study, tasks
from ross_sim.study.runs.study_store import Store, difference, journal
from ross_sim.study.runs.task_engine import Named


@dataclass(frozen=True, slots=True)
class Kind:
    """What there is to know of a kind of study to put its rows together."""

    tasks: Callable[[Any], Sequence[Named]]
    decode: Callable[[dict[str, Any]], Any]
    write: Callable[[Store[Any], Any], list[Table]]
    study: type[Any]


SEPARATORS = Kind(tasks, decode, study_run.write, Study)
MISSIONS = Kind(mission_tasks, decode_missions, missions_run.write, MissionStudy)


def merge(shards: Sequence[Path], out: Path) -> list[Table]:
    """Put the folders of all shards of a study together; return its tables.

    Nothing is written before everything has been read and found to belong together. The rows are those of the study
    done at once, in the same order.

    Raises
    ------
    ConfigError
        When a folder holds no study or another one, a task is in two of them, or in none.
    OutputError
        When the disk is full or gone.
    """
    if out.resolve() in {shard.resolve() for shard in shards}:
        raise ConfigError(f"--out {out}: expected another folder than those of the shards")
    wanted = manifest_in(shards[0])
    kind, study = kind_of(wanted, shards[0])
    found: dict[str, Any] = {}
    origin: dict[str, Path] = {}
    for shard in shards:
        other = difference(manifest_in(shard), wanted)
        if other:
            raise ConfigError(f"{shard}: expected the study of {shards[0]}, got another one: {other}")
        for result in journal(shard, kind.decode):
            if result.task in origin:
                raise ConfigError(
                    f"{shard}: expected tasks that no other shard has, got '{result.task}' of {origin[result.task]}"
                )
            origin[result.task], found[result.task] = shard, result
    names = [task.id for task in kind.tasks(study)]
    missing = [name for name in names if name not in found]
    if missing:
        raise ConfigError(
            f"expected all {len(names)} tasks of the study, got {len(names) - len(missing)}: '{missing[0]}' is in no "
            "shard; give the command of its shard again"
        )
    with Store(out, wanted, kind.decode) as store:
        for name in names:
            if name not in store.results:
                store.add(found[name])
        return kind.write(store, study)


def kind_of(manifest: dict[str, Any], folder: Path) -> tuple[Kind, Any]:
    """Return of what kind the study in a folder is, and the study.

    Raises
    ------
    ConfigError
        When it is none.
    """
    kind = MISSIONS if "scenarios" in manifest else SEPARATORS
    return kind, validated(kind.study, manifest["study"], str(folder / "study.json"))


def manifest_in(shard: Path) -> dict[str, Any]:
    """Return the manifest of the study in a folder.

    Raises
    ------
    ConfigError
        When there is none.
    """
    path = shard / "study.json"
    try:
        found = parsed_json(read_bounded(path))
    except (OSError, ValueError) as error:
        why = f"got nothing that can be read: {reason(error)}"
        raise ConfigError(f"{path}: expected what a shard belongs to, {why}") from error
    if not isinstance(found, dict) or not isinstance(found.get("study"), dict):
        raise ConfigError(f"{path}: expected what a shard belongs to, got something else")
    return found
