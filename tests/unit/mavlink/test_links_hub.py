"""The hub: our own components, who hears what, where it goes, how much of it, and what is counted."""

import math

import pytest

from links_bench import ATTITUDE, BEAT, GROUND, PILOT, VEHICLE, Bench, command
from ross_payload.config import Link
from ross_payload.mavlink import Received
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common

# ---------------------------------------------------------------------------------------------------- components


def test_what_arrives_is_heard_with_its_link() -> None:
    bench = Bench(GROUND, PILOT)
    bench.say(PILOT.url, ATTITUDE)
    (heard,) = bench.heard
    assert (heard.link, heard.role, heard.packet.name, heard.may_order) == (PILOT.url, "autopilot", "ATTITUDE", True)


def test_every_component_hears_what_arrives() -> None:
    bench = Bench(GROUND)
    others: list[Received] = []
    bench.links.component(154).subscribe(others.append)
    bench.say(GROUND.url, ATTITUDE)
    assert [heard.packet.name for heard in others] == bench.names() == ["ATTITUDE"]


def test_a_message_goes_out_on_every_link_and_to_the_other_components() -> None:
    bench = Bench(GROUND, PILOT)
    bench.links.component(154).send(BEAT)
    bench.links.poll()
    assert [len(wire.sent) for wire in bench.wires.values()] == [1, 1]
    (heard,) = bench.heard
    assert (heard.role, heard.packet.component_id, heard.packet.value, heard.may_order) == ("local", 154, BEAT, True)


def test_a_component_does_not_hear_itself() -> None:
    bench = Bench(GROUND)
    bench.links.component(154)
    bench.payload.send(BEAT)
    bench.links.poll()
    assert bench.heard == []


def test_two_components_that_answer_each_other_do_not_hold_up_a_poll() -> None:
    bench = Bench(GROUND)
    other = bench.links.component(154)
    other.subscribe(lambda heard: other.send(ATTITUDE))
    bench.payload.subscribe(lambda heard: bench.payload.send(ATTITUDE))
    bench.payload.send(ATTITUDE)
    for _ in range(10):
        bench.links.poll()
    assert len(bench.wires[GROUND.url].sent) == 11, "one answer per poll"


def test_a_message_to_one_link_stays_there() -> None:
    bench = Bench(GROUND, PILOT)
    bench.payload.send(BEAT, PILOT.url)
    assert [len(wire.sent) for wire in bench.wires.values()] == [0, 1]


def test_sequence_numbers_count_per_component_and_link() -> None:
    bench = Bench(GROUND, PILOT)
    gimbal = bench.links.component(154)
    for _ in range(2):
        bench.payload.send(BEAT)
    gimbal.send(BEAT)
    bench.payload.send(BEAT, GROUND.url)
    ground = [(packet.component_id, packet.sequence) for packet in bench.wires[GROUND.url].packets()]
    pilot = [(packet.component_id, packet.sequence) for packet in bench.wires[PILOT.url].packets()]
    assert ground == [(191, 0), (191, 1), (154, 0), (191, 2)]
    assert pilot == [(191, 0), (191, 1), (154, 0)]


def test_a_tap_hears_each_frame_once_also_without_links() -> None:
    for bench in (Bench(), Bench(GROUND, PILOT)):
        frames: list[bytes] = []
        bench.payload.tap(frames.append)
        bench.payload.send(BEAT)
        bench.payload.send(ATTITUDE)
        assert [packet.name for packet in Decoder().feed(b"".join(frames))] == ["HEARTBEAT", "ATTITUDE"]


def test_what_is_repeated_on_a_link_is_in_no_log_and_is_not_heard_locally() -> None:
    bench = Bench(GROUND, PILOT)
    frames: list[bytes] = []
    bench.payload.tap(frames.append)
    bench.links.component(154)
    bench.payload.repeat(BEAT, GROUND.url)
    bench.links.poll()
    assert [len(wire.sent) for wire in bench.wires.values()] == [1, 0]
    assert frames == []


def test_closing_closes_ports_made_elsewhere() -> None:
    bench = Bench(GROUND)
    with bench.links:
        pass
    assert not bench.wires[GROUND.url].open


# ---------------------------------------------------------------------------------------------------- routes


def test_a_targeted_message_goes_where_its_target_was_heard() -> None:
    bench = Bench(GROUND, PILOT)
    bench.payload.send(command(1, 1))
    assert [len(wire.sent) for wire in bench.wires.values()] == [1, 1], "not heard yet: everywhere"
    bench.say(PILOT.url, VEHICLE)
    bench.payload.send(command(1, 1))
    bench.payload.send(command(1, 0))  # any component of that system
    bench.payload.send(BEAT)
    assert [len(wire.sent) for wire in bench.wires.values()] == [2, 4]


def test_a_message_to_our_own_component_stays_inside() -> None:
    bench = Bench(GROUND)
    gimbal: list[Received] = []
    bench.links.component(154).subscribe(gimbal.append)
    bench.payload.send(command(1, 154))
    bench.links.poll()
    assert [heard.packet.name for heard in gimbal] == ["COMMAND_LONG"]
    assert bench.wires[GROUND.url].sent == []


def test_a_thousand_senders_do_not_fill_the_memory() -> None:
    bench = Bench(GROUND)
    for number in range(1000):
        bench.say(GROUND.url, BEAT, system=number % 250 + 2, component=number // 250 + 1)
    (status,) = bench.links.status()
    assert len(status.peers) == 64
    bench.say(GROUND.url, BEAT, system=255, component=190)
    assert (255, 190) in bench.links.status()[0].peers


def test_who_has_left_is_no_peer() -> None:
    bench = Bench(GROUND)
    bench.say(GROUND.url, BEAT, system=255, component=190)
    assert bench.links.status()[0].peers == ((255, 190),)
    bench.clock.time += 11.0
    assert bench.links.status()[0].peers == ()


# ---------------------------------------------------------------------------------------------------- counts


@pytest.mark.parametrize(
    ("sequences", "lost"),
    [
        ([0, 1, 2], 0),
        ([0, 3, 4], 2),
        ([254, 255, 0, 1], 0),
        ([254, 1], 2),
        ([5, 5, 5], 0),
        ([5, 7, 6, 8], 0),
        ([5, 7, 7, 8], 1),
    ],
)
def test_missing_frames_are_counted(sequences: list[int], lost: int) -> None:
    bench = Bench(GROUND)
    for sequence in sequences:
        bench.say(GROUND.url, BEAT, system=255, component=190, sequence=sequence)
    assert bench.links.status()[0].lost == lost


def test_senders_are_counted_apart() -> None:
    bench = Bench(GROUND)
    for sequence in range(10):
        bench.say(GROUND.url, BEAT, system=255, component=190, sequence=sequence)
        bench.say(GROUND.url, BEAT, system=255, component=191, sequence=(7 * 10 + sequence) % 256)
    assert bench.links.status()[0].lost == 0


def test_what_went_through_is_counted() -> None:
    bench = Bench(GROUND)
    frame = bytearray(Encoder(255, 190).encode(BEAT))
    bench.hear(GROUND.url, bytes(frame))
    frame[-1] ^= 1
    bench.hear(GROUND.url, bytes(frame))
    bench.payload.send(BEAT)
    (status,) = bench.links.status()
    assert (status.received, status.received_bytes, status.bad) == (1, 2 * len(frame), 1)
    assert (status.sent, status.sent_bytes, status.dropped) == (1, len(frame), 0)
    assert (status.url, status.role, status.up, status.room) == (GROUND.url, "ground", True, math.inf)


# ---------------------------------------------------------------------------------------------------- budget


def test_a_link_says_no_more_than_its_budget_and_counts_the_rest() -> None:
    bench = Bench(Link(url="udpin::1", max_bytes_s=1000), GROUND)
    for _ in range(60 * 10):
        for _ in range(10):
            bench.payload.send(BEAT)
        bench.clock.time += 0.1
    narrow, wide = bench.links.status()
    assert narrow.sent_bytes == pytest.approx(60 * 1000, rel=0.02)
    assert narrow.sent + narrow.dropped == 6000
    assert (wide.sent, wide.dropped) == (6000, 0)


def test_what_is_dropped_for_the_budget_leaves_no_gap_in_the_count() -> None:
    bench = Bench(Link(url="udpin::1", max_bytes_s=100))
    for _ in range(500):
        bench.payload.send(BEAT)
        bench.clock.time += 0.05
    packets = bench.wires["udpin::1"].packets()
    assert [packet.sequence for packet in packets] == list(range(len(packets)))


def test_the_room_is_what_may_still_be_said() -> None:
    bench = Bench(Link(url="udpin::1", max_bytes_s=1000))
    before = bench.links.status()[0].room
    bench.payload.send(BEAT)
    assert bench.links.status()[0].room == before - len(bench.wires["udpin::1"].sent[0])


def test_the_largest_frame_fits_even_a_tiny_budget() -> None:
    bench = Bench(Link(url="udpin::1", max_bytes_s=1))
    bench.payload.send(common.MAVLink_tunnel_message(0, 0, 32768, 128, [1] * 128))
    assert len(bench.wires["udpin::1"].sent) == 1
