"""Bad weather: loss, doubles, disorder, damage, noise, random frames, and a peer that does not stop talking."""

import random
import socket
import time

import pytest
from fastcrc.crc16 import mcrf4xx
from hypothesis import given
from hypothesis import strategies as st

from clocks import FakeClock
from examples import in_soak
from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.config import Link
from ross_payload.mavlink import Received, Router
from ross_payload.mavlink.decoders import LOOKS
from ross_payload.transport.open_port import open_port
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import MESSAGES, common

URL = "udpin::14550"


def dice_of(seed: int) -> random.Random:
    return random.Random(seed)  # noqa: S311


class Wire:
    """The far end of a link."""

    def __init__(self) -> None:
        self.counts = Counts()
        self.coming: list[bytes] = []
        self.sent = 0

    def send(self, frame: bytes) -> None:
        self.sent += 1

    def receive(self) -> list[bytes]:
        coming, self.coming = self.coming, []
        return coming

    def close(self) -> None:
        """Nothing to give back."""


def hub(system_id: int = 1) -> tuple[Router, Wire, list[Received]]:
    links, wire, heard = Router(FakeClock(), system_id), Wire(), []
    links.attach(Link(url=URL, role="autopilot"), wire)
    links.component(191).subscribe(heard.append)
    return links, wire, heard


def numbered(count: int) -> list[bytes]:
    """Return frames that can be told apart."""
    encoder = Encoder(1, 1)
    return [encoder.encode(common.MAVLink_attitude_message(i, i / 7, 0.5, 0.25, 0, 0, 0)) for i in range(count)]


# ---------------------------------------------------------------------------------------------------- bad weather


@pytest.mark.parametrize("rate", [0.01, 0.2])
@pytest.mark.parametrize("seed", [0, *in_soak(1, 2)])
def test_what_arrives_whole_is_heard_in_order(rate: float, seed: int) -> None:
    """But for a few in a thousand: noise can look like a long frame of a message that nobody knows."""
    weather = dice_of(seed)
    stream, whole = [], []
    for number, frame in enumerate(numbered(2000)):
        fate = weather.choices(["lost", "damaged", "noise", "arrives"], [rate, rate, rate, 1 - 3 * rate])[0]
        if fate == "damaged":
            damaged = bytearray(frame)
            damaged[weather.randrange(len(frame))] ^= weather.randrange(1, 256)
            stream.append(bytes(damaged))
        if fate == "noise":
            stream.append(weather.randbytes(weather.randrange(1, 40)))
        if fate in ("noise", "arrives"):
            stream.append(frame)
            whole.append(number)
    decoder, data, got = Decoder(), b"".join(stream) + bytes(600), []
    while data:
        size = weather.randrange(1, 100)
        got += [packet.message.time_boot_ms for packet in decoder.feed(data[:size])]
        data = data[size:]
    assert got == [number for number in whole if number in set(got)]
    assert len(got) >= 0.995 * len(whole)


@pytest.mark.parametrize("rate", [0.2, *in_soak(0.01)])
def test_lost_frames_are_counted(rate: float) -> None:
    weather = dice_of(3)
    links, wire, _ = hub()
    kept = [weather.random() >= rate for _ in range(5000)]
    kept[0] = kept[-1] = True
    wire.coming = [frame for frame, here in zip(numbered(5000), kept, strict=True) if here]
    for _ in range(5000 // LOOKS + 1):
        links.poll()
    assert links.status()[0].lost == kept.count(False)


def test_doubles_and_disorder_are_no_loss() -> None:
    weather = dice_of(4)
    links, wire, heard = hub()
    frames = [frame for frame in numbered(1000) for _ in range(weather.choice([1, 1, 2]))]
    for place in range(0, len(frames) - 1, 7):
        frames[place], frames[place + 1] = frames[place + 1], frames[place]
    for frame in frames:
        wire.coming.append(frame)
        links.poll()
    assert len(heard) == len(frames)
    swapped = sum(one != other for one, other in zip(frames[::7], frames[1::7], strict=False))
    assert links.status()[0].lost <= swapped, "only what overtook looks like a loss"


@given(st.lists(st.binary(max_size=300), max_size=10))
def test_any_bytes_are_noise_or_packets(pieces: list[bytes]) -> None:
    links, wire, heard = hub(system_id=0)
    wire.coming = pieces
    links.poll()
    (status,) = links.status()
    assert status.received == len(heard)
    assert status.received_bytes == sum(map(len, pieces))
    assert wire.sent == 0


@given(st.binary(max_size=60), st.binary(max_size=60))
def test_a_frame_between_noise_is_found(before: bytes, after: bytes) -> None:
    frame = numbered(1)[0]
    packets = Decoder().feed(before + frame + after + bytes(600))
    assert frame in [packet.frame for packet in packets]


# ---------------------------------------------------------------------------------------------------- random frames


def random_frame(dice: random.Random) -> bytes:
    """Return a frame with a good checksum and nothing else to rely on."""
    number = dice.choice(KNOWN) if dice.random() < 0.95 else dice.randrange(1 << 24)
    extra = MESSAGES[number].crc_extra if number in MESSAGES else dice.randrange(256)
    payload = dice.choice([dice.randbytes, bytes, lambda size: b"\xff" * size])(dice.randrange(1, 256))
    system, component = dice.choice([0, 1, 1, 255, dice.randrange(256)]), dice.choice([0, 1, 191, dice.randrange(256)])
    head = bytes([len(payload), 0, dice.randrange(256), dice.randrange(256), system, component])
    body = head + number.to_bytes(3, "little") + payload
    return b"\xfd" + body + mcrf4xx(body + bytes([extra]), 0xFFFF).to_bytes(2, "little")


KNOWN = sorted(MESSAGES)


def storm(count: int) -> None:
    dice = dice_of(5)
    links, wire, heard = hub()
    links.component(154)
    answered: list[bytes] = []
    links.component(191).tap(answered.append)
    known = 0
    for _ in range(count // 100):
        wire.coming = [random_frame(dice) for _ in range(100)]
        known += sum(int.from_bytes(frame[7:10], "little") in MESSAGES for frame in wire.coming)
        links.poll()
    (status,) = links.status()
    assert sum(one.packet.value is not None for one in heard) > known // 50, "reading them harms nobody either"
    assert (status.bad, status.received) == (0, known)
    assert status.received == len(heard) + status.twins
    assert 0 < status.twins < known
    assert not any((one.packet.system_id, one.packet.component_id) in {(1, 191), (1, 154)} for one in heard)
    assert (links.system_id, answered, wire.sent) == (1, [], 0)
    assert len(status.peers) <= 64


def test_ten_thousand_random_frames_change_nothing() -> None:
    storm(10_000)


@pytest.mark.soak
def test_a_million_random_frames_change_nothing() -> None:
    storm(1_000_000)


def test_every_message_of_the_dialect_survives_random_contents() -> None:
    dice = dice_of(6)
    decoder = Decoder()
    for number in KNOWN:
        for fill in (bytes(255), b"\xff" * 255, dice.randbytes(255)):
            body = bytes([255, 0, 0, 0, 9, 9]) + number.to_bytes(3, "little") + fill
            frame = b"\xfd" + body + mcrf4xx(body + bytes([MESSAGES[number].crc_extra]), 0xFFFF).to_bytes(2, "little")
            assert [packet.name for packet in decoder.feed(frame)] == [MESSAGES[number].msgname]


# ---------------------------------------------------------------------------------------------------- floods


def test_a_flood_is_taken_in_bounded_bites_and_nothing_of_it_is_lost_in_here() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        links = Router.open([Link(url=f"tcp:127.0.0.1:{server.getsockname()[1]}")], SystemClock())
        heard: list[Received] = []
        links.component(191).subscribe(heard.append)
        ground, _ = server.accept()
        with links, ground:
            ground.settimeout(20.0)
            ground.sendall(b"".join(numbered(3000)))
            deadline = time.monotonic() + 20
            while len(heard) < 3000:
                before = len(heard)
                links.poll()
                assert len(heard) - before <= LOOKS
                assert time.monotonic() < deadline
    assert [one.packet.message.time_boot_ms for one in heard] == list(range(3000))


def test_a_flood_of_datagrams_is_read_in_bounded_bites() -> None:
    port = open_port("udpout:127.0.0.1:9", SystemClock().now)
    port.close()
    free = free_port()
    port = open_port(f"udpin::{free}", SystemClock().now)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        for _ in range(50):
            peer.sendto(bytes(1400), ("127.0.0.1", free))
        time.sleep(0.2)
        assert sum(map(len, port.receive())) < 8192 + 2048
    port.close()


@pytest.mark.parametrize("noise", [b"\xfe", b"\xfd", b"\xfe\x09", b"\xfd\x09\x00"], ids=bytes.hex)
def test_noise_made_of_markers_costs_no_more_looks(noise: bytes) -> None:
    links, wire, heard = hub()
    wire.coming = [noise * (8192 // len(noise))]
    links.poll()
    bad = links.status()[0].bad
    assert bad <= LOOKS
    wire.coming = [numbered(1)[0] + bytes(600)]
    for _ in range(8192 // LOOKS + 2):
        links.poll()
    assert len(heard) == 1, "what comes behind it is heard all the same"


@pytest.mark.soak
def test_five_thousand_messages_a_second_leave_the_pump_its_time() -> None:
    """Ten seconds of a flood over UDP, polled every 10 ms: each poll is short, and nothing is lost."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        where = probe.getsockname()
    links = Router.open([Link(url=f"udpin:127.0.0.1:{where[1]}")], SystemClock())
    heard: list[Received] = []
    links.component(191).subscribe(heard.append)
    polls = []
    with links, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        for number, frame in enumerate(numbered(50_000)):
            peer.sendto(frame, where)
            if number % 50 == 49:
                before = time.thread_time()
                links.poll()
                polls.append(time.thread_time() - before)
        links.poll()
        assert links.status()[0].lost == 0
    polls.sort()
    print(f"poll: median {1e3 * polls[500]:.2f} ms, p99 {1e3 * polls[990]:.2f} ms, longest {1e3 * polls[-1]:.2f} ms")  # noqa: T201
    assert len(heard) == 50_000
    assert polls[990] < 0.010
