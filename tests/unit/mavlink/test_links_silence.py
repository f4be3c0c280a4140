"""What hides behind a damaged frame is heard as soon as it is silent, not when enough else has come."""

import pytest

from clocks import FakeClock
from ross_payload.config import Link
from ross_payload.mavlink import Received, Router
from ross_payload.mavlink.decoders import SILENCE
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common

STOP = common.MAVLink_command_long_message(1, 191, 54004, 0, 0, 0, 0, 0, 0, 0, 0)
BEAT = common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
LENGTH, FLAGS, ID = 1, 2, 8  # bytes of a frame


class Wire:
    """The far end of a link."""

    def __init__(self) -> None:
        self.counts = Counts()
        self.coming: list[bytes] = []

    def send(self, frame: bytes) -> None:
        raise AssertionError("nobody speaks here")

    def receive(self) -> list[bytes]:
        coming, self.coming = self.coming, []
        return coming

    def close(self) -> None:
        """Nothing to give back."""


@pytest.fixture
def ear() -> tuple[Router, Wire, FakeClock, list[Received]]:
    clock, wire, heard = FakeClock(), Wire(), []
    links = Router(clock, 1)
    links.attach(Link(url="serial:/dev/ttyAMA0:57600"), wire)
    links.component(191).subscribe(heard.append)
    return links, wire, clock, heard


def damaged(frame: bytes, place: int, value: int) -> bytes:
    return frame[:place] + bytes([value]) + frame[place + 1 :]


@pytest.mark.parametrize(("place", "value"), [(LENGTH, 255), (FLAGS, 1), (ID, 200)], ids=["length", "flags", "id"])
def test_a_stop_behind_a_damaged_frame_is_heard_after_a_silence(
    ear: tuple[Router, Wire, FakeClock, list[Received]], place: int, value: int
) -> None:
    links, wire, clock, heard = ear
    encoder = Encoder(255, 190)
    wire.coming = [damaged(encoder.encode(BEAT), place, value), encoder.encode(STOP)]
    links.poll()
    clock.time += SILENCE + 0.01
    links.poll()
    assert [one.packet.name for one in heard] == ["COMMAND_LONG"]
    (status,) = links.status()
    assert status.bad + status.unknown >= 1


def test_a_frame_in_two_pieces_is_waited_for(ear: tuple[Router, Wire, FakeClock, list[Received]]) -> None:
    links, wire, clock, heard = ear
    frame = Encoder(255, 190).encode(STOP)
    for piece in (frame[:20], frame[20:]):
        wire.coming = [piece]
        links.poll()
        clock.time += SILENCE - 0.01
    links.poll()
    assert [one.packet.name for one in heard] == ["COMMAND_LONG"]
    assert links.status()[0].bad == 0


def test_an_unknown_frame_before_a_silence_is_unknown_and_not_bad(
    ear: tuple[Router, Wire, FakeClock, list[Received]],
) -> None:
    links, wire, clock, _ = ear
    wire.coming = [damaged(Encoder(255, 190).encode(BEAT), ID, 200)]
    links.poll()
    clock.time += SILENCE + 0.01
    links.poll()
    assert (links.status()[0].unknown, links.status()[0].bad) == (1, 0)
