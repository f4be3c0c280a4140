"""How far the study in a folder is, for whoever looks on: nothing is opened for writing."""

from __future__ import annotations

import fcntl
from dataclasses import dataclass
from pathlib import Path

from ross_sim.study.runs.shards import kind_of, manifest_in
from ross_sim.study.runs.study_run import in_words
from ross_sim.study.runs.study_store import journal


@dataclass(frozen=True, slots=True)
class StudyStatus:
    """How far a study is."""

    done: int
    total: int  # tasks of the whole study, also where the folder holds a shard of it
    running: bool
    idle_s: float  # since the last task was done

    @property
    def words(self) -> str:
        """A line for people.

        >>> StudyStatus(3, 12, True, 75.0).words
        '3 of 12 tasks are done (25 %), the last one 1 min 15 s ago; running'
        """
        last = f", the last one {in_words(self.idle_s)} ago" if self.done else ""
        doing = "running" if self.running else "complete" if self.done >= self.total else "not running"
        return (
            f"{self.done} of {self.total} tasks are done ({self.done / max(self.total, 1):.0%}){last}; {doing}".replace(
                "%", " %"
            )
        )


def status_of(folder: Path, now: float) -> StudyStatus:
    """Look into the folder of a study.

    Parameters
    ----------
    folder
        Of the study, or of a shard of it.
    now
        Time since 1970 [s].

    Raises
    ------
    ConfigError
        When it holds none.
    """
    kind, study = kind_of(manifest_in(folder), folder)
    done = sum(1 for _ in journal(folder, kind.decode))
    path = folder / "journal.jsonl"
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
            running = False
        except OSError:
            running = True
    return StudyStatus(done, len(kind.tasks(study)), running, max(now - path.stat().st_mtime, 0.0))
