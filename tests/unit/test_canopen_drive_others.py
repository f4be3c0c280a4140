"""What others do on the bus of a CANopen drive: what is no matter, and what ends a move."""

import pytest

from drive_bench import NODE, OWN, Bench
from ross_protocols.can import CanFrame
from ross_protocols.canopen import NmtCommand, NmtState, heartbeat, nmt
from ross_protocols.canopen_sdo import Read, Write, request
from ross_protocols.cia402 import State
from ross_sim.clock import QUANTUM
from ross_sim.devices.far_end import Fault

RPDO1, RPDO2 = 0x200 + NODE, 0x300 + NODE


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        (nmt(NmtCommand.STOP, NODE), "another master on the bus orders node 5: stop"),
        (nmt(NmtCommand.RESET_NODE, 0), "another master on the bus orders all nodes: reset-node"),
        (CanFrame(RPDO2, bytes(4), extended=False), "another master on the bus commands node 5"),
        (request(NODE, Write(0x6081, 0, bytes(4))), "another master on the bus commands node 5"),
        (heartbeat(OWN, NmtState.OPERATIONAL), "another node on the bus has our node id 127"),
        (heartbeat(NODE, NmtState.STOPPED), "the drive at node 5 is stopped and obeys no set-points"),
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
        CanFrame(RPDO1, bytes(7), extended=True),
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
