"""What a study measures: its axes, its presets, and the tasks that they make."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import ConfigDict, Field, field_validator

from ross_payload import plugins
from ross_payload.config import Explore, Positive, Table, read_toml, validated
from ross_payload.dsp.stft import Stft, separation_frame
from ross_payload.errors import ConfigError, unknown
from ross_payload.plugin_checks import CheckedExplorer, checked_explorer, load_separator
from ross_sim.cache import fingerprint
from ross_sim.study.oracle_separators import ORACLES
from ross_sim.study.rows.exploration_ends import STOP
from ross_sim.study.scenes.room_settings import PLANES, SETTINGS, SPACING, SPEED_OF_SOUND

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

AnyTask = TypeVar("AnyTask", bound="DataclassInstance")
Frame = Annotated[int, Field(ge=128, le=8192, multiple_of=2)]
Overlap = Annotated[float, Field(ge=0.25, le=0.9)]
Seed = Annotated[int, Field(ge=0, lt=2**62)]  # rows have 64 bits for it, also when draws count on from there
SLOWEST_DEG_S = 5.0  # of a payload that turns without a pause
MOST_TASKS = 200_000  # of a study: all of them are held in memory, and put in order, before the first one begins


class Study(Table):
    """The axes of a study and what all its cases share; every combination of the axes is a case."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    settings: Annotated[tuple[str, ...], Field(min_length=1)] = PLANES  # rooms
    k: Annotated[tuple[Annotated[int, Field(ge=1, le=8)], ...], Field(min_length=1)] = (3, 4, 5)  # talkers
    layouts: Annotated[int, Field(ge=0)] = 5  # random ones
    paper_layout: bool = True  # the paper's layout comes first; K up to 5
    starts: Annotated[int, Field(ge=1, le=180)] = 1  # start headings, evenly over half a turn
    separators: tuple[str, ...] = ("duet", "auxiva", "gaussian")  # plug-ins and oracles; none: explore only
    noise: Annotated[tuple[Literal["known", "unknown"], ...], Field(min_length=1)] = ("known",)  # to the separators
    explorers: tuple[str, ...] = ("joint",)  # none: true azimuths only
    unit_s: Annotated[tuple[Annotated[float, Field(ge=0.2, le=60)], ...], Field(min_length=1)] = (3.0,)  # T_unit
    rotations: Annotated[tuple[Annotated[int, Field(ge=1, le=24)] | Literal["stop"], ...], Field(min_length=1)] = (12,)
    tell_k: bool = False  # the explorer is told K; `joint` only
    step_deg: Annotated[float, Field(ge=1, le=90)] = 15.0  # one rotation
    turning_deg_s: Annotated[tuple[Annotated[float, Field(ge=0, le=90)], ...], Field(min_length=1)] = (
        0.0,  # how fast the array turns without a pause; 0: it turns step by step
    )
    turn_deg: Annotated[float, Field(ge=90, le=3600)] = 540.0  # how far, back and forth
    run_s: Annotated[float, Field(ge=1, le=60)] = 10.0  # T_run
    rate_hz: Annotated[int, Field(ge=8000, le=48000)] = 24000
    frame: Frame | None = None  # of the separation [samples]; absent: as in the payload, a power of two near 0.1 s
    overlap: Overlap = 0.75
    explore_frame: Frame = 1024
    explore_overlap: Overlap = 0.75
    max_rotations: Annotated[int, Field(ge=1, le=24)] = 12  # when no schedule is longer
    rules: Literal["best", "paper"] = "best"  # where to turn: best predicted gain, or the paper's equations
    limit_deg: Positive = 200.0  # how far the joint may turn from the start, on either side
    talkers: tuple[str, ...] = ()  # of the folder; none: all
    seed: Seed = 0

    @field_validator("settings", "k", "separators", "noise", "explorers", "unit_s", "rotations", "turning_deg_s")
    @classmethod
    def _once(cls, values: tuple[Any, ...]) -> tuple[Any, ...]:
        if len(set(values)) < len(values):
            raise ValueError("names something twice")
        return values

    @property
    def last(self) -> int:
        """The largest number of rotations: that of the longest schedule."""
        fixed = [count for count in self.rotations if isinstance(count, int)]
        return max([*fixed, *([self.max_rotations] if STOP in self.rotations else [])])

    def periods(self, rate: float, unit: float) -> int:
        """T_unit ``unit`` [s] in the whole turn at ``rate`` [deg/s]."""
        return Explore(continuous=True, rate_deg_s=rate, turn_deg=self.turn_deg, unit_s=unit).periods

    @property
    def step(self) -> float:
        """One rotation [rad]."""
        return float(np.deg2rad(self.step_deg))

    @property
    def stft(self) -> Stft:
        """The transform of the separation."""
        return _transform(self.rate_hz, self.frame or separation_frame(self.rate_hz), self.overlap)

    @property
    def explorer_stft(self) -> Stft:
        """The transform of the exploration."""
        return _transform(self.rate_hz, self.explore_frame, self.explore_overlap)

    def start(self, index: int) -> float:
        """Heading [rad] of a start."""
        return float(np.pi * index / self.starts)


def _transform(rate: int, frame: int, overlap: float) -> Stft:
    return Stft(rate, frame, round(frame * (1 - overlap)))


@dataclass(frozen=True, slots=True)
class Task:
    """The smallest piece of work that is kept: some cases of one layout.

    Without an explorer the azimuths are known: with a target at the target's alignment, else at a start heading.
    """

    setting: str
    k: int
    layout: int  # 0 is the paper's
    target: int | None = None
    start: int = 0
    explorer: str | None = None
    unit: float | None = None  # T_unit [s]
    rate: float = 0.0  # at which the array turns while it explores [deg/s]; 0: it turns step by step

    @property
    def room(self) -> str:
        """The talkers, and the headings at which they are heard: the same for all that begins at one start."""
        return self.id if self.target is not None else f"{self._scene}-H{self.start}"

    @property
    def id(self) -> str:
        """What this task is called in the journal.

        >>> Task("S1", 3, 0, target=2).id, Task("S1", 3, 4, start=1, explorer="joint", unit=3.0).id
        ('S1-K3-L0-T2', 'S1-K3-L4-H1-joint-3s')
        """
        if self.explorer is not None:
            turning = f"-{self.rate:g}deg_s" if self.rate else ""
            return f"{self.room}-{self.explorer}-{self.unit:g}s{turning}"
        return self.room if self.target is None else f"{self._scene}-T{self.target}"

    @property
    def _scene(self) -> str:
        return f"{self.setting}-K{self.k}-L{self.layout}"


def tasks(study: Study) -> list[Task]:
    """Every task of a study once, in the order of its axes."""
    return [task for scene in _scenes(study) for task in _tasks(study, *scene)]


def n_tasks(study: Study) -> int:
    """How many tasks a study has.

    >>> study = Study(settings=("S1",), k=(2, 3), layouts=1, starts=4, separators=("duet",), explorers=("joint",))
    >>> n_tasks(study), len(tasks(study))
    (42, 42)
    """
    explorations = study.starts * len(study.explorers) * len(study.unit_s) * len(study.turning_deg_s)
    known = sum(study.k) + len(study.k) * study.starts if study.separators else 0
    return len(study.settings) * (study.layouts + study.paper_layout) * (known + len(study.k) * explorations)


def mixed(tasks: Iterable[AnyTask]) -> list[AnyTask]:
    """Mix long and short tasks, always in the same way: the time left can then be told early."""
    return sorted(tasks, key=lambda task: fingerprint(**asdict(task)))


@dataclass(frozen=True, slots=True)
class Shard:
    """A share of the tasks of a study: every ``of``-th one, from the ``number``-th on.

    >>> Shard(2, 3).of_all(["a", "b", "c", "d", "e"])
    ['b', 'e']
    """

    number: int = 1  # from 1
    of: int = 1

    def of_all(self, tasks: Sequence[AnyTask]) -> list[AnyTask]:
        """Return the share, in the study's order."""
        return list(tasks[self.number - 1 :: self.of])


ALL = Shard()


def _scenes(study: Study) -> Iterator[tuple[str, int, int]]:
    first = 0 if study.paper_layout else 1
    return product(study.settings, study.k, range(first, study.layouts + 1))


def _tasks(study: Study, setting: str, k: int, layout: int) -> Iterator[Task]:
    starts = range(study.starts)
    if study.separators:
        yield from (Task(setting, k, layout, target=target) for target in range(k))
        yield from (Task(setting, k, layout, start=start) for start in starts)
    for start, explorer, unit, rate in product(starts, study.explorers, study.unit_s, study.turning_deg_s):
        yield Task(setting, k, layout, start=start, explorer=explorer, unit=unit, rate=rate)


PAPERS = ("duet", "iva", "mvdr")  # the paper's separators
INFORMED = ("duet", "auxiva", "gaussian", "refined")  # the best ones
EVERY = (*INFORMED, "auto", "mvdr", "lcmv", "iva", "ilrma", "fastmnmf2", "irm", "mwf", "tvmwf")
PRESETS: dict[str, dict[str, Any]] = {
    "quick": {
        "settings": ("S1", "S2"), "k": (3,), "layouts": 0, "starts": 3, "separators": ("duet", "gaussian"),
        "rotations": (4,), "unit_s": (1.0,), "run_s": 3.0,
    },
    "paper": {
        "layouts": 0, "starts": 12, "separators": PAPERS, "explorers": ("markov",), "unit_s": (1.0, 3.0),
        "rotations": (STOP, 12), "rules": "paper", "rate_hz": 16000, "frame": 1024, "overlap": 0.25,
        "explore_overlap": 0.25,
    },
    "figures": {
        "k": (3,), "layouts": 0, "starts": 12, "separators": INFORMED,
    },
    "separation": {
        "settings": tuple(SETTINGS), "layouts": 10, "separators": (*INFORMED, "auto"),
        "noise": ("known", "unknown"), "explorers": (),
    },
    "exploration": {
        "settings": tuple(SETTINGS), "k": (2, 3, 4, 5), "layouts": 14, "paper_layout": False, "separators": (),
        "explorers": ("joint", "markov"), "rotations": (2, 4, 8, 12, STOP),
    },
    "full": {
        "settings": tuple(SETTINGS), "layouts": 10, "separators": EVERY,
    },
}  # fmt: skip


def chosen(name: str, changes: dict[str, Any], quick: bool) -> Study:
    """Take a preset or a TOML file, change some of its values, and check that everything it names exists.

    Raises
    ------
    ConfigError
        When the file cannot be read, a value is impossible, or a name is unknown.
    """
    base = PRESETS.get(name) or (read_toml(Path(name)) if name.endswith(".toml") else None)
    if base is None:
        raise ConfigError(f"{unknown('preset', name, PRESETS)} (a .toml file will do, too)")
    study = validated(Study, base | changes, name)
    if quick:
        rotations = tuple(dict.fromkeys(min(count, 4) if count != STOP else 4 for count in study.rotations))
        small = {
            "k": study.k[:1],
            "layouts": 1 - study.paper_layout,
            "starts": min(study.starts, 3),
            "rotations": rotations,
            "max_rotations": 4,
        }
        study = study.model_copy(update=small | {"run_s": min(study.run_s, 3.0)})
    check_names(study)
    return study


def explorer_named(name: str) -> CheckedExplorer:
    """Make an explorer whose every result is checked, for the array of the study.

    Raises
    ------
    PluginError
        When there is none of that name, or it is no explorer; says what was expected.
    """
    factory = plugins.load("ross_payload.explorers", name)
    return checked_explorer(name, lambda: factory.make(SPACING, SPEED_OF_SOUND))


def check_names(study: Study) -> None:
    """Check that rooms, separators and explorers exist here, and that the latter two are such.

    Raises
    ------
    ConfigError
        Names the first that does not, and what there is.
    PluginError
        Names the first plug-in that is none, and says what was expected.
    """
    for name in study.settings:
        if name not in SETTINGS:
            raise ConfigError(unknown("setting", name, SETTINGS))
    separators = plugins.available("ross_payload.separators")
    for name in study.separators:
        if name not in separators and name not in ORACLES:
            raise ConfigError(unknown("separator", name, [*separators, *ORACLES]))
        if name not in ORACLES:
            load_separator(name)
    for name in study.explorers:
        explorer_named(name)
    _check_turning(study)
    if study.tell_k and set(study.explorers) - {"joint"}:
        raise ConfigError(
            f"tell_k: expected only the explorer joint, which can use a known K, got {', '.join(study.explorers)}"
        )
    if not study.separators and not study.explorers:
        raise ConfigError("expected at least one separator or explorer, got neither")
    if not study.paper_layout and not study.layouts:
        raise ConfigError("layouts: expected at least one, got 0")
    if n_tasks(study) > MOST_TASKS:
        raise ConfigError(f"expected a study of at most {MOST_TASKS} tasks, got {n_tasks(study)}: fewer layouts, say")
    if study.paper_layout and max(study.k) > 5:
        raise ConfigError(
            f"k: expected at most 5, the talkers of the paper's layout, or paper_layout = false, got {max(study.k)}"
        )


def _check_turning(study: Study) -> None:
    """Check that every explorer can hear while the array turns, where it does."""
    slow = [rate for rate in study.turning_deg_s if 0 < rate < SLOWEST_DEG_S]
    if slow:
        raise ConfigError(f"turning_deg_s: expected 0, or at least {SLOWEST_DEG_S:g} deg/s, got {slow[0]:g}")
    deaf = [name for name in study.explorers if any(study.turning_deg_s) and not explorer_named(name).hears_turning]
    if deaf:
        raise ConfigError(f"turning_deg_s: expected explorers that hear while turning, got {deaf[0]}")
