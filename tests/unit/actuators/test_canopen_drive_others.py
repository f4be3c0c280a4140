"""What others do on the bus of a CANopen drive: what is no matter, and what ends a move."""

import pytest

from drive_bench import NODE, OWN, Bench
from ross_protocols.can import CanFrame
from ross_protocols.canopen.cia402 import State
from ross_protocols.canopen.frames import NmtCommand, NmtState, heartbeat, nmt
from ross_protocols.canopen.sdo import Read, Write, request
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault

RPDO_SPEED, RPDO_ORDER = 0x200 + NODE, 0x300 + NODE


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (nmt(NmtCommand.STOP, NODE), "another master on the bus orders node 5: stop"),
        (nmt(NmtCommand.RESET_NODE, 0), "another master on the bus orders all nodes: reset-node"),
        (CanFrame(RPDO_SPEED, bytes(4), extended=False), "another master on the bus commands node 5"),
        (request(NODE, Write(0x6081, 0, bytes(4))), "another master on the bus commands node 5"),
        (heartbeat(OWN, NmtState.OPERATIONAL), "another node on the bus has our node id 127"),
        (heartbeat(NODE, NmtState.STOPPED), "the drive at node 5 is stopped and accepts no set-points"),
        (CanFrame(0x180 + NODE, bytes(3), extended=False), "frames of node 5 arrive damaged: a report of 3 bytes"),
        (CanFrame(0x580 + NODE, bytes(8), extended=False), "two devices have node id 5: both answer"),
    ],
)
def test_what_does_not_belong_on_the_bus_ends_a_move_with_its_name(frame, words):
    bench = Bench().open()
    bench.go(120, 0.8)
    bench.wire.brought.append(frame)
    bench.clock.sleep(2 * QUANTUM)
    assert words in bench.fault
    bench.clock.sleep(2.0)
    assert bench.drive_state is State.SWITCH_ON_DISABLED


@pytest.mark.parametrize(
    "frame",
    [
        nmt(NmtCommand.STOP, 9),
        heartbeat(9, NmtState.BOOT_UP),
        request(NODE, Read(0x6064, 0)),
        CanFrame(RPDO_ORDER, bytes(7), extended=True),
        CanFrame(0x180 + 9, bytes(2), extended=False),
    ],
)
def test_the_traffic_of_others_is_no_matter(frame):
    bench = Bench().open()
    bench.go(60, 0.3)
    bench.wire.brought.append(frame)
    bench.settle()
    assert bench.state.healthy


def test_two_drives_with_one_id_are_told_when_they_are_opened():
    bench = Bench()
    bench.far_end.afflict(Fault.DUPLICATE)
    bench.open()
    assert bench.fault == "two devices have node id 5: both answer"


def test_one_answer_that_can_delivers_twice_is_no_second_drive():
    """As when the sender alone sees an error in the last bit of the frame."""
    bench, answers = Bench(), []
    receive = bench.wire.receive

    def receive_one_twice():
        arrived = receive()
        answered = [frame for frame in arrived if frame.id == 0x580 + NODE]
        answers.extend(answered)
        return arrived + answered * (len(answers) == 9)

    bench.wire.receive = receive_one_twice
    bench.open()
    assert len(answers) > 9
    bench.go(30, 3.0)
    assert bench.state.settled


def test_a_heartbeat_that_crosses_the_order_to_start_is_of_the_past():
    bench = Bench()
    bench.actuator.__enter__()
    while not bench.frames(0x000) or bench.frames(0x000)[-1] != nmt(NmtCommand.START, NODE).data:
        bench.clock.sleep(QUANTUM)
    bench.wire.brought = [heartbeat(NODE, NmtState.PRE_OPERATIONAL)]
    bench.clock.sleep(1.0)
    assert bench.state.healthy, bench.fault
    bench.go(5)
    bench.settle()


class Slow:
    """A bus that brings what the drive says 20 ms later, also to who opens it next."""

    def __init__(self, port, clock):
        self._port, self._clock = port, clock
        self._late = []

    def send(self, frame):
        self._port.send(frame)

    def receive(self):
        now = self._clock.now()
        self._late += [(now + 0.02, frame) for frame in self._port.receive()]
        arrived = [frame for due, frame in self._late if due <= now]
        self._late = [late for late in self._late if late[0] > now]
        return arrived

    def close(self):
        pass


def test_a_driver_that_is_opened_again_at_once_hears_no_answer_of_the_last_one():
    bench = Bench()
    bench.wire._port = Slow(bench.wire._port, bench.clock)
    for _ in range(5):
        bench.open()
        assert bench.state.healthy, bench.fault
        bench.close()
