"""``ross device`` and ``ross hub``: one simulated device, and a virtual CAN bus, in processes of their own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

KINDS = {
    "gimbal": "mavlink_gimbal",
    "vehicle": "vehicle_yaw",
    "servo": "dronecan_servo",
    "drive": "canopen_drive",
    "grbl": "grbl",
    "stepper": "tb6600",
}
EPILOG = """It reads commands from standard input (FAULT, FAULT off, status) and answers each with one line of JSON.
Stop it with Ctrl-C or SIGTERM. Exit codes: 0 stopped by the user, 2 bad input, 1 the connection was lost."""


@click.command("device", short_help="Simulate one device for a payload in another process.", epilog=EPILOG)
@click.argument("kind", type=click.Choice(tuple(KINDS)))
@click.option(
    "--wire",
    metavar="URL",
    help="Address to listen on, or bus to join; default: that of the configuration, or a free local port.",
)
@click.option("--option", "-o", "options", multiple=True, metavar="KEY=VALUE", help="As in [actuator.options].")
@click.option("--config", "file", type=click.Path(path_type=Path), help="Take [actuator] from this payload's file.")
@click.option("--fault", "faults", multiple=True, metavar='"FAULT at S [for S]"', help="Inject a fault.")
@click.option("--json", "as_json", is_flag=True, help="Print the address as one line of JSON.")
def command(
    *, kind: str, wire: str | None, options: Sequence[str], file: Path | None, faults: Sequence[str], as_json: bool
) -> int:
    """Simulate one device with real dynamics, in real time, for a driver of RoSS or of others.

    It reports where it is, not where it was commanded to be.
    """
    from contextlib import ExitStack

    from ross_sim.devices.connections import Coupling, configured_wire, connected
    from ross_sim.devices.device_session import live, planned
    from ross_sim.devices.far_end import far_end_of

    config = _configured(KINDS[kind], options, file)
    far_end = far_end_of(config)
    turns = [turn for fault in faults for turn in planned(fault, far_end.faults)]

    def connect(epoch: float, stack: ExitStack) -> Coupling:
        connection = connected(config, wire or configured_wire(config), far_end, epoch=epoch, stack=stack)
        _print_ready(config, connection.address, as_json)
        return connection.lead

    live(far_end, connect, turns, click.echo)
    return 0


def _configured(kind: str, options: Sequence[str], file: Path | None) -> Any:
    """A payload's configuration with this actuator."""
    from ross_payload.config import Config, load, validated
    from ross_payload.errors import ConfigError

    if file is None:
        table = {"actuator": {"kind": kind, "options": dict(_option(text) for text in options)}}
        return validated(Config, table, "--option")
    if options:
        raise ConfigError("--option and --config: expected one of them, got both")
    config = load(file)
    if config.actuator.kind != kind:
        raise ConfigError(f"{file}: actuator.kind: expected '{kind}', got '{config.actuator.kind}'")
    return config


def _option(text: str) -> tuple[str, Any]:
    """Read KEY=VALUE; the value as in TOML, or else as a word."""
    from ross_payload.bounded_files import toml_value
    from ross_payload.errors import ConfigError

    key, equals, value = text.partition("=")
    if not (key.strip() and equals):
        raise ConfigError(f"--option: expected KEY=VALUE, got '{text}'")
    return key.strip(), toml_value(value.strip())


def _print_ready(config: Any, address: str, as_json: bool) -> None:
    """Say that the device is ready, and what a payload's configuration needs."""
    from ross_sim.devices.connections import advice

    if as_json:
        click.echo(json.dumps({"kind": config.actuator.kind, "wire": address}))
    else:
        click.echo(f"ready. The payload's configuration:\n\n{advice(config, address)}")


HUB_EPILOG = """Anyone who can reach the port can use the bus, so keep it on the loopback interface. Port 0 takes
any free port. Stop it with Ctrl-C or SIGTERM. Exit codes: 0 stopped by the user, 2 bad input."""


@click.command("hub", short_help="Run a virtual CAN bus for several processes.", epilog=HUB_EPILOG)
@click.option("--listen", default="tcp:127.0.0.1:29536", show_default=True, metavar="tcp:HOST:PORT")
@click.option("--json", "as_json", is_flag=True, help="Print the address as one line of JSON.")
def hub(*, listen: str, as_json: bool) -> int:
    """Run a virtual CAN bus for several processes: a socketcand server with any number of channels.

    No kernel driver is needed. Nodes join with python-can's interface socketcand, and RoSS with
    port = "can:socketcand:HOST:PORT:CHANNEL".
    """
    import asyncio

    from ross_payload.clock import SystemClock
    from ross_payload.errors import ConfigError
    from ross_payload.transport.async_task import set_by_signal
    from ross_payload.transport.link_url import tcp_endpoint
    from ross_sim.devices.can_hub import CanHub

    host, port = tcp_endpoint(listen, "--listen", min_port=0)
    if ":" in host:
        raise ConfigError(f"--listen: expected an IPv4 host, since clients of socketcand know no other, got '{listen}'")

    def on_port(port: int) -> None:
        address = f"can:socketcand:{host}:{port}"
        click.echo(json.dumps({"hub": address}) if as_json else f"ready: {address}:CHANNEL, any CHANNEL")

    async def live() -> None:
        await CanHub(SystemClock()).serve(host, port, on_port, set_by_signal())

    asyncio.run(live())
    return 0
