"""``ross evaluate``: the paper's measured-data protocol on two recordings."""

from __future__ import annotations

from pathlib import Path

import click

from ross_payload.option_types import Number

EPILOG = """MIXTURE and TARGET are recorded with the array at one heading, each a file of two channels, microphone 1
first. Angles are compass degrees, clockwise; they may count from north, from the payload's nose or from the array's
axis, as long as all do. Exit codes: 0 done, 2 bad input, 1 the results could not be written."""


@click.command("evaluate", short_help="Score a separation of a recording against the target alone.", epilog=EPILOG)
@click.argument("mixture", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path))
@click.option(
    "--azimuth",
    "azimuths",
    metavar="DEG",
    multiple=True,
    type=Number(),
    help="Of a source [deg, clockwise]; once per source.",
)
@click.option(
    "--heading",
    metavar="DEG",
    type=Number(),
    help="Of the array's axis, microphone 1 to 2 [deg, clockwise]; default 0.",
)
@click.option(
    "--tdoa-us", "tdoas", metavar="US", multiple=True, type=Number(), help="Of a source [us], > 0: microphone 2 leads."
)
@click.option("--sources", type=click.IntRange(min=1, max=8), help="How many to look for when no direction is given.")
@click.option("--separator", "-p", help="Separator, instead of the configuration's (auto).")
@click.option(
    "--config",
    "file",
    type=click.Path(path_type=Path),
    help="The payload's TOML file: array, gain, polarity, roll-off, rate, frames.",
)
@click.option("--out", type=click.Path(path_type=Path), help="Folder for the separated voices and report.json.")
@click.option("--json", "as_json", is_flag=True, help="Print only the report, as JSON.")
def command(
    *,
    mixture: Path,
    target: Path,
    azimuths: tuple[float, ...],
    heading: float | None,
    tdoas: tuple[float, ...],
    sources: int | None,
    separator: str | None,
    file: Path | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Separate the recording MIXTURE (target and interferers) and score every group against TARGET (the target alone).

    Both are recorded at the same place and heading; the target plays the same recording through a loudspeaker in both.
    They need not begin together: TARGET is shifted to where it fits MIXTURE best. Without --azimuth or --tdoa-us the
    directions are the peaks of the ITD density of MIXTURE.
    """
    import json
    from contextlib import nullcontext

    from threadpoolctl import threadpool_limits

    from ross_payload.audio.channel_map import ChannelMap
    from ross_payload.config import Config, load
    from ross_payload.evaluation import results
    from ross_payload.evaluation.scoring import at_rate, delays, evaluate
    from ross_payload.evaluation.takes import paired, read_take
    from ross_payload.sessions.replay_results import prepared

    config = Config() if file is None else load(file)
    if separator is not None:
        chosen = config.exploit.model_copy(update={"separator": separator})
        config = config.model_copy(update={"exploit": chosen})
    tau = delays(config, azimuths, heading, tdoas, sources)
    wiring = ChannelMap.of(config.audio)
    both = read_take(mixture, wiring), read_take(target, wiring)
    config = at_rate(config, both[0].rate if file is None else config.audio.rate_hz)
    with prepared(out) if out is not None else nullcontext():
        with threadpool_limits(1):
            pair = paired(*both, config.audio.rate_hz)
            found = evaluate(pair, config, tau, sources)
        values = results.report(pair, found, config, azimuths, files=out is not None)
        if out is not None:
            results.write(out, values, found, config.audio.rate_hz)
    if as_json:
        click.echo(json.dumps(values, indent=2, allow_nan=False))
    else:
        results.show(values)
