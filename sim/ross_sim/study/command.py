"""``ross study``: the evaluation as a command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ross_payload.errors import ConfigError
from ross_payload.plugins import install_line

EPILOG = """Without a preset or FILE.toml: quick. A study that was stopped goes on when the same command is given again.

Exit codes: 0 done, 1 a task failed or the disk is full, 2 bad input, 130 stopped by the user."""


class _Names(click.ParamType[Any]):
    """Values separated by commas."""

    name = "A,B,..."

    def __init__(self, kind: Any = str) -> None:
        self._kind = kind

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Split and convert."""
        parts = [part.strip() for part in str(value).split(",") if part.strip()]
        try:
            return tuple(self._kind(part) for part in parts)
        except ValueError:
            return self.fail(f"'{value}' is not a list of {self._kind.__name__} separated by commas", param, ctx)


def _schedule(text: str) -> int | str:
    return text if text == "stop" else int(text)


@click.command("study", short_help="Measure explorers and separators in simulated rooms.", epilog=EPILOG)
@click.argument("preset", default="quick", metavar="[PRESET|FILE.toml]")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder of the study.")
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of recordings; default: synthetic voices.")
@click.option("--workers", type=click.IntRange(1, 256), help="Processes; default: one per core.")
@click.option(
    "--quick", is_flag=True, help="The first K, one layout, at most 3 starts, 4 rotations, T_run at most 3 s."
)
@click.option("--seed", type=click.IntRange(min=0), help="Seed of everything random.")
@click.option("--settings", type=_Names(), help="Rooms: S1,S2,S3,A0.3,...")
@click.option("--k", type=_Names(int), help="Numbers of talkers.")
@click.option("--layouts", type=click.IntRange(min=0), help="Random layouts, beside the paper's.")
@click.option("--starts", type=click.IntRange(1, 180), help="Start headings over half a turn.")
@click.option("--separators", type=_Names(), help="Separators and oracles (irm, mwf, tvmwf); '' for none.")
@click.option("--noise", type=_Names(), help="Noise PSD to the separators: known, unknown or both.")
@click.option("--explorers", type=_Names(), help="Explorers; '' for none: true azimuths only.")
@click.option("--t-unit", "unit_s", type=_Names(float), help="T_unit [s].")
@click.option("--rotations", type=_Names(_schedule), help="Numbers of rotations, or stop: the explorer's own rule.")
@click.option("--tell-k", is_flag=True, default=None, help="Tell the explorer K (joint only).")
@click.option("--rules", help="Where to turn: best (predicted gain), or paper (its equations).")
@click.option("--talkers", type=_Names(), help="Names in the folder; default: all. Up to five keep their order.")
def command(preset: str, *, out: Path, speech: Path | None, workers: int | None, quick: bool, **axes: Any) -> int:
    """Measure settings x K x layouts x starts x separators x explorers x T_unit x rotations.

    Presets: quick, paper, separation, exploration, full. Every option of an axis replaces the preset's.
    """
    try:
        from ross_sim.study.study_run import conduct
    except ModuleNotFoundError as error:
        raise ConfigError(f"a study needs the package {error.name}: {install_line('study')}") from error

    changes = {name: value for name, value in axes.items() if value is not None}
    return conduct(preset, changes, out=out, speech=speech, workers=workers, quick=quick)
