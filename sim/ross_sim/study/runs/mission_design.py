"""What a study of missions flies: its axes, the draws that they make, and the scenario of each draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from ross_payload.config import Table, validated
from ross_payload.errors import ConfigError, unknown
from ross_payload.interfaces import Real
from ross_payload.sessions.config_changes import assign
from ross_sim.scenario import Scenario, load, names
from ross_sim.study.rows.mission_rows import ABSENT, PRESENT
from ross_sim.study.runs.study_design import Seed
from ross_sim.study.scenes.mixtures import SNR_DB, spread
from ross_sim.study.scenes.room_settings import DISTANCE, FAR, HIGH, LOW, NEAR, SETTINGS
from ross_sim.talkers.speech import TalkerVoice

TRIES = 1000  # to place the talkers of a draw inside the room
TALKERS = 3  # in a setting, unless the study says how many


class MissionStudy(Table):
    """The axes of a study of missions; every combination of scenario and K is flown as often as it has draws."""

    scenarios: Annotated[tuple[str, ...], Field(min_length=1)] = ("living-room", "office", "hall")
    k: tuple[Annotated[int, Field(ge=1, le=8)], ...] = ()  # none: as many as the scenario has
    places: Literal["written", "drawn"] = "drawn"  # the scenario's azimuths, or random ones
    targets: Annotated[tuple[Literal["present", "absent"], ...], Field(min_length=1)] = ("present", "absent")
    draws: Annotated[int, Field(ge=1, le=10000)] = 20
    settings: tuple[str, ...] = ()  # changes of the payload, each "table.key=value"
    seed: Seed = 1000  # of the first draw; the next have the next seeds
    turns_heard: bool = True  # false: as `turns_heard` of a scenario's room

    @field_validator("scenarios", "k", "targets")
    @classmethod
    def _once(cls, values: tuple[Any, ...]) -> tuple[Any, ...]:
        if len(set(values)) < len(values):
            raise ValueError("names something twice")
        return values

    @model_validator(mode="after")
    def _places_of_whom(self) -> MissionStudy:
        if self.places == "written" and self.k:
            raise ValueError("places: expected drawn ones where K is asked for, got written")
        return self


@dataclass(frozen=True, slots=True)
class MissionTask:
    """The smallest piece of work that is kept: one draw, flown with every target that the study asks for."""

    scenario: str
    k: int
    draw: int

    @property
    def id(self) -> str:
        """What this task is called in the journal.

        >>> MissionTask("demo", 3, 7).id
        'demo-K3-D7'
        """
        return f"{self.scenario}-K{self.k}-D{self.draw}"

    @property
    def room(self) -> str:
        """A draw has a room of its own, or one that is kept on disk."""
        return self.id


def scenario_of(name: str, changes: Sequence[str] = ()) -> Scenario:
    """Load a built-in scenario or a file, or make one of a setting of the studies; change keys of its payload.

    >>> scenario_of("B0.45").room.size_m
    (6.0, 8.0, 3.0)

    Raises
    ------
    ConfigError
        When there is none of that name, or a key or value is wrong.
    """
    if name in SETTINGS:
        scenario = _of_setting(name)
    elif name.endswith(".toml") or name in names():
        scenario = load(name)
    else:
        raise ConfigError(unknown("scenario", name, [*names(), *SETTINGS]))
    values = scenario.model_dump()
    for change in changes:
        assign(values["payload"], change)
    return validated(Scenario, values, "--set")


def _of_setting(name: str) -> Scenario:
    """A room of the studies, the talkers as high and as far as theirs on average."""
    room = SETTINGS[name]
    place = {"distance_m": DISTANCE} if room.flat else {"distance_m": (NEAR + FAR) / 2, "height_m": (LOW + HIGH) / 2}
    values = {
        "title": name,
        "room": {"size_m": room.size, "t60_s": room.t60, "array_m": room.centre},
        "noise": {"snr_db": SNR_DB},
        "talkers": [{"azimuth_deg": 360.0 * index / TALKERS, **place} for index in range(TALKERS)],
    }
    return validated(Scenario, values, name)


def mission_tasks(study: MissionStudy) -> list[MissionTask]:
    """Every draw of a study once, in the order of its axes."""
    found = []
    for name in study.scenarios:
        counts = study.k or (len(scenario_of(name).talkers),)
        found += [MissionTask(name, k, draw) for k, draw in product(counts, range(study.draws))]
    return found


@dataclass(frozen=True, slots=True)
class Staging:
    """One draw: who talks where, and who is looked for when the target is present or absent."""

    scenario: Scenario
    talkers: tuple[TalkerVoice, ...]
    azimuths_deg: tuple[float, ...]
    wanted: dict[str, TalkerVoice]


def staged(study: MissionStudy, task: MissionTask, voices: Sequence[TalkerVoice]) -> Staging:
    """Draw talkers, places and targets; the first talker has the distance, height and level of the scenario's first.

    Raises
    ------
    ConfigError
        When there are too few voices, or the room has no place for so many talkers at these distances.
    """
    seed = study.seed + task.draw
    rng = np.random.default_rng(seed)
    chosen = [voices[int(index)] for index in rng.choice(len(voices), task.k, replace=False)]
    scenario = scenario_of(task.scenario, study.settings)
    if study.places == "drawn":
        scenario = _placed(scenario, task.k, rng)
    else:
        spread(task.k, rng)  # so that the target is that of the draw with drawn places
    target = chosen[int(rng.integers(len(chosen)))]
    others = [voice for voice in voices if voice not in chosen]
    wanted = {PRESENT: target} | ({ABSENT: others[int(rng.integers(len(others)))]} if others else {})
    payload = scenario.payload.model_copy(update={"seed": seed})
    talkers = tuple(talker.model_copy(update={"name": None}) for talker in scenario.talkers)
    room = scenario.room if study.turns_heard else scenario.room.model_copy(update={"turns_heard": False})
    final = scenario.model_copy(update={"payload": payload, "talkers": talkers, "room": room})
    return Staging(final, tuple(chosen), tuple(np.rad2deg(final.azimuths()).round(1).tolist()), wanted)


def _placed(scenario: Scenario, k: int, rng: np.random.Generator) -> Scenario:
    """The scenario with talkers at random azimuths, each at the distance and height of one of its own."""
    for _ in range(TRIES):
        azimuths: Real = np.rad2deg(spread(k, rng))
        talkers = tuple(
            scenario.talkers[index % len(scenario.talkers)].model_copy(
                update={"azimuth_deg": float(azimuth), "path": ()}
            )
            for index, azimuth in enumerate(azimuths)
        )
        placed = scenario.model_copy(update={"talkers": talkers})
        try:
            placed.spec()
        except ConfigError:
            continue
        return placed
    raise ConfigError(f"{scenario.title}: expected room for {k} talkers 25 deg apart, got none in {TRIES} draws")


def check_draws(study: MissionStudy, voices: Sequence[TalkerVoice]) -> None:
    """Check that every scenario is there, has talkers, and that there are enough voices for all.

    Raises
    ------
    ConfigError
        Says how many there must be, and are.
    """
    for name in study.scenarios:
        scenario = scenario_of(name, study.settings)
        if not scenario.talkers:
            raise ConfigError(f"{name}: expected a scenario with talkers, got one without")
        most = max(study.k or (len(scenario.talkers),)) + (ABSENT in study.targets)
        if len(voices) < most:
            raise ConfigError(f"{name}: expected {most} voices, one of them not in the room, got {len(voices)}")
