"""Our node gives ids to others, and keeps what it gave: with our own allocatee as the one who asks, and by hand."""

import json
import logging

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from dronecan_wire import PERIOD, UNIQUE, Stranger, Wire, node_on, of
from ross_payload.dronecan.allocator import AVOIDED, Allocator
from ross_payload.dronecan.persistence import PersistentIds
from ross_protocols.dronecan.messages import Allocation, NodeStatus
from ross_protocols.dronecan.node_messages import Call
from ross_protocols.dronecan.services import NodeInfo, NodeInfoRequest

OTHER = bytes(range(50, 66))


class Bus:
    """Our node with its allocator, and whoever else lives."""

    def __init__(self, kept=None):
        self.wire, self.now, self.living = Wire(), 0.0, []
        self.kept = kept or PersistentIds(None, np.random.default_rng(1))
        self.node = node_on(self.wire, 121)
        self.allocator = Allocator(self.node, self.kept, 0.0)
        self.asker = Stranger(self.wire, 0)

    def run(self, seconds, until=lambda: False):
        end = self.now + seconds
        while self.now < end and not until():
            self.node.poll(self.now)
            self.allocator.poll(self.now)
            for each in self.living:
                each.poll(self.now)
            self.now += PERIOD

    def ask(self, unique_id, wanted=0):
        """Ask by hand, in three parts; return the id."""
        self.asker.heard()
        for begin, end in ((0, 6), (6, 12), (12, 16)):
            self.asker.end.send(Allocation(wanted, unique_id[begin:end], begin == 0).asked(77, 0))
            self.run(0.1)
            heard = [said.message for said in of(Allocation, self.asker.heard())]
            if not heard or heard[-1].unique_id != unique_id[:end]:
                return None
        return heard[-1].node_id


class Fixed:
    """A node with an id of its own that says who it is."""

    def __init__(self, wire, node_id, unique_id, answers=True):
        self.me, self.unique_id, self.answers = Stranger(wire, node_id), unique_id, answers
        self.next = 0.0

    def poll(self, now):
        if now >= self.next:
            self.next = now + 1.0
            self.me.say(self.me.voice.broadcast(NodeStatus(int(now))))
        for said in self.me.heard():
            if self.answers and isinstance(said, Call) and isinstance(said.request, NodeInfoRequest):
                info = NodeInfo(NodeStatus(int(now)), "org.example.fixed", self.unique_id)
                self.me.say(self.me.voice.response(said, info))


@pytest.fixture
def bus():
    bus = Bus()
    bus.run(3.1)
    return bus


def test_our_own_allocatee_gets_an_id_from_our_allocator(bus):
    asker = node_on(bus.wire, 0, OTHER)
    bus.living.append(asker)
    bus.run(5.0, until=lambda: asker.id)
    assert asker.id == 125
    assert dict(bus.kept.table) == {OTHER: 125}


def test_nobody_gets_an_id_before_everybody_there_can_have_said_so():
    bus = Bus()
    bus.run(2.0)
    assert bus.ask(OTHER) is None


def test_who_comes_back_gets_the_same_id(bus):
    assert [bus.ask(OTHER), bus.ask(UNIQUE[::-1]), bus.ask(OTHER)] == [125, 124, 125]


def test_a_wish_is_met_or_else_the_next_above(bus):
    assert [bus.ask(OTHER, 40), bus.ask(UNIQUE[::-1], 40)] == [40, 41]


def test_our_own_id_and_those_of_cameras_are_never_given(bus):
    assert [bus.ask(OTHER, 121), bus.ask(UNIQUE[::-1], AVOIDED[0])] == [122, 106]


def test_an_id_that_was_heard_is_never_given(bus):
    bus.living.append(Fixed(bus.wire, 125, bytes(16)))
    bus.run(2.0)
    assert bus.ask(OTHER) == 124
    bus.living.clear()
    bus.run(10.0)
    assert bus.ask(UNIQUE[::-1], 125) == 123


@pytest.mark.parametrize("answers", [True, False])
def test_an_id_that_somebody_else_took_meanwhile_is_not_given_again(bus, answers):
    assert bus.ask(OTHER) == 125
    bus.living.append(Fixed(bus.wire, 125, bytes(16), answers))
    bus.run(8.0)
    assert bus.ask(OTHER) == 124


def test_a_node_that_restarts_at_once_gets_its_id_again(bus):
    assert bus.ask(OTHER) == 125
    bus.living.append(Fixed(bus.wire, 125, OTHER))
    bus.run(2.0)
    bus.living.clear()
    assert bus.ask(OTHER) == 125


def test_nobody_gets_an_id_while_somebody_has_not_said_who_he_is(bus):
    bus.living.append(Fixed(bus.wire, 9, bytes(16), answers=False))
    bus.run(0.5)
    assert bus.ask(OTHER) is None
    bus.run(7.0)
    assert bus.ask(OTHER) == 125


def test_we_give_way_to_another_allocator(bus, caplog):
    rival = Stranger(bus.wire, 10)
    with caplog.at_level(logging.WARNING):
        rival.say(rival.voice.broadcast(Allocation(0, b"abcdef")))
        bus.run(2.0)
    assert "node 10 allocates node ids, too" in caplog.text
    assert bus.ask(OTHER) is None


def test_parts_that_do_not_follow_each_other_are_forgotten(bus):
    bus.asker.end.send(Allocation(0, OTHER[:6], first=True).asked(1, 0))
    bus.run(0.6)  # too late for the second part
    bus.asker.heard()
    bus.asker.end.send(Allocation(0, OTHER[6:12]).asked(1, 1))
    bus.run(0.1)
    assert not of(Allocation, bus.asker.heard())
    assert bus.ask(OTHER) == 125


def test_when_all_ids_are_taken_nobody_gets_one(bus, caplog):
    for number in range(1, 126):
        bus.kept.gave(number.to_bytes(16, "little"), number)
    assert bus.ask(OTHER) is None
    assert "all are in use" in caplog.text


@given(some.lists(some.tuples(some.integers(0, 127), some.binary(max_size=16), some.booleans()), max_size=30))
def test_whatever_is_asked_no_two_nodes_get_one_id(asked):
    bus = Bus()
    bus.run(3.1)
    for wanted, part, first in asked:
        bus.asker.end.send(Allocation(wanted, part, first).asked(1, 0))
        bus.node.poll(bus.now)
    given = list(bus.kept.table.values())
    assert len(given) == len(set(given))
    assert not {0, 121, 126, 127, *AVOIDED} & set(given)


# ------------------------------------------------------------------------------------- over a restart


def kept(path, seed=1):
    return PersistentIds(path, np.random.default_rng(seed))


def test_all_is_known_again_after_a_restart(tmp_path):
    path = tmp_path / "dronecan.json"
    with kept(path) as before:
        before.had(77)
        before.gave(OTHER, 125)
    with kept(path, seed=2) as after:
        assert (after.unique_id, after.node_id, dict(after.table)) == (before.unique_id, 77, {OTHER: 125})
    assert len(after.unique_id) == 16


def test_each_payload_has_a_unique_id_of_its_own(tmp_path):
    with kept(tmp_path / "one", 1) as one, kept(tmp_path / "other", 2) as other:
        assert one.unique_id != other.unique_id


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "null",
        '{"version": 1}',
        json.dumps({"version": 2, "unique_id": UNIQUE.hex(), "node_id": 1, "given": {}}),
        json.dumps({"version": 1, "unique_id": "00", "node_id": 1, "given": {}}),
        json.dumps({"version": 1, "unique_id": UNIQUE.hex(), "node_id": 500, "given": {}}),
        json.dumps({"version": 1, "unique_id": UNIQUE.hex(), "node_id": 1, "given": {"zz": 3}}),
        json.dumps({"version": 1, "unique_id": UNIQUE.hex(), "node_id": 1, "given": [1]}),
    ],
)
def test_a_damaged_file_is_put_aside_and_said(tmp_path, text, caplog):
    path = tmp_path / "dronecan.json"
    path.write_text(text)
    with kept(path) as fresh:
        assert len(fresh.unique_id) == 16
    assert (tmp_path / "dronecan.json.unreadable").read_text() == text
    assert "damaged; kept as dronecan.json.unreadable" in caplog.text
    assert json.loads(path.read_text())["unique_id"] == fresh.unique_id.hex()


def test_a_folder_that_cannot_be_written_is_said(tmp_path, caplog):
    (tmp_path / "no-folder").write_text("")
    with kept(tmp_path / "no-folder" / "dronecan.json"):
        pass
    assert "dronecan.json: cannot be" in caplog.text
