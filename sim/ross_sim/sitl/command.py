"""``ross sitl``: the whole mission in a simulated room."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from ross_sim.sitl.page_observer import PageObserver

INTERRUPTED = 130
WRONG_TARGET = 4  # which the simulation alone knows: the payload itself ends with 0
SERVE = "Accept commands from --telemetry until Ctrl-C (default, without --page: udpout:127.0.0.1:14550)."
EPILOG = """Exit codes: 0 target found, 3 no target, 4 somebody else was taken for the target, 2 bad input, 1 fault, 130
stopped by the user.

URLs are udpin:host:port, udpout:host:port, tcp:host:port or serial:device:baud."""


def _speed(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    value = value or ("1" if context.params.get("serving") else "4" if context.params.get("page") else "max")
    if value == "max":
        return None
    try:
        speed = float(value)
    except ValueError:
        speed = 0.0
    if not 0.01 <= speed <= 1000:
        raise click.BadParameter(f"expected max or a number of times real time (0.01 to 1000), got '{value}'")
    return speed


def named_folder(context: click.Context, parameter: click.Parameter, value: str | None) -> Path | None:
    """Take the name of a folder, which is not empty."""
    if value == "":
        raise click.BadParameter("expected the name of a folder, got nothing")
    return None if value is None else Path(value)


def _list_scenarios(context: click.Context, parameter: click.Parameter, asked: bool) -> None:
    """Print the built-in scenarios and end."""
    if asked and not context.resilient_parsing:
        from ross_sim.scenario import load, names

        width = max(map(len, names()))
        for name in names():
            click.echo(f"{name:{width}}  {load(name).title}")
        context.exit()


@click.command("sitl", short_help="Run the whole mission in a simulated room.", epilog=EPILOG)
@click.option(
    "--scenario", "-s", default="demo", show_default=True, help="Name of a built-in scenario, or a TOML file."
)
@click.option(
    "--list", is_flag=True, is_eager=True, expose_value=False, callback=_list_scenarios, help="List built-in scenarios."
)
@click.option("--actuator", "-a", help="Actuator back end, instead of the scenario's.")
@click.option("--separator", "-p", help="Separator, instead of the scenario's.")
@click.option("--paper", is_flag=True, help="The paper's own methods and numbers instead of the scenario's.")
@click.option("--informed", is_flag=True, help="Tell the mission where the talkers are instead of exploring.")
@click.option("--seed", type=click.IntRange(min=0), help="Seed of everything random.")
@click.option("--speech", type=click.Path(path_type=Path), help="Folder of recordings; default: synthetic voices.")
@click.option("--target", help="Name of the talker to look for, or of an enrolled voice.")
@click.option("--telemetry", "urls", multiple=True, help="URL to send MAVLink to; can be given more than once.")
@click.option("--serve", "serving", is_flag=True, is_eager=True, help=SERVE)
@click.option("--page", is_flag=True, is_eager=True, help="Serve the ground station's page until Ctrl-C.")
@click.option("--speed", callback=_speed, help="max, or times real time; default: max, with --page 4, with --serve 1.")
@click.option("--out", callback=named_folder, help="Folder for report, audio, picture and logs.")
@click.option("--record", callback=named_folder, help="Record from start to end, in this folder, for `ross replay`.")
@click.option(
    "--listen", type=click.Path(path_type=Path), help="Write the target's voice there, live: a .flac or .wav."
)
@click.option("--json", "as_json", is_flag=True, help="Print only the report, as JSON.")
def command(
    *,
    scenario: str,
    out: Path | None,
    speed: float | None,
    record: Path | None,
    serving: bool,
    page: bool,
    listen: Path | None,
    as_json: bool,
    **changes: Any,
) -> int:
    """Run the whole mission in a simulated room, with the real drivers on simulated wires."""
    from contextlib import nullcontext

    from ross_payload.plugin_calls import telling_late_calls
    from ross_sim.sitl.page_observer import page_observer

    kept = _kept(record) if serving else record
    with telling_late_calls(), page_observer(out, kept) if page else nullcontext() as looking:
        if looking is not None:
            click.echo(f"the page: {looking.url}", err=as_json)
        changes["listen"] = listen
        return _run(scenario, changes, looking, out=out, speed=speed, record=record, serving=serving, as_json=as_json)


def _kept(record: Path | None) -> Path:
    """Return the folder for recordings of a served payload: they outlive it, and those of `ross run` are elsewhere."""
    from ross_payload.sessions.session_store import home

    return record or home().with_name("sitl-recordings")


@contextmanager
def _listing_recordings(folder: Path, always: bool, as_json: bool) -> Iterator[None]:
    """Say whether all is recorded and where recordings lie, and in the end which ones were made."""
    from ross_payload.sessions.catalog import described
    from ross_payload.sessions.session_store import SessionStore

    store = SessionStore(folder)
    before = {kept.path for kept in store.all()}
    if not as_json:
        now = "recording from start to end" if always else "nothing is recorded until a command asks for it"
        click.echo(f"{now}; folder of recordings: {folder}")
    try:
        yield
    finally:
        for kept in store.all():
            if kept.path not in before:
                click.echo(f"recorded {described(kept).seconds:.0f} s: {kept.path}", err=as_json)


def _run(
    scenario: str,
    changes: dict[str, Any],
    looking: PageObserver | None,
    *,
    out: Path | None,
    speed: float | None,
    record: Path | None,
    serving: bool,
    as_json: bool,
) -> int:
    """Perform or serve what is wanted, and return the exit code."""
    import sys
    from contextlib import nullcontext, redirect_stdout

    from ross_sim.sitl.mission_session import expected, perform
    from ross_sim.sitl.mission_view import showing_streams, view_of, waiting
    from ross_sim.sitl.pace import speed_words
    from ross_sim.sitl.results_folder import ResultsFolder
    from ross_sim.sitl.serve import linked, serve
    from ross_sim.sitl.summary import show, taken_for_target
    from ross_sim.sitl.talker_selection import directed, talkers_of

    if looking is not None:
        looking.tell(speed_words(speed))
        if serving:
            changes["urls"] = (*changes["urls"], looking.link)
    chosen = directed(scenario, changes)
    if serving:
        chosen = linked(chosen)
        if not as_json:
            click.echo(f"MAVLink at {', '.join(link.url for link in chosen.payload.links)}", err=True)
    telling = _listing_recordings(_kept(record), record is not None, as_json) if serving else nullcontext()
    with ResultsFolder(out) if out is not None else nullcontext() as folder, telling:
        with waiting(as_json, f"{chosen.title}: preparing the voices"):
            company = talkers_of(chosen, changes["speech"], changes["target"])
        writes = any(path is not None for path in (out, record, changes["listen"]))
        view = view_of(as_json, expected(chosen), writes)
        shown = nullcontext() if as_json else showing_streams(view)  # with --json, warnings go to standard error
        try:
            with shown:
                if serving:
                    kept, always = _kept(record), record is not None
                    serve(chosen, company, view, out=folder, speed=speed, recordings=kept, always=always)
                    return 0
                with redirect_stdout(sys.stderr) if as_json else nullcontext():  # a plug-in may print
                    finished = perform(chosen, company, view, folder, speed, record=record, page=looking)
        finally:
            view.close()
    mistaken = taken_for_target(finished.report, [voice.name for voice in company.voices])
    show(finished, out, as_json, mistaken=mistaken)
    if finished.closing is not None:
        raise finished.closing
    outcome = WRONG_TARGET if mistaken else int(finished.result.outcome)
    if looking is not None and (outcome != INTERRUPTED or looking.stopped):
        looking.linger(out is not None, aside=as_json)
    return outcome
