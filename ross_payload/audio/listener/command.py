"""``ross listen``: hear what a payload streams."""

from __future__ import annotations

from pathlib import Path

import click

from ross_payload.option_types import NumberRange

LONGEST_DELAY_MS = 1000.0


@click.command("listen", short_help="Play or save the audio that a payload streams.")
@click.argument("url", metavar="URL")
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="FILE", help="Write a .wav or .flac file instead of playing."
)
@click.option("--device", default="default", show_default=True, help="Sound output, by part of its name.")
@click.option(
    "--delay",
    "delay_ms",
    type=NumberRange(0, LONGEST_DELAY_MS),
    default=0.0,
    help="Playout delay [ms]; 0, the default: as short as the network allows.",
)
@click.option(
    "--duration",
    type=NumberRange(0, min_open=True, infinite=True),
    metavar="S",
    help="Stop after this many seconds.",
)
@click.option("--wait", "waits", is_flag=True, help="Keep waiting when the sender stops or is silent (RTP only).")
def command(url: str, out: Path | None, device: str, delay_ms: float, duration: float | None, *, waits: bool) -> None:
    """Play the audio that a payload streams to this computer; print level, delay and losses once a second.

    It ends when the sender stops; with exit code 2 when nothing more has arrived for 25 s.

    URL is rtp://ADDRESS:PORT (an address of this computer; 0.0.0.0 for any; with ?codec=L16&rate=16000 unless it is
    Opus), a session description (a file or an http address that ends in .sdp), or tcp://HOST:PORT.
    """
    import time

    from ross_payload.audio.listener.feed import Feed, source_of
    from ross_payload.audio.listener.pcm_feed import PcmFeed
    from ross_payload.audio.listener.playback import Meter, checked_file, listen, to_device, to_file
    from ross_payload.clock import SystemClock
    from ross_payload.errors import ConfigError
    from ross_payload.transport.rtp.session_description import Session

    path = checked_file(out) if out is not None else None
    clock, meter, source = SystemClock(), Meter(), source_of(url)
    feed: Feed
    if isinstance(source, Session):
        from ross_payload.audio.listener.rtp_feed import RtpFeed

        feed = RtpFeed(source, clock, delay_ms / 1000)
    else:
        if waits:
            raise ConfigError(f"--wait: expected a stream of RTP, got {url}: a connection that has ended is over")
        feed = PcmFeed(source)
    with feed:
        place = to_file(feed, path, meter, clock) if path is not None else to_device(feed, device, meter)
        listen(feed, place, meter=meter, clock=clock, wall=time.time, report=click.echo, duration=duration, waits=waits)
