"""What an evaluation leaves: plain values, a table, and a folder of separated voices."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ross_payload.angles import wrap
from ross_payload.atomic_files import json_text, replacing
from ross_payload.audio.audio_files import gain_in_files, write_wav
from ross_payload.config import Config
from ross_payload.errors import OutputError, refused_as
from ross_payload.evaluation.scoring import ELSEWHERE, Evaluation, level_of
from ross_payload.evaluation.takes import Pair
from ross_payload.terminal_tables import with_whole_words
from ross_protocols.angle_text import rounded

OWN = 0o600  # who may read what people have said
VOICE = re.compile(r"group-\d+\.wav")
NOISE = {True: "measured at the start of the mixture", False: "unknown"}
PACKAGES = ("ross-payload", "numpy", "scipy")


def report(
    pair: Pair, found: Evaluation, config: Config, azimuths_deg: Sequence[float], *, files: bool
) -> dict[str, Any]:
    """Everything worth keeping, as plain values: no paths, the same on every rerun.

    ``azimuths_deg`` are those of the command line, clockwise; the report has them counter-clockwise, as all reports do.
    ``files``: whether `write` follows.
    """
    rate = pair.mixture.rate
    return {
        "rate_hz": rate,
        "scored_s": round(pair.target.size / rate, 3),
        "scored_from_s": round(pair.span.start / rate, 3),
        "lag_s": round(pair.lag.samples / rate, 6),
        "correlation": round(pair.lag.correlation, 3),
        "mixture_dbfs": _rounded(level_of(pair.mixture.samples[0, pair.span]), 2),
        "target_dbfs": _rounded(level_of(pair.target), 2),
        "directions": "given" if found.given else "found in the mixture",
        "azimuths_deg": [round(math.degrees(wrap(-math.radians(given))), 6) for given in azimuths_deg],
        "tdoas_us": [round(tau * 1e6, 2) for tau in found.tau],
        "separator": found.method,
        "why": found.why,
        "noise": NOISE[found.noise_known],
        "si_sdr_in_db": _rounded(found.before, 2),
        "groups": [_group(index, found) for index in range(len(found.groups))],
        "notes": [*pair.notes, *_doubts(found, config), *(_softer(found) if files else ())],
        "configuration": config.model_dump(mode="json", include={"array", "audio", "seed"}),
        "versions": {name: version(name) for name in PACKAGES},
    }


def _doubts(found: Evaluation, config: Config) -> tuple[str, ...]:
    if found.elsewhere is not None:
        near = ELSEWHERE * config.array.spacing_m / config.array.speed_of_sound_m_s
        return (
            f"target: heard at {found.elsewhere * 1e6:.0f} us, and no given source within {near * 1e6:.0f} us "
            "of that: are the channels swapped, or azimuths, heading or spacing wrong?",
        )
    if found.given or len(found.tau) > 1:
        return ()
    return ("mixture: only one direction was found, so nothing is separated: give --sources, --azimuth or --tdoa-us",)


def _softer(found: Evaluation) -> tuple[str, ...]:
    gain = gain_of_files(found)
    if gain == 1:
        return ()
    return (f"the separated voices exceed full scale: files of --out are {-20 * math.log10(gain):.1f} dB softer",)


def gain_of_files(found: Evaluation) -> float:
    """Gain of the files of all groups, with which none exceeds full scale; 1 where none does anyhow."""
    return gain_in_files(group.voice for group in found.groups)


def _group(index: int, found: Evaluation) -> dict[str, Any]:
    group = found.groups[index]
    gain = None if group.si_sdr is None else group.si_sdr - found.before
    return {
        "sources": list(group.members),
        "si_sdr_db": _rounded(group.si_sdr, 2),
        "si_sdri_db": _rounded(gain, 2),
        "dbfs": _rounded(group.level, 2),
        "best": index == found.best,
    }


def show(values: dict[str, Any]) -> None:
    """Print the table, and in words what was done to the files."""
    console = Console()
    console.print(_table(values))
    lag = f"{abs(values['lag_s']):.4f} s {'later' if values['lag_s'] > 0 else 'earlier'}"
    heard = (
        f"the target is heard {lag if values['lag_s'] else 'at the same time'} in the mixture, "
        f"correlation {values['correlation']:.2f}; mixture {_text(values['mixture_dbfs'])} dBFS, "
        f"target {_text(values['target_dbfs'])} dBFS; directions {values['directions']}, "
        f"noise level {values['noise']}"
    )
    for line in (heard, *values["notes"]):
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def _table(values: dict[str, Any]) -> Table:
    table = Table(title=f"separated by {values['separator']}", title_justify="left", caption=values["why"] or None)
    for column in ("group", "sources", "TDOA [us]", "level [dBFS]", "SI-SDR in [dB]", "out [dB]", "gain [dB]"):
        table.add_column(escape(column), justify="right")
    for index, row in enumerate(values["groups"]):
        cells = [_text(row["dbfs"]), _text(values["si_sdr_in_db"]), _text(row["si_sdr_db"]), _text(row["si_sdri_db"])]
        table.add_row(str(index), _who(row, values), _where(row, values), *cells, style="bold" if row["best"] else None)
    return with_whole_words(table)


def _who(row: dict[str, Any], values: dict[str, Any]) -> str:
    azimuths = values["azimuths_deg"]
    return " + ".join(f"{rounded(-azimuths[m], 0):.0f} deg" if azimuths else str(m) for m in row["sources"]) or "-"


def _where(row: dict[str, Any], values: dict[str, Any]) -> str:
    return " ".join(f"{values['tdoas_us'][m]:.0f}" for m in row["sources"]) or "-"


def write(folder: Path, values: dict[str, Any], found: Evaluation, rate: int) -> None:
    """Write ``group-N.wav`` (24-bit PCM) and ``report.json``; voices of an earlier evaluation are removed.

    Voices louder than full scale, as those of float files may be, are made softer by what `report` says.

    Raises
    ------
    OutputError
        When the disk is full or gone.
    """
    gain = gain_of_files(found)
    for index, group in enumerate(found.groups):
        write_wav(folder / f"group-{index}.wav", gain * group.voice, rate)
    mine = {f"group-{index}.wav" for index in range(len(found.groups))}
    with refused_as(OutputError, f"{folder}: cannot be written"):
        for path in folder.iterdir():
            if VOICE.fullmatch(path.name) and path.name not in mine:
                path.unlink()
        with replacing(folder / "report.json", OWN) as part:
            part.write_text(json_text(values), encoding="utf-8")


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, digits)


def _text(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
