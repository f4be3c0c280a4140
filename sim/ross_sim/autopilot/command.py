"""``ross autopilot``: a simulated autopilot in a process of its own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from datetime import UTC, datetime

import click

from ross_payload.option_types import Number, NumberRange

EPILOG = """URLs are udpin:host:port, udpout:host:port, tcp:host:port, tcpin:host:port or serial:device:baud. Ctrl-C or
SIGTERM ends it."""
PERIOD = 0.002  # [s] between two looks at the links


@click.command("autopilot", short_help="Simulate an autopilot between a payload and the ground.", epilog=EPILOG)
@click.option(
    "--link", "urls", metavar="URL", multiple=True, required=True, help="A link; can be given more than once."
)
@click.option("--system-id", type=click.IntRange(1, 255), default=1, show_default=True, help="Of the vehicle.")
@click.option(
    "--yaw",
    "yaw_deg",
    type=Number(),
    default=0.0,
    show_default=True,
    help="Clockwise from north [deg].",
)
@click.option("--amplitude", "amplitude_deg", type=NumberRange(0, 180), default=0.0, show_default=True,
              help="Oscillate in yaw by this much to either side [deg].")  # fmt: skip
@click.option("--rate", "rate_deg_s", type=NumberRange(0, 360, min_open=True), default=10.0, show_default=True,
              help="Yaw rate of the oscillation [deg/s].")  # fmt: skip
@click.option("--gps", is_flag=True, help="Send the UNIX time.")
@click.option("--gimbal", "with_gimbal", is_flag=True, help="Add a simulated gimbal and be its gimbal manager.")
def command(
    *,
    urls: Sequence[str],
    system_id: int,
    yaw_deg: float,
    amplitude_deg: float,
    rate_deg_s: float,
    gps: bool,
    with_gimbal: bool,
) -> None:
    """Simulate what a payload receives from ArduPilot: attitude, time, a gimbal, and message routing.

    Like ArduPilot, it drops messages that it does not know (all of ours among them), forwards a message with a target
    only to links where that target was heard, and never sends a message back where it came from.
    """
    from ross_payload.clock import SystemClock
    from ross_payload.transport.open_port import open_port
    from ross_sim.autopilot.simulated_autopilot import BOOT, Autopilot, CarriedGimbal
    from ross_sim.autopilot.yaw import Yaw

    clock = SystemClock()
    begin = clock.now()
    motion = Yaw(-math.radians(yaw_deg), math.radians(amplitude_deg), math.radians(rate_deg_s))
    unix = datetime.now(tz=UTC).timestamp() if gps else None
    carried = CarriedGimbal(clock, system_id, motion.at, BOOT) if with_gimbal else None
    autopilot = Autopilot(motion, system_id=system_id, unix=unix, manager=None if carried is None else carried.manager)
    with ExitStack() as stack:
        if carried is not None:
            autopilot.plug("gimbal", carried.port)
        for url in dict.fromkeys(urls):
            port = open_port(url, clock.now)
            stack.callback(port.close)
            autopilot.plug(url, port)
        click.echo("ready")
        while True:
            if carried is not None:
                carried.advance(clock.now() - begin)
            autopilot.advance(clock.now() - begin)
            clock.sleep(PERIOD)
