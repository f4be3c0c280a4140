"""``ross hub``: a CAN bus between processes."""

from __future__ import annotations

import json

import click

EPILOG = """Who can reach the port can use it: keep it on the loopback. Ctrl-C or SIGTERM ends it. Exit codes: 0 ended
by the user, 2 bad input. Port 0: any free port."""


@click.command("hub", short_help="Provide a CAN bus between processes, without a kernel driver.", epilog=EPILOG)
@click.option("--listen", default="tcp:127.0.0.1:29536", show_default=True, metavar="tcp:HOST:PORT")
@click.option("--json", "as_json", is_flag=True, help="Print the address as one line of JSON.")
def command(*, listen: str, as_json: bool) -> int:
    """Be a CAN bus between processes, without a kernel driver: a socketcand server with any number of channels.

    Nodes join with python-can's interface socketcand, and RoSS with port = "can:socketcand:HOST:PORT:CHANNEL".
    """
    import asyncio
    import signal

    from ross_payload.clock import SystemClock
    from ross_sim.devices.address import tcp_address
    from ross_sim.devices.hub import Hub

    host, port = tcp_address(listen, "--listen")

    def told(port: int) -> None:
        name = f"[{host}]" if ":" in host else host
        address = f"can:socketcand:{name}:{port}"
        click.echo(json.dumps({"hub": address}) if as_json else f"ready: {address}:CHANNEL, any CHANNEL")

    async def live() -> None:
        ended = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, ended.set)
        await Hub(SystemClock()).serve(host, port, told, ended)

    asyncio.run(live())
    return 0
