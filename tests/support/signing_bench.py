"""A payload with one signed link, and ground stations that sign by pymavlink."""

from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from clocks import FakeClock
from links_bench import BEAT, Wire
from ross_payload.config import Link
from ross_payload.mavlink import Received, Router
from ross_protocols.mavlink.signing import timestamp_of

KEY = bytes(range(32))
OTHER = bytes(32)
STOP, EXPLORE = 54004, 54000
TODAY = 1_795_000_000.0  # UNIX [s]


class Payload:
    """One life of a payload with one signed link; ``die`` is a power cut, leaving the block an orderly end."""

    def __init__(self, state: Path, key_file: Path, unix: float = TODAY) -> None:
        self.clock = FakeClock()
        self.wire = Wire()
        self.links = Router(self.clock, 1, state, lambda: unix + self.clock.time)
        self.links.attach(Link(url="udpin::14550", key_file=str(key_file)), self.wire)
        self.heard: list[Received] = []
        self.links.component(191).subscribe(self.heard.append)

    def hear(self, *frames: bytes) -> int:
        """Return how many of these frames were believed."""
        before = len(self.heard)
        self.wire.coming += frames
        self.links.poll()
        return len(self.heard) - before

    def say(self) -> bytes:
        self.links.component(191).send(BEAT)
        return self.wire.sent[-1]

    def settle(self) -> None:
        """Wait until the file is written."""
        saving = self.links._signing._saving if self.links._signing else None
        if saving is not None:
            saving.exception(timeout=20)

    def __enter__(self) -> "Payload":
        return self

    def __exit__(self, *_: object) -> None:
        self.links.close()


class GroundStation:
    """pymavlink itself: another implementation of signing."""

    def __init__(self, key: bytes = KEY, unix: float = TODAY, link_id: int = 7) -> None:
        self.mav = common.MAVLink(None, srcSystem=255, srcComponent=190)
        self.mav.robust_parsing = True
        self.mav.signing.secret_key = key
        self.mav.signing.sign_outgoing = True
        self.mav.signing.link_id = link_id
        self.mav.signing.timestamp = timestamp_of(unix)

    def say(self) -> bytes:
        frame = bytes(common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(self.mav))
        self.mav.seq = (self.mav.seq + 1) % 256
        return frame

    def believes(self, frame: bytes) -> bool:
        return [message.get_type() for message in self.mav.parse_buffer(frame) or []] == ["HEARTBEAT"]


class GroundStationWithoutKey(GroundStation):
    """Signs nothing."""

    def __init__(self) -> None:
        super().__init__()
        self.mav.signing.sign_outgoing = False


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    path = tmp_path / "key"
    path.write_bytes(KEY)
    path.chmod(0o600)
    return path


@pytest.fixture
def payload(tmp_path: Path, key_file: Path):
    with Payload(tmp_path / "state", key_file) as payload:
        yield payload


def order(ground: GroundStation, number: int) -> bytes:
    return bytes(common.MAVLink_command_long_message(1, 191, number, 0, *[0.0] * 7).pack(ground.mav))
