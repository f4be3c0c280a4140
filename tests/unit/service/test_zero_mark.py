"""A zero that was declared is not believed after a process that died while the array was away from it."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest

from rigs import Rig, rig_of
from ross_payload.errors import NotHomed
from ross_payload.service.zero_mark import ZeroMark
from waiting import wait_for

HOP: Any = None  # nothing of it counts


def marked(folder: Path, kind: str) -> tuple[Rig, ZeroMark]:
    rig = rig_of(kind)
    mark = ZeroMark(folder, rig.actuator)
    rig.actuator.__enter__()
    rig.clock.sleep(0.5)
    return rig, mark


def at(rig: Rig, mark: ZeroMark, goal: float) -> None:
    rig.actuator.command(goal)
    rig.settle(within=5.0)
    mark.on_input(HOP)


@pytest.mark.parametrize("kind", ["tb6600", "grbl"])
def test_a_declared_zero_is_not_believed_after_a_process_that_died_away_from_it(tmp_path: Path, kind: str) -> None:
    rig, mark = marked(tmp_path, kind)
    assert rig.state.homed
    at(rig, mark, 1.0)
    wait_for((tmp_path / "away").exists)
    rig, mark = marked(tmp_path, kind)
    mark.on_input(HOP)
    with pytest.raises(NotHomed):
        rig.actuator.command(0.5)
    rig.home()
    at(rig, mark, 0.0)
    wait_for(lambda: not (tmp_path / "away").exists())
    assert marked(tmp_path, kind)[0].state.homed


def test_an_orderly_end_leaves_the_zero_to_who_starts_again(tmp_path: Path) -> None:
    rig, mark = marked(tmp_path, "tb6600")
    at(rig, mark, 1.0)
    mark.forget()
    assert marked(tmp_path, "tb6600")[0].state.homed


def test_a_mark_that_found_no_thread_is_written_with_the_next_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    rig, mark = marked(tmp_path, "tb6600")
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refused)
        at(rig, mark, 1.0)
    mark.on_input(HOP)
    wait_for((tmp_path / "away").exists)
