"""``ross calibrate``: spacing, heading offset, gain, polarity and roll-off of the array, from one sound and a turn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ross_payload.option_types import Number, NumberRange

if TYPE_CHECKING:
    from ross_payload.calibration.cross_spectrum import HeadingSpectrum
    from ross_payload.config import Config

STOPPED = 130
QUESTION = "It will turn by up to {turn:g} deg and back. Does one sound play, and is the way free?"
EPILOG = """Exit codes: 0 calibrated, 2 bad input or a sound, turn or room that does not allow it, 1 a fault of the
actuator or a file that cannot be written, 130 stopped by the user."""


@click.command(
    "calibrate", short_help="Measure the array by turning: spacing, offset, gain, polarity, roll-off.", epilog=EPILOG
)
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--azimuth", type=Number(), metavar="DEG", help="Of the sound, as on a compass; gives the offset.")
@click.option("--elevation", type=NumberRange(-80, 80), default=0.0, metavar="DEG", help="Of the sound; default 0.")
@click.option("--turn", type=NumberRange(90, 360), default=360.0, metavar="DEG", help="How far; default 360.")
@click.option("--headings", type=click.IntRange(6, 72), default=12, help="How many; default 12.")
@click.option(
    "--listen", "seconds", type=NumberRange(0.6, 30), default=2.0, metavar="S", help="Seconds at each; default 2."
)
@click.option("--home", is_flag=True, help="Have the actuator find or declare its zero first; it may turn.")
@click.option("--session", type=click.Path(path_type=Path), help="Use a recorded session; nothing turns.")
@click.option("--recording", type=click.Path(path_type=Path), help="Use an audio file; nothing turns. See --angles.")
@click.option("--angles", type=click.Path(path_type=Path), help="CSV of the recording: from_s, to_s, joint_deg.")
@click.option(
    "--write", "writing", is_flag=True, help="Write what differs into CONFIG; the old file is kept beside it."
)
@click.option("--yes", is_flag=True, help="Do not ask for confirmation.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(
    *, config: Path, azimuth: float | None, elevation: float, writing: bool, as_json: bool, **asked: Any
) -> int:
    """Turn the array of a payload's TOML file CONFIG while one steady sound plays, and measure the array.

    The sound is a phone with noise, or one person who talks all the time, as high as the array and 1 to 3 m away.
    Everything passes the guard of the configuration. Run it while the payload is not running.
    """
    import json

    from ross_payload.calibration.estimate import calibrate
    from ross_payload.config import Config, load
    from ross_payload.config.file_editing import write_changes
    from ross_payload.doctor.calibration_report import as_values, changes, findings
    from ross_payload.doctor.calibration_session import Stopped
    from ross_payload.doctor.findings import print_finding

    settings = load(config)
    try:
        spectra, earth = _spectra(settings, **asked)
    except Stopped:
        click.echo("ross: stopped", err=True)
        return STOPPED
    array = settings.array
    true = None if azimuth is None else -math.radians(azimuth)
    found = calibrate(
        spectra,
        array.speed_of_sound_m_s,
        azimuth=true,
        elevation=math.radians(elevation),
        configured=array.spacing_m,
    )
    wanted = changes(settings, found)
    if as_json:
        click.echo(json.dumps(as_values(found, wanted), indent=2, allow_nan=False))
    else:
        for finding in findings(settings, found, earth=earth):
            print_finding(finding)
    if writing and wanted:
        kept = write_changes(config, wanted, Config)
        click.echo(f"written; the old file is {kept.name}", err=as_json)
    elif not as_json:
        _show_changes(wanted)
    return 0


def _spectra(config: Config, **asked: Any) -> tuple[list[HeadingSpectrum], bool]:
    """Return what was heard at every heading, from a recording or by turning, and whether in the earth frame."""
    from ross_payload.doctor.calibration_inputs import from_session, from_wav
    from ross_payload.doctor.calibration_session import TurnPlan, live
    from ross_payload.mount import fixed_mount

    session, recording, angles = asked["session"], asked["recording"], asked["angles"]
    if session is not None and recording is not None:
        raise click.UsageError("expected --session or --recording, got both")
    if (recording is None) != (angles is None):
        raise click.UsageError("expected --recording and --angles together, got one of them")
    if session is not None:
        return from_session(config, session)
    if recording is not None:
        base = fixed_mount(config).attitude(0.0)
        return from_wav(config, recording, angles, base), base.known
    plan = TurnPlan(math.radians(asked["turn"]), asked["headings"], asked["seconds"], asked["home"])
    question = QUESTION.format(turn=asked["turn"])
    return live(config, plan, lambda: asked["yes"] or click.confirm(question, err=True))


def _show_changes(wanted: dict[str, Any]) -> None:
    """Say what `--write` would write."""
    from ross_payload.config.file_editing import as_toml

    click.echo(f"--write would set {as_toml(wanted)}" if wanted else "the configuration agrees with what was heard")
