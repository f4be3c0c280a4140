"""How well geometry predicts what a heading gains: `python -m ross_sim.study.predicted_gain_study`.

Random layouts of K talkers (`separation`, `rooms`) are heard at headings all around and at the headings that the rules
would choose; the local Gaussian model separates everybody at each of them. The first table says what is lost by the
heading that a rule chooses against the best of all that were heard (the regret), and how the prediction ranks them; the
second what the constants of `ross_payload.alignment.predicted_gain` are by least squares on these very rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import click
import numpy as np
from scipy.optimize import least_squares
from scipy.stats import spearmanr
from threadpoolctl import threadpool_limits

from ross_payload import plugins
from ross_payload.alignment import predicted_gain
from ross_payload.alignment.plan import isolation
from ross_payload.angles import Real
from ross_payload.interfaces import Separator
from ross_payload.option_types import NumberRange
from ross_sim.study.option_types import NATURAL, CommaSeparated
from ross_sim.study.rows.heading_rows import HeadingRow, headings
from ross_sim.study.rows.result_rows import number
from ross_sim.study.rows.row_files import as_csv
from ross_sim.study.runs.study_design import Study
from ross_sim.study.runs.talker_placement import Source, check_voices, voices_of
from ross_sim.study.scenes.mixtures import RATE, aligned_heading, gains, layouts, record
from ross_sim.study.scenes.room_settings import PLANES, SETTINGS, SPACING, SPEED_OF_SOUND, Setting, check_rooms
from ross_sim.study.script_errors import expect_writable, told_in_a_line, write_result

GRID: Real = np.deg2rad(np.arange(0.0, 180.0, 0.5))  # headings that argmax tries
RULES: dict[str, Callable[[Real, int, float], float]] = {
    "gain": lambda azimuths, target, direct: float(predicted_gain.best_headings(azimuths, directness=direct)[target]),
    "paper": lambda azimuths, target, _: aligned_heading(azimuths, target),
    "argmax": lambda azimuths, target, _: float(GRID[_isolation(azimuths, GRID)[target].argmax()]),
}


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """What one target gains at every heading of one layout."""

    azimuths: Real  # [rad], (n_sources,)
    target: int
    directness: float
    headings: Real  # [rad], (n_headings,)
    si_sdri_db: Real  # (n_headings,)

    def at(self, rule: str) -> float:
        """SI-SDRi [dB] at the heading that a rule chooses."""
        heading = RULES[rule](self.azimuths, self.target, self.directness)
        return float(self.si_sdri_db[np.abs(np.sin(self.headings - heading)).argmin()])

    @property
    def predicted(self) -> Real:
        """Predicted gain [dB], (n_headings,)."""
        return np.asarray(
            predicted_gain.predicted_gain(self.azimuths, self.headings, directness=self.directness)[self.target]
        )

    @property
    def regret_db(self) -> dict[str, float]:
        """Best SI-SDRi less that of every rule [dB], and of the mean heading."""
        best = float(self.si_sdri_db.max())
        return {**{rule: best - self.at(rule) for rule in RULES}, "mean": best - float(self.si_sdri_db.mean())}


def curves(
    voices: Sequence[Real], n_sources: int, setting: Setting, count: int, seed: int, *, step_deg: float
) -> Iterator[Curve]:
    """Every talker of ``count`` random layouts as the target, at headings all around and those of every rule."""
    direct = float(setting.t60 == 0)
    separator: Separator = plugins.load("ross_payload.separators", "gaussian")
    for index, azimuths in enumerate(layouts(n_sources, count, np.random.default_rng([seed, n_sources]))[1:]):
        cast = np.random.default_rng([seed, index]).permutation(len(voices))[:n_sources]
        chosen = [rule(azimuths, k, direct) for rule in RULES.values() for k in range(n_sources)]
        headings = np.array([*np.deg2rad(np.arange(0.0, 180.0, step_deg)), *chosen]) % np.pi
        heard = [
            gains(separator, record([voices[i] for i in cast], azimuths, 0, heading, setting, rng=rng))
            for heading in headings.tolist()
            for rng in [np.random.default_rng([seed, index, round(heading * 1e6)])]
        ]
        for target, values in enumerate(np.transpose(heard)):
            yield Curve(azimuths, target, direct, headings, values)


def fit(found: Sequence[Curve]) -> Real:
    """Least-squares (s, r, m) of curves in one room, less troubled by outliers (soft L1)."""

    def misfit(constants: Real) -> Real:
        return np.concatenate([_gain(curve, *np.abs(constants)) - curve.si_sdri_db for curve in found])

    return np.abs(least_squares(misfit, (0.25, 0.05, 0.02), loss="soft_l1").x)


def _gain(curve: Curve, reach: float, echoes: float, between: float) -> Real:
    """The prediction of `gain` with other constants and without b."""
    tau = np.cos(curve.azimuths[:, None] - curve.headings)
    ahead = np.delete(tau, curve.target, axis=0) - tau[curve.target]
    phantom = (ahead.min(axis=0) < 0) & (ahead.max(axis=0) > 0)
    return np.asarray(-10 * np.log10(echoes + between * phantom + np.exp(-np.abs(ahead) / reach).mean(axis=0)))


def _isolation(azimuths: Real, headings: Real) -> Real:
    return isolation(azimuths, headings, SPACING, SPEED_OF_SOUND)


def row_of(curve: Curve, setting: str, layout: int, seed: int) -> HeadingRow:
    """What is kept of a curve."""
    lost = {rule: number(each) for rule, each in curve.regret_db.items()}
    return HeadingRow(
        setting=setting,
        k=len(curve.azimuths),
        layout=layout,
        target=curve.target,
        seed=seed,
        best_db=number(float(curve.si_sdri_db.max())),
        gain_db=lost["gain"],
        paper_db=lost["paper"],
        isolation_db=lost["argmax"],
        mean_db=lost["mean"],
        rank=number(float(spearmanr(curve.predicted, curve.si_sdri_db).statistic)),
    )


@click.command()
@click.option("--speech", type=click.Path(path_type=Path), default=Path("../shared/speech"), show_default=True)
@click.option(
    "--rooms", type=CommaSeparated(), default=",".join(PLANES), show_default=True, help=f"Of {','.join(SETTINGS)}."
)
@click.option(
    "--k",
    "sizes",
    type=CommaSeparated(int, low=2, high=8),
    default="2,3,4,5",
    show_default=True,
    help="Numbers of talkers.",
)
@click.option("--layouts", "count", type=click.IntRange(min=1), default=4, show_default=True)
@click.option("--step-deg", type=NumberRange(1, 90), default=15.0, show_default=True)
@click.option("--seconds", type=NumberRange(2, 10), default=6.0, show_default=True)
@click.option("--seed", type=NATURAL, default=0, show_default=True)
@click.option("--out", type=click.Path(path_type=Path), help="File for the rows (.csv), for `ross study table`.")
def main(
    *,
    speech: Path,
    rooms: tuple[str, ...],
    sizes: tuple[int, ...],
    count: int,
    step_deg: float,
    seconds: float,
    seed: int,
    out: Path | None,
) -> None:
    """Print what is lost [dB] by the heading of every rule, and the constants that fit best."""
    found: dict[str, list[Curve]] = {name: [] for name in rooms}
    with told_in_a_line():
        if out is not None:
            expect_writable(out)
        check_rooms(rooms)
        talkers = voices_of(Source(speech, (), RATE))
        check_voices(talkers, Study(run_s=seconds))
        voices = [voice.speech[: round(seconds * RATE)] for voice in talkers]
        rows: list[HeadingRow] = []
        for name, size in product(rooms, sizes):
            with threadpool_limits(1):
                cell = list(curves(voices, size, SETTINGS[name], count, seed, step_deg=step_deg))
            rows += [row_of(curve, name, index // size + 1, seed) for index, curve in enumerate(cell)]
            found[name] += cell
        click.echo(headings(rows).markdown())
        if out is not None:
            write_result(out, as_csv(rows, HeadingRow))
    for name, cell in found.items():
        reach, echoes, between = fit(cell)
        click.echo(f"{name:5} s = {reach:.3f} d / v_p, r = {echoes:.3f}, m = {between:.3f}")


if __name__ == "__main__":
    main()
