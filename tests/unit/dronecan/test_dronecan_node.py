"""Our node on a bus in this process, in virtual time: its id, its heartbeat, clashes, and who shares the bus."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as some

from dronecan_wire import PERIOD, UNIQUE, Stranger, Wire, node_on, of, run
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.messages import Allocation, Health, LogMessage, Mode, NodeStatus, Received
from ross_protocols.dronecan.node_messages import Reply
from ross_protocols.dronecan.services import NodeInfo, NodeInfoRequest, TransportStats, TransportStatsRequest


def test_the_heart_beats_once_a_second_and_says_how_the_node_is(wire, stranger):
    node = node_on(wire)
    node.stands(Health.ERROR, Mode.OPERATIONAL, 9)
    run(node, 3.5)
    assert stranger.heard() == [Received(42, NodeStatus(n, Health.ERROR, Mode.OPERATIONAL, 9)) for n in range(4)]


def test_who_it_is_is_told_to_whoever_asks(wire, stranger):
    node = node_on(wire)
    stranger.say(stranger.voice.request(NodeInfoRequest(), 42))
    node.poll(7.0)
    info = next(said.response for said in stranger.heard() if isinstance(said, Reply))
    assert info == NodeInfo(NodeStatus(7, mode=Mode.INITIALIZATION), "org.ross.payload", UNIQUE, (1, 2))


def test_it_counts_what_it_sends_hears_and_cannot_read(wire, stranger):
    node = node_on(wire)
    first, *rest = stranger.voice.broadcast(LogMessage(1, "servo", "too long for one frame"))
    stranger.say([*rest, first, *rest])
    node.poll(0.0)
    stranger.say(stranger.voice.request(TransportStatsRequest(), 42))
    node.poll(0.1)
    stats = next(said.response for said in stranger.heard() if isinstance(said, Reply))
    assert stats == TransportStats(1, 2, len(rest), 1, 2 * len(rest) + 2)


def test_what_is_asked_of_others_is_not_answered(wire, stranger):
    node = node_on(wire)
    stranger.say(stranger.voice.request(NodeInfoRequest(), 43))
    node.poll(0.0)
    assert not any(isinstance(said, Reply) for said in stranger.heard())


def test_a_flood_of_questions_is_answered_in_part(wire, stranger):
    node = node_on(wire)
    for _ in range(1000):
        stranger.say(stranger.voice.request(NodeInfoRequest(), 42))
    node.poll(0.0)
    assert sum(isinstance(said, Reply) for said in stranger.heard()) == 5


def test_broadcasts_reach_whoever_subscribed(wire, stranger):
    node, heard = node_on(wire), []
    node.subscribe(lambda received, now: heard.append((received, now)))
    stranger.say(stranger.voice.broadcast(LogMessage(1, "servo", "hello")))
    node.poll(0.5)
    assert heard == [(Received(9, LogMessage(1, "servo", "hello")), 0.5)]


def test_leaving_is_said(wire, stranger):
    node = node_on(wire)
    node.close()
    assert stranger.heard()[-1].message.mode is Mode.OFFLINE
    assert len(wire.ends) == 1


# ------------------------------------------------------------------------------------- two nodes with one id


def test_a_node_with_our_fixed_id_silences_us_until_it_has_gone(wire, stranger):
    node, twin = node_on(wire), Stranger(wire, 42)
    run(node, 0.5)
    twin.say(twin.voice.broadcast(NodeStatus(1)))
    run(node, 1.0, 0.5)
    assert node.id == 0
    assert "another node on the bus has our node id 42" in node.trouble
    assert not node.send(LogMessage(1, "ross", "unheard"))
    stranger.heard()
    run(node, 4.0, 1.5)
    assert stranger.heard() == []
    run(node, 2.0, 5.5)
    assert (node.id, node.trouble) == (42, "")
    assert of(NodeStatus, stranger.heard())


def test_a_node_with_our_allocated_id_makes_us_ask_for_another_one(wire):
    node, twin, allocator = node_on(wire, 0), Stranger(wire, 50), Table(Stranger(wire, 1), [50, 51])
    now = alternate(node, allocator, until=lambda: node.id)
    assert node.id == 50
    twin.say(twin.voice.broadcast(NodeStatus(1)))
    node.poll(now)
    assert node.id == 0
    assert "has our node id 50: requesting another one" in node.trouble
    alternate(node, allocator, now, until=lambda: node.id)
    assert (node.id, node.trouble) == (51, "")


# ------------------------------------------------------------------------------------- allocation


class Table:
    """An allocator that gives the ids of a list, one after the other."""

    def __init__(self, stranger, ids):
        self.stranger, self.ids, self.so_far, self.asked = stranger, iter(ids), b"", []

    def poll(self):
        for said in of(Allocation, self.stranger.heard()):
            told = said.message
            self.asked.append(told)
            self.so_far = told.unique_id if told.first else self.so_far + told.unique_id
            given = next(self.ids) if len(self.so_far) == 16 else 0
            self.stranger.say(self.stranger.voice.broadcast(Allocation(given, self.so_far)))


def alternate(node, allocator, now=0.0, *, until, within=10.0):
    end = now + within
    while not until():
        assert now < end, "too late"
        node.poll(now)
        allocator.poll()
        now += PERIOD
    return now


def test_an_id_is_asked_for_in_three_parts_and_kept(wire):
    kept = []
    node, allocator = node_on(wire, 0, allocated=kept.append), Table(Stranger(wire, 1), [77])
    now = alternate(node, allocator, until=lambda: node.id)
    assert [len(told.unique_id) for told in allocator.asked] == [6, 6, 4]
    assert (node.id, kept) == (77, [77])
    assert 0.6 <= now < 1.0 + 2 * 0.4 + 0.2


def test_a_node_without_an_id_says_nothing_but_its_wish(wire, stranger):
    node = node_on(wire, 0)
    assert not node.send(LogMessage(1, "ross", "unheard"))
    run(node, 10.0)
    said = stranger.heard()
    assert {type(each.message) for each in said} == {Allocation}
    assert {each.node for each in said} == {0}
    assert 10 <= len(said) <= 17  # every 0.6 to 1 s
    assert "no allocator on the bus answers" in node.trouble


def test_an_id_meant_for_somebody_else_is_not_ours(wire, stranger):
    node = node_on(wire, 0)
    for unique_id in (UNIQUE[:15] + b"x", UNIQUE[::-1], b""):
        stranger.say(stranger.voice.broadcast(Allocation(66, unique_id)))
    run(node, 1.0)
    assert node.id == 0


def test_two_nodes_that_ask_at_once_both_get_an_id(wire):
    nodes = [node_on(wire, 0, bytes([7]) * 5 + bytes([n]) * 11) for n in range(2)]
    allocator, now = Table(Stranger(wire, 1), range(60, 100)), 0.0
    while not all(node.id for node in nodes) and now < 30.0:
        for node in nodes:
            node.poll(now)
        allocator.poll()
        now += PERIOD
    assert nodes[0].id != nodes[1].id
    assert all(node.id for node in nodes)


# ------------------------------------------------------------------------------------- damage


def frames_of_chance(chance, count):
    """Frames that are nearly right more often than chance would have them."""
    for _ in range(count):
        identifier = chance.randrange(2**29)
        if chance.random() < 0.7:
            number = chance.choice([1, 5, 10, 11, 4])
            service = number << 16 | chance.choice([0, 0x8000]) | 42 << 8 | 0x80
            broadcast = chance.choice([1, 341, 1010, 1011, 16383, 20854, 20855]) << 8
            identifier = chance.randrange(32) << 24 | chance.choice([service, broadcast]) | chance.randrange(128)
        data = chance.randbytes(chance.randrange(9))
        if data and chance.random() < 0.7:
            data = data[:-1] + bytes([chance.choice([0xC0, 0x80, 0x20, 0x40, 0x60]) | chance.randrange(2)])
        yield CanFrame(identifier, data, chance.random() < 0.9)


IDENTIFIERS = some.builds(
    lambda priority, number, source: priority << 24 | number << 8 | source,
    some.integers(0, 31),
    some.one_of(some.integers(0, 2**16 - 1), some.sampled_from([1, 341, 16383, 20855, 0x01AA, 0x0BAA, 0x0AAA, 0x05AA])),
    some.integers(0, 255),
)  # 0xNNAA: requests for node 42, when the source has bit 7 set
FRAMES = some.builds(CanFrame, IDENTIFIERS, some.binary(max_size=8), some.booleans())


@given(some.lists(FRAMES, max_size=40))
def test_whatever_is_on_the_bus_the_node_lives_and_keeps_its_id_or_says_why(frames):
    wire, now = Wire(), 0.0
    node, sender = node_on(wire), wire.open()
    for frame in frames:
        sender.send(frame)
        node.poll(now := now + PERIOD)
    assert (node.id == 42) == (node.trouble == "")


@pytest.mark.parametrize("count", [5_000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_random_frames_never_raise(wire, count):
    node, sender = node_on(wire), wire.open()
    for n, frame in enumerate(frames_of_chance(random.Random(1), count)):  # noqa: S311
        sender.send(frame)
        if n % 10 == 0:
            node.poll(n * 1e-4)
            sender.receive()
    run(node, 7.0, count * 1e-4)
    assert node.id == 42
