"""Nodes of the package `dronecan`, which we did not write, on one bus of python-can with a whole payload of ours."""

from contextlib import closing
from functools import partial

import numpy as np
import pytest

from dronecan_bench import UNIQUE_ID, play
from dronecan_types import SOURCES, STATUS, broadcast, load_ours
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.config.parameter_table import TABLE
from ross_payload.events import Estimate, SourceEstimate, SourcesEstimated, State, StateChanged
from ross_payload.orders import TurnTo

can = pytest.importorskip("can")
dronecan = pytest.importorskip("dronecan")

from dronecan.app.dynamic_node_id import CentralizedServer  # noqa: E402
from dronecan.app.node_monitor import NodeMonitor  # noqa: E402

from dronecan_bus import peer as node_of_package  # noqa: E402

UNIQUE = bytes(range(50, 66))
OURS = 121


@pytest.fixture(scope="module")
def uavcan():
    """The package's types, with our own messages loaded."""
    load_ours(dronecan)
    return dronecan.uavcan.protocol


@pytest.fixture
def channel(request):
    return f"{request.node.name}-{id(request)}"


class Peer:
    """A node of the package that lives with the payload's hops."""

    def __init__(self, channel, uavcan, node_id=9):
        self.node, self.uavcan = node_of_package(channel, node_id), uavcan
        self.heard = []

    def listen(self, *types):
        for kind in types:
            self.node.add_handler(kind, lambda event: self.heard.append((event.transfer.source_node_id, event.message)))

    def ask(self, request, node=OURS):
        answers = []
        self.node.request(request, node, answers.append)
        yield from self.until(lambda: answers)
        return answers[0] and answers[0].response

    def until(self, true, hops=4000):
        for _ in range(hops):
            self.node.spin(0)
            if true():
                return
            yield
        raise AssertionError("it never came")

    def said(self, kind, node=OURS):
        return [m for who, m in self.heard if who == node and dronecan.get_dronecan_data_type(m) == kind]


@pytest.fixture
def peer(channel, uavcan):
    peer = Peer(channel, uavcan)
    yield peer
    peer.node.close()


@pytest.fixture
def aboard(channel, tmp_path):
    """Let a script live with a payload on the bus."""

    def run(script, **table):
        url = f"can:virtual:{channel}"
        return play(script, partial(open_wire, clock=SystemClock()), tmp_path, dronecan={"port": url, **table})

    return run


def test_it_reads_our_heartbeat_and_who_we_are(peer, aboard, uavcan):
    peer.listen(uavcan.NodeStatus)

    def script(bench):
        yield from peer.until(lambda: len(peer.said(uavcan.NodeStatus)) >= 3)
        status = peer.said(uavcan.NodeStatus)[-1]
        assert (status.health, status.mode) == (status.HEALTH_OK, status.MODE_OPERATIONAL)
        info = yield from peer.ask(uavcan.GetNodeInfo.Request())
        assert info.name.decode() == "org.ross.payload"
        assert bytes(info.hardware_version.unique_id) == UNIQUE_ID
        stats = yield from peer.ask(uavcan.GetTransportStats.Request())
        assert stats.transfers_tx >= 3
        assert len(stats.can_iface_stats) == 1

    aboard(script)


def test_its_monitor_finds_us(peer, aboard):
    monitor = NodeMonitor(peer.node)

    def script(bench):
        yield from peer.until(lambda: monitor.exists(OURS) and monitor.get(OURS).discovered)
        assert monitor.get(OURS).info.name.decode() == "org.ross.payload"

    aboard(script)
    monitor.close()


def test_it_lists_reads_and_sets_our_parameters(peer, aboard, uavcan):
    get_set = uavcan.param.GetSet

    def script(bench):
        names = []
        for index in range(100):
            row = yield from peer.ask(get_set.Request(index=index))
            if not row.name:
                break
            names.append(row.name.decode())
        assert names == list(TABLE)
        unit = yield from peer.ask(get_set.Request(name="EXP_UNIT"))
        assert (unit.value.real_value, unit.default_value.real_value) == (3.0, 3.0)
        assert (unit.min_value.real_value, unit.max_value.real_value) == (0.5, 60.0)
        set_unit = get_set.Request(name="EXP_UNIT", value=uavcan.param.Value(real_value=2.5))
        assert (yield from peer.ask(set_unit)).value.real_value == 2.5
        assert bench.parameters.value("EXP_UNIT") == 2.5
        set_turns = get_set.Request(name="EXP_MAX_ROT", value=uavcan.param.Value(integer_value=99))
        assert (yield from peer.ask(set_turns)).value.integer_value == 12
        assert dronecan.get_active_union_field(unit.value) == "real_value"
        opcode = uavcan.param.ExecuteOpcode
        erase = opcode.Request(opcode=opcode.Request().OPCODE_ERASE)
        assert (yield from peer.ask(erase)).ok
        assert bench.parameters.value("EXP_UNIT") == 3.0

    aboard(script)


def test_it_restarts_us(peer, aboard, uavcan):
    restart = uavcan.RestartNode

    def script(bench):
        yield from peer.until(lambda: bench.heard is not None and bench.heard.block.index > 16000)
        wrong = yield from peer.ask(restart.Request(magic_number=1))
        assert not wrong.ok
        right = yield from peer.ask(restart.Request(magic_number=restart.Request().MAGIC_NUMBER))
        assert right.ok
        yield from peer.until(lambda: False)

    assert aboard(script, may_restart=True).restarts == ["asked"]


def test_it_understands_what_we_tell_of_the_mission(peer, aboard, uavcan):
    ross, sources = broadcast(dronecan, STATUS), broadcast(dronecan, SOURCES)
    peer.listen(ross, sources, uavcan.debug.LogMessage)
    heard = (SourceEstimate(0.5, 0.0625, 0.75, resolved=True), SourceEstimate(-2.5, 0.125, 1.0, resolved=True))

    def script(bench):
        yield from peer.until(lambda: peer.said(ross) and peer.said(sources))
        assert peer.said(ross)[-1].state == State.IDLE
        assert len(peer.said(sources)[-1].sources) == 0
        bench.tell(StateChanged(1.0, State.EXPLORE_LISTEN), SourcesEstimated(1.0, Estimate(heard), 3, final=True))
        yield from peer.until(lambda: len(peer.said(sources)[-1].sources) == 2)
        first, second = peer.said(sources)[-1].sources
        assert (first.azimuth, first.sigma, first.confidence) == (-0.5, 0.0625, 75)
        assert (second.azimuth, second.flags) == (2.5, second.FLAG_RESOLVED)
        texts = [bytes(m.text.to_bytes()).decode() for m in peer.said(uavcan.debug.LogMessage)]
        assert texts == ["2 sources found after 3 turns"]
        bench.runner.order(TurnTo(0.5))
        yield from peer.until(lambda: peer.said(ross)[-1].heading == pytest.approx(-0.5, abs=0.01))

    aboard(script)


def test_its_allocator_gives_us_an_id(peer, aboard, uavcan):
    peer.listen(uavcan.NodeStatus)
    server = CentralizedServer(peer.node, NodeMonitor(peer.node))

    def script(bench):
        yield from peer.until(lambda: any(who not in (0, 9) for who, _ in peer.heard), hops=5900)
        table = {bytes(unique): number for unique, number in server.get_allocation_table() if unique}
        given = next(who for who, _ in peer.heard if who not in (0, 9))
        assert table[UNIQUE_ID] == given

    aboard(script, node_id=0)
    server.close()


class Allocatee:
    """A node without an id, built by hand from the package's types: it has no class for it."""

    def __init__(self, channel, uavcan):
        self.kind = uavcan.dynamic_node_id.Allocation
        self.bus = can.Bus(channel, "virtual", ignore_config=True)
        self.manager, self.told, self.given, self.count = dronecan.transport.TransferManager(), b"", None, 0

    def close(self):
        self.bus.shutdown()

    def ask(self, first):
        part = self.kind(node_id=0, first_part_of_unique_id=first)
        part.unique_id.from_bytes(UNIQUE[len(self.told) : len(self.told) + 6])
        transfer = dronecan.transport.Transfer(
            transfer_id=self.count, source_node_id=0, payload=part, transfer_priority=30, discriminator=4711
        )
        self.count = (self.count + 1) % 32
        (frame,) = transfer.to_frames()
        self.bus.send(can.Message(arbitration_id=frame.message_id, data=bytes(frame.bytes), is_extended_id=True))

    def hear(self):
        """Take in the bus; whether something was said about us."""
        while (message := self.bus.recv(0)) is not None:
            frame = dronecan.transport.Frame(message.arbitration_id, bytes(message.data))
            frames = self.manager.receive_frame(frame)
            if frames and frames[0].message_id >> 8 & 0xFFFF == 1 and frames[0].message_id & 0x7F:
                transfer = dronecan.transport.Transfer()
                transfer.from_frames(frames)
                self.told = bytes(transfer.payload.unique_id.to_bytes())
                self.given = transfer.payload.node_id or None
                return True
        return False

    def live(self):
        while self.given is None:
            self.told = b""
            self.ask(first=1)
            for _ in range(100):
                yield
                if self.hear() and self.given is None:
                    self.ask(first=0)
                if self.given is not None:
                    return


def test_our_allocator_gives_an_id_to_a_node_that_asks(peer, aboard, channel, uavcan):
    with closing(Allocatee(channel, uavcan)) as asker:

        def script(bench):
            for _ in asker.live():
                peer.node.spin(0)
                yield

        aboard(script, allocator=True)
        assert (asker.given, asker.told) == (125, UNIQUE)


def test_whatever_we_find_is_read_without_an_error(peer, aboard):
    hooked = []
    peer.node.add_transfer_hook(hooked.append)

    def script(bench):
        rng = np.random.default_rng(1)
        for hop in range(1500):
            peer.node.spin(0)  # which raises on any transfer that it does not understand
            if hop % 50 == 0:
                sources = tuple(SourceEstimate(*rng.uniform(0, 1, 3), resolved=False) for _ in range(hop // 200))
                bench.tell(SourcesEstimated(1.0, Estimate(sources), 3, final=True))
            yield

    aboard(script)
    assert len(hooked) > 75
