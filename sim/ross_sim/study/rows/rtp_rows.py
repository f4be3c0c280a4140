"""What comes of a voice that is sent by RTP: rows of tests, and their tables.

The tests are ``tests/interop/test_rtp_players.py`` and ``test_rtp_soak.py``, with ``--rows FOLDER``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ross_sim.study.rows.tables import Table, grouped

CODECS = {"opus": "Opus", "L16": "L16"}


@dataclass(frozen=True, slots=True)
class PlayerRow:
    """One player on this computer."""

    player: str
    codec: str
    delay_ms: float  # from the sink to what leaves the player
    si_sdr_db: float


@dataclass(frozen=True, slots=True)
class NetworkRow:
    """One codec through one network in simulated time."""

    network: str
    codec: str
    waiting_ms: float | None  # that packets wait; None: as long as the network needs
    si_sdr_db: float | None  # None: the delay changed meanwhile
    made_up_percent: float
    delay_ms: float  # the whole one, median


def players(rows: Sequence[PlayerRow]) -> Table:
    """Delay and SI-SDR of every player, by codec.

    >>> players([PlayerRow("ffmpeg", "opus", 8.0, 20.44)]).rows
    (('ffmpeg', '8 ms, 20.4 dB', '-'),)
    """
    lines = []
    for player, group in grouped(rows, lambda row: row.player).items():
        found = {row.codec: f"{row.delay_ms:.0f} ms, {row.si_sdr_db:.1f} dB" for row in group}
        lines.append((player, *(found.get(codec, "-") for codec in CODECS)))
    return Table("Players", ("player", *CODECS.values()), tuple(lines))


def networks(rows: Sequence[NetworkRow]) -> Table:
    """SI-SDR where packets wait, and what is made up where the delay adapts, by network and codec.

    >>> waiting = NetworkRow("ideal", "L16", 200.0, 12.06, 0.0, 230.0)
    >>> networks([waiting, NetworkRow("ideal", "L16", None, None, 0.0, 32.0)]).rows
    (('ideal', '-', '-', '12.1 dB', '0.00 %, 32 ms'),)
    """
    lines = []
    for network, group in grouped(rows, lambda row: row.network).items():
        cells = []
        for codec in CODECS:
            mine = [row for row in group if row.codec == codec]
            cells.append(next((f"{row.si_sdr_db:.1f} dB" for row in mine if row.si_sdr_db is not None), "-"))
            adaptive = (f"{row.made_up_percent:.2f} %, {row.delay_ms:.0f} ms" for row in mine if row.waiting_ms is None)
            cells.append(next(adaptive, "-"))
        lines.append((network, *cells))
    header = ("network", *(name for codec in CODECS.values() for name in (codec, "adaptive: made up, whole delay")))
    return Table("Networks", header, tuple(lines))
