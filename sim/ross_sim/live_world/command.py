"""``ross world``: room and far end in one process, in real time, for a payload in another."""

from __future__ import annotations

from pathlib import Path

import click

from ross_payload.option_types import NumberRange
from ross_sim.sitl.command import named_folder

NO_CHANGES = dict.fromkeys(("paper", "separator", "urls", "informed", "target"))
FORMATS = ("s16le", "s24le", "f32le")  # those of ross_protocols.audio.pcm, which needs numpy
EPILOG = """Ctrl-C or SIGTERM ends it; the ground truth is then written to --out. Exit codes: 0 ended by the user, 2 bad
input, 1 the results could not be written. Port 0: any free port."""


@click.command("world", short_help="Simulate room and actuator for a payload in another process.", epilog=EPILOG)
@click.argument("scenario", default="demo")
@click.option("--pcm", metavar="tcp:HOST:PORT", help="Serve the sound there; default: tcp:127.0.0.1:0 unless --pipe.")
@click.option("--pipe", type=click.Path(path_type=Path), help="Write the sound into this named pipe.")
@click.option("--format", "form", type=click.Choice(FORMATS), default="s24le", show_default=True)
@click.option("--wire", metavar="URL", help="Serve the actuator there, or join there; default: a free local port.")
@click.option("--actuator", "-a", help="Actuator back end, instead of the scenario's.")
@click.option("--start", type=click.Choice(["connect", "now"]), default="connect", show_default=True,
              help="When the scenario begins: with the first listener of --pcm, else of --wire; or now.")  # fmt: skip
@click.option("--quiet", type=NumberRange(0, 600), default=0.0, help="Only noise before the scenario [s].")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of everything random.")
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of recordings; default: synthetic voices.")
@click.option("--enrolment", type=click.Path(path_type=Path), help="Write clean speech of the target to this WAV file.")
@click.option(
    "--out", callback=named_folder, help="Folder for the ground truth: directions, headings, every talker alone."
)
@click.option("--json", "as_json", is_flag=True, help="Print the addresses as one line of JSON.")
def command(
    *,
    scenario: str,
    pcm: str | None,
    pipe: Path | None,
    form: str,
    wire: str | None,
    actuator: str | None,
    start: str,
    quiet: float,
    seed: int | None,
    speech: Path | None,
    enrolment: Path | None,
    out: Path | None,
    as_json: bool,
) -> int:
    """Simulate a room and the actuator in real time; a payload in another process hears and turns it.

    SCENARIO is the name of a built-in scenario or a TOML file.
    """
    from contextlib import nullcontext

    from ross_sim.live_world.world_session import Sockets, Wishes, run
    from ross_sim.sitl.results_folder import ResultsFolder
    from ross_sim.sitl.talker_selection import directed

    sockets = Sockets(pcm=pcm or (None if pipe else "tcp:127.0.0.1:0"), pipe=pipe, form=form, wire=wire)
    wishes = Wishes(at_once=start == "now", quiet=quiet, speech=speech, enrolment=enrolment, as_json=as_json)
    chosen = directed(scenario, NO_CHANGES | {"actuator": actuator, "seed": seed})
    with ResultsFolder(out) if out is not None else nullcontext() as folder:
        run(chosen, sockets, wishes, folder)
    return 0
