"""``ross study``: the evaluation as a command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ross_payload.errors import ConfigError, unknown
from ross_payload.option_types import NumberRange
from ross_payload.plugins import install_line
from ross_sim.study.benchmark.command import benchmark
from ross_sim.study.option_types import CommaSeparated, EngineName, ShardNumber

DEFAULT = "separators"
LOWEST, HIGHEST, FASTEST = 1.0, 100.0, 3.0  # of listening from above [m], [m/s]
LOUDEST = 100.0  # of talkers over noise, or noise over talkers [dB]
EPILOG = """Without a preset or FILE.toml: quick. A study that was stopped goes on when the same command is given again.

ross study missions flies whole missions, ross study benchmark compares methods on fixed public scenes, ross study
calibration calibrates arrays, ross study merge puts shards together, ross study status says how far one is, ross study
table writes tables from rows: see their own --help.

Exit codes: 0 done, 1 a task failed or the disk is full, 2 bad input, 130 stopped by the user."""


class _Studies(click.Group):
    """The studies with a name of their own; anything else is a study of explorers and separators."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read what is no name of a study as arguments of the first one."""
        return super().parse_args(ctx, args if args and args[0] in (*self.commands, DEFAULT) else [DEFAULT, *args])

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Find a study by its name."""
        return separators if name == DEFAULT else super().get_command(ctx, name)

    def invoke(self, ctx: click.Context) -> object:
        """Carry out a study; what is not installed is named with the extra that brings it."""
        try:
            return super().invoke(ctx)
        except ModuleNotFoundError as error:
            raise ConfigError(f"a study needs the package {error.name}: {install_line('study')}") from error


def _executed(function: Any) -> Any:
    """Options of a study whose tasks can be shared out."""
    shard = click.option("--shard", type=ShardNumber(), help="Do this share of the tasks alone: 1/4, 2/4, ...")
    engine = click.option(
        "--engine", type=EngineName(), default="processes", help="What runs the tasks; default: processes."
    )
    workers = click.option(
        "--workers", type=click.IntRange(1, 256), help="Processes of this computer; default: one per core."
    )
    return workers(engine(shard(function)))


def _engine(engine: dict[str, Any], workers: int | None) -> Any:
    from ross_sim.study.runs.task_engine import EngineChoice

    if workers is not None and "scheduler" in engine:
        raise ConfigError(f"--workers: expected none with a cluster, which has its own, got {workers}")
    return EngineChoice(workers, **engine)


def _share(shard: Any) -> dict[str, Any]:
    return {} if shard is None else {"shard": shard}


def _ratio(text: str) -> float | None:
    return None if text == "off" else float(text)


def _schedule(text: str) -> int | str:
    return text if text == "stop" else int(text)


@click.group("study", cls=_Studies, short_help="Measure explorers, separators and missions in simulated rooms.")
def command() -> None:
    """Measure in simulated rooms."""


@click.command("study", epilog=EPILOG)
@click.argument("preset", default="quick", metavar="[PRESET|FILE.toml]")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder of the study.")
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of recordings; default: synthetic voices.")
@_executed
@click.option(
    "--quick", is_flag=True, help="The first K, one layout, at most 3 starts, 4 rotations, T_run at most 3 s."
)
@click.option("--seed", type=click.IntRange(min=0), help="Seed of everything random.")
@click.option("--settings", type=CommaSeparated(), help="Rooms: S1,S2,S3,A0.3,...")
@click.option("--k", type=CommaSeparated(int), help="Numbers of talkers.")
@click.option("--layouts", type=click.IntRange(min=0), help="Random layouts, beside the paper's.")
@click.option("--starts", type=click.IntRange(1, 180), help="Start headings over half a turn.")
@click.option(
    "--separators", type=CommaSeparated(empty=True), help="Separators and oracles (irm, mwf, tvmwf); '' for none."
)
@click.option("--noise", type=CommaSeparated(), help="Noise PSD to the separators: known, unknown or both.")
@click.option("--explorers", type=CommaSeparated(empty=True), help="Explorers; '' for none: true azimuths only.")
@click.option("--t-unit", "unit_s", type=CommaSeparated(float), help="T_unit [s].")
@click.option(
    "--rotations",
    type=CommaSeparated(_schedule, "whole numbers or stop"),
    help="Numbers of rotations, or stop: the explorer's own rule.",
)
@click.option(
    "--turning", "turning_deg_s", type=CommaSeparated(float), help="Turn without a pause [deg/s]; 0: step by step."
)
@click.option("--tell-k", is_flag=True, default=None, help="Tell the explorer K (joint only).")
@click.option("--rules", help="Where to turn: best (predicted gain), or paper (its equations).")
@click.option(
    "--talkers", type=CommaSeparated(empty=True), help="Names in the folder; default: all. Up to five keep their order."
)
def separators(
    preset: str,
    *,
    out: Path,
    speech: Path | None,
    workers: int | None,
    engine: Any,
    quick: bool,
    shard: Any,
    **axes: Any,
) -> int:
    """Measure settings x K x layouts x starts x separators x explorers x T_unit x rotations.

    Presets: quick, paper, figures, separation, exploration, full. Every option of an axis replaces the preset's.
    """
    changes = {name: value for name, value in axes.items() if value is not None}
    from ross_sim.study.runs.study_run import conduct

    by = _engine(engine, workers)
    return conduct(preset, changes, out=out, speech=speech, engine=by, quick=quick, **_share(shard))


@command.command("missions")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder of the study.")
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of recordings; default: synthetic voices.")
@_executed
@click.option(
    "--scenarios", type=CommaSeparated(), help="Scenarios by name or path, or rooms: living-room,S1,B0.45,..."
)
@click.option("--k", type=CommaSeparated(int, empty=True), help="Numbers of talkers; default: the scenario's.")
@click.option("--places", type=click.Choice(["drawn", "written"]), help="Random azimuths, or those of the scenario.")
@click.option("--targets", type=CommaSeparated(), help="Whether the target is in the room: present,absent.")
@click.option("--draws", type=click.IntRange(1, 10000), help="How often to fly; every draw has other talkers.")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of the first draw; the next have the next seeds.")
@click.option("--set", "settings", multiple=True, help="Change a key of the payload: explore.pipelined=true.")
@click.option("--turns-heard/--turns-unheard", default=None, help="Unheard, the last heading sounds on: faster.")
def missions(
    *,
    out: Path,
    speech: Path | None,
    workers: int | None,
    engine: Any,
    settings: tuple[str, ...],
    shard: Any,
    **axes: Any,
) -> int:
    """Fly whole missions: scenarios x K x draws, with the target in the room and without.

    A study that was stopped goes on when the same command is given again.

    Exit codes: 0 done, 1 a task failed or the disk is full, 2 bad input, 130 stopped by the user.
    """
    changes = {name: value for name, value in axes.items() if value is not None} | {"settings": settings}
    from ross_sim.study.runs.missions_run import conduct_missions

    return conduct_missions(changes, out=out, speech=speech, engine=_engine(engine, workers), **_share(shard))


@command.command("calibration")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="CSV file for the rows.")
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of recordings; default: synthetic voices.")
@click.option("--settings", type=CommaSeparated(), default="S1,S2", help="Rooms; default S1,S2.")
@click.option("--sounds", type=CommaSeparated(), default="noise,talker", help="Default noise,talker.")
@click.option("--draws", type=click.IntRange(1, 10000), default=20, help="Arrays per room and sound; default 20.")
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Of everything random; default 0.")
def calibration(**asked: Any) -> int:
    """Calibrate random arrays by turning them: rooms x sounds x draws, with the real driver of a stepper.

    A study that was stopped goes on when the same command is given again.

    Exit codes: 0 done, 1 the rows cannot be written, 2 bad input, 130 stopped by the user.
    """
    from ross_sim.study.calibration_study import conduct

    return conduct(**asked)


@command.command("noise")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder for rows.csv and table.md.")
@click.option("--speech", type=click.Path(path_type=Path), required=True, help="Folder of recordings of talkers.")
@click.option(
    "--noise", type=click.Path(path_type=Path), help="Folder of recorded propellers; default: made ones only."
)
@click.option(
    "--kinds",
    type=CommaSeparated(),
    help="synthetic, drifting, recorded, wind; default: synthetic, recorded if --noise.",
)
@click.option(
    "--snr",
    type=CommaSeparated(float, low=-LOUDEST, high=LOUDEST),
    default="0,-5,-10",
    help="Talkers over noise at microphone 1 [dB].",
)
@click.option("--layouts", type=click.IntRange(1, 1000), default=3, help="Of every K from 1 to 3.")
@click.option(
    "--models",
    type=CommaSeparated(),
    default="learnt,white",
    help="learnt: covariances; told: and rotor speeds; white: without.",
)
@click.option("--separator", default="refined", help="Name of a separator.")
@click.option("--only", type=click.Choice(["explore", "separate"]), help="One half of it.")
@click.option(
    "--seed", type=CommaSeparated(int, low=0), default="1", help="Seeds of everything random, one after the other."
)
def noise_study(*, out: Path, speech: Path, noise: Path | None, only: str | None, **axes: Any) -> int:
    """Measure finding and separating among rotors and in wind: noise x ratio x K x layouts.

    A study that was stopped goes on when the same command is given again.

    Exit codes: 0 done, 1 the rows cannot be written, 2 bad input, 130 stopped by the user.
    """
    from ross_sim.study.noise_study import MODELS, Design, conduct_noise
    from ross_sim.study.scenes.noise_scenes import KINDS

    kinds = axes["kinds"] or (("synthetic",) if noise is None else ("synthetic", "recorded"))
    wrong = next((kind for kind in kinds if kind not in KINDS), None)
    if wrong is not None:
        raise ConfigError(f"--kinds: {unknown('noise', wrong, KINDS)}")
    unlike = next((model for model in axes["models"] if model not in MODELS), None)
    if unlike is not None:
        raise ConfigError(f"--models: {unknown('model', unlike, MODELS)}")
    if "recorded" in kinds and noise is None:
        raise ConfigError("--kinds: expected --noise DIR with recorded, got none")
    design = Design(
        kinds,
        axes["snr"],
        axes["layouts"],
        axes["seed"],
        axes["models"],
        axes["separator"],
        explore=only != "separate",
        separate=only != "explore",
    )
    return conduct_noise(design, out=out, speech=speech, noise=noise)


@command.command("merge")
@click.argument("shards", type=click.Path(path_type=Path), nargs=-1, required=True, metavar="SHARD...")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder of the whole study.")
def merged(shards: tuple[Path, ...], out: Path) -> int:
    """Put the folders of all shards of one study together: the rows of the study done at once.

    Exit codes: 0 done, 1 the disk is full, 2 the shards do not belong together or are not all there.
    """
    from ross_sim.study.runs.shards import merge

    for made in merge(shards, out):
        click.echo(made.markdown())
    return 0


@command.command("status")
@click.argument("folder", type=click.Path(path_type=Path), metavar="FOLDER")
def status(folder: Path) -> int:
    """Say how far the study in FOLDER is, also while it runs.

    Exit codes: 0 it is there, 2 FOLDER holds no study.
    """
    import time

    from ross_sim.study.runs.study_status import status_of

    click.echo(status_of(folder, time.time()).words)
    return 0


@command.command("above")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="CSV file for the rows.")
@click.option("--speech", type=click.Path(path_type=Path), required=True, help="Folder of recordings of talkers.")
@click.option("--noise", type=click.Path(path_type=Path), help="Folder of recorded propellers; default: made ones.")
@click.option("--heights", type=CommaSeparated(float), default="5,10,20", help="Of the array above the mouths [m].")
@click.option(
    "--ratios",
    type=CommaSeparated(_ratio, f"numbers from {-LOUDEST:g} to {LOUDEST:g}, or off,", low=-LOUDEST, high=LOUDEST),
    default="off,10,0,-5,-10",
    help="Talkers over rotors [dB], or off.",
)
@click.option(
    "--walks", type=CommaSeparated(float), default="0", help="Walking speed of the talkers [m/s]; 0: they stand."
)
@click.option("--layouts", type=click.IntRange(1, 1000), default=8, help="Of every K from 1 to 3.")
@click.option("--separated", type=click.IntRange(min=0), default=1, help="Of these, so many are separated, too.")
@click.option("--ground", type=NumberRange(0, 1), default=0.5, help="Reflection coefficient of the ground.")
@click.option("--separator", default="refined", help="Name of a separator.")
@click.option("--seed", type=click.IntRange(min=0), default=1, help="Seed of everything random.")
def above_study(*, out: Path, speech: Path, noise: Path | None, **asked: Any) -> int:
    """Measure finding and separating talkers below a vehicle: height x walk x ratio x K x layouts.

    What OUT holds already is not measured again.

    Exit codes: 0 done, 1 the rows cannot be written, 2 bad input.
    """
    from ross_sim.study.above_study import AboveDesign, conduct_above

    wrong = next((height for height in asked["heights"] if not LOWEST <= height <= HIGHEST), None)
    if wrong is not None:
        raise ConfigError(f"--heights: expected {LOWEST:g} to {HIGHEST:g} m, got {wrong:g}")
    if not all(0 <= walk <= FASTEST for walk in asked["walks"]):
        raise ConfigError(f"--walks: expected 0 to {FASTEST:g} m/s, got {max(asked['walks'], key=abs):g}")
    return conduct_above(AboveDesign(**asked), out=out, speech=speech, noise=noise)


@command.command("table")
@click.argument("rows", type=click.Path(path_type=Path), metavar="ROWS")
@click.option("--into", "page", type=click.Path(path_type=Path), help="Page with marks that name ROWS.")
def table(rows: Path, page: Path | None) -> int:
    """Make the tables of ROWS, a CSV or Parquet file of a study: print them, or write them into a page.

    In the page, <!-- rows: FILE, table: NAME --> and <!-- rows: end --> stand around every table.
    """
    from ross_sim.study.page_tables import tables_of, write_page

    if page is not None:
        write_page(page, rows)
        click.echo(f"{page}: written from {rows}")
        return 0
    for name, text in tables_of(rows).items():
        click.echo(f"<!-- table: {name} -->\n{text}")
    return 0


command.add_command(benchmark)
