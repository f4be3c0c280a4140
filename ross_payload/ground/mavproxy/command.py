"""``ross mavproxy``: MAVProxy, with our dialect and our module."""

from __future__ import annotations

import importlib.util
import runpy
import sys

import click

from ross_payload.ground.errors import GroundError
from ross_payload.plugins import pip

MODULE = "ross_payload.ground.mavproxy.mavproxy_ross"
PASS_ON = {"ignore_unknown_options": True, "allow_interspersed_args": False}
EPILOG = "Exit codes: those of MAVProxy; 2 when it is not installed."


@click.command(
    "mavproxy", short_help="MAVProxy with RoSS' messages and commands.", context_settings=PASS_ON, epilog=EPILOG
)
@click.argument("arguments", metavar="[ARGUMENTS OF MAVPROXY]...", nargs=-1, type=click.UNPROCESSED)
def command(arguments: tuple[str, ...]) -> None:
    """Run MAVProxy, such as: ross mavproxy --master=udpin:127.0.0.1:14550. Type 'ross help' in it."""
    if importlib.util.find_spec("MAVProxy") is None:
        raise GroundError(f"MAVProxy is not installed here: {pip()} install mavproxy")
    teach()
    sys.argv = ["mavproxy.py", "--dialect", "ardupilotmega", "--load-module", MODULE, *arguments]
    runpy.run_module("MAVProxy.mavproxy", run_name="__main__", alter_sys=True)


def teach() -> None:
    """Let pymavlink's largest dialect, in this process, read our messages and know our commands by name."""
    from pymavlink.dialects.v20 import ardupilotmega

    from ross_protocols.mavlink.dialect import ross

    for number, message in ross.mavlink_map.items():
        ardupilotmega.mavlink_map.setdefault(number, message)
    for name, entries in ross.enums.items():
        ardupilotmega.enums[name] = entries | ardupilotmega.enums.get(name, {})
    for name, thing in vars(ross).items():
        if "_ROSS_" in name:
            setattr(ardupilotmega, name, thing)
