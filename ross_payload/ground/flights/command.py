"""``ross tlog``: a flight as a table, a plot, or a file for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ross_payload.ground.errors import GroundError
from ross_payload.plugins import install_line

if TYPE_CHECKING:
    from ross_protocols.mavlink.component_id import ComponentId

EPILOG = "Exit codes: 0 done, 2 bad input or an output that cannot be written."


class _Ending(click.Path):
    """A path with one of some endings: nothing else is replaced by mistake."""

    def __init__(self, *endings: str) -> None:
        super().__init__(path_type=Path, dir_okay=False)
        self._endings = endings

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> Path:  # type: ignore[override]
        """Return the path."""
        path = Path(str(super().convert(value, param, ctx)))
        if path.suffix.lower() not in self._endings:
            self.fail(f"expected a name that ends with {' or '.join(self._endings)}, got {path}", param, ctx)
        return path


class _WhoType(click.ParamType["ComponentId"]):
    name = "system-component"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> ComponentId:
        """Return whom 1-191 means."""
        from ross_protocols.mavlink.component_id import ComponentId

        try:
            return ComponentId.parse(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)


@click.command("tlog", short_help="Summarize a flight: a telemetry log or a session folder.", epilog=EPILOG)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--payload", type=_WhoType(), help="Only this payload, such as 1-191.")
@click.option("--picture", type=_Ending(".png", ".svg"), help="Save a plot of the flight (.png or .svg).")
@click.option("--mcap", type=_Ending(".mcap"), help="Export to MCAP, for Foxglove and other tools.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(*, file: Path, payload: ComponentId | None, picture: Path | None, mcap: Path | None, as_json: bool) -> None:
    """Summarize a telemetry log (.tlog of RoSS, Mission Planner, QGroundControl or MAVProxy) or a session folder.

    An output file replaces an earlier one of the same name once it is complete.
    """
    import json

    from rich.console import Console

    from ross_payload.ground.flights.reading import open_flight
    from ross_payload.ground.flights.summary import FlightContent, chosen, summary
    from ross_payload.ground.flights.table import show

    flight = open_flight(file)
    content = FlightContent(flight, chosen(flight, payload))
    if picture is not None:
        _needing("sim", "--picture", "plot").draw(content, picture)
    if mcap is not None:
        _needing("mcap", "--mcap", "mcap").export(flight, content.payloads, mcap)
    if as_json:
        click.echo(json.dumps(summary(content), indent=2, allow_nan=False))
    else:
        show(summary(content), Console())


def _needing(extra: str, option: str, name: str) -> Any:
    """Return a module of this room that needs an extra."""
    from importlib import import_module

    try:
        return import_module(f"ross_payload.ground.flights.{name}")
    except ImportError as error:
        raise GroundError(f"{option} needs the extra '{extra}': {install_line(extra)}") from error
