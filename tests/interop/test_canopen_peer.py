"""The package `canopen`, in real time: its 402 master drives the simulated drive; its reader takes our data sheet."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("can")
canopen = pytest.importorskip("canopen")

from canopen.profiles.p402 import BaseNode402  # noqa: E402

from live_can_node import LiveCanNode  # noqa: E402
from ross_payload.actuators.canopen_drive.driver import backend  # noqa: E402
from ross_payload.actuators.canopen_drive.options import Options  # noqa: E402
from ross_payload.actuators.wires import open_wire  # noqa: E402
from ross_payload.clock import SystemClock  # noqa: E402
from ross_payload.interfaces import Services  # noqa: E402
from ross_sim.devices.canopen_far_end import DriveFarEnd  # noqa: E402
from ross_sim.devices.drive_objects import Objects  # noqa: E402
from waiting import wait_for  # noqa: E402

NODE = 5
SHEET = Path(__file__).parents[2] / "protocols" / "canopen" / "ross_drive.eds"
TIMEOUT_S = 20.0  # with a computer that has much else to do [s]
numbers = count()


class Emulated(LiveCanNode):
    """The simulated drive."""

    def __init__(self, channel: str, **options: Any) -> None:
        self.far_end = DriveFarEnd(Options(node_id=NODE, **options), np.random.default_rng(0))
        super().__init__(channel, self.far_end.node)


@pytest.fixture
def channel() -> str:
    return f"canopen-{next(numbers)}"


@pytest.fixture
def drive(channel: str) -> Iterator[Emulated]:
    with Emulated(channel, homing="negative_limit", zero_deg=-30.0, homing_deg_s=60.0) as drive:
        yield drive


@pytest.fixture
def master(channel: str, drive: Emulated) -> Iterator[BaseNode402]:
    """Their node for our drive, set up as their manual says."""
    network = canopen.Network()
    network.connect(channel=channel, interface="virtual", ignore_config=True)
    try:
        node = BaseNode402(NODE, str(SHEET))
        network.add_node(node)
        node.sdo.RESPONSE_TIMEOUT = TIMEOUT_S / 4
        node.nmt.state = "PRE-OPERATIONAL"
        node.setup_402_state_machine()
        node.tpdo[1].period = 0.02  # so that it waits for reports and does not ask
        node.TIMEOUT_CHECK_TPDO = node.TIMEOUT_SWITCH_STATE_FINAL = node.TIMEOUT_SWITCH_OP_MODE = TIMEOUT_S
        node.nmt.state = "OPERATIONAL"
        yield node
    finally:
        network.disconnect()


def position(master: BaseNode402) -> int:
    return int(master.tpdo_values[0x6064])


def go(master: BaseNode402, target: int) -> None:
    """Their controlword, their process data, our handshake."""
    master.controlword = 0x0F
    wait_for(lambda: not master.statusword & 0x1000)
    master.rpdo[1]["Target position"].raw = target
    master.controlword = 0x3F
    wait_for(lambda: bool(master.statusword & 0x1000))


def test_their_master_enables_homes_and_moves_our_drive(master: BaseNode402, drive: Emulated) -> None:
    wait_for(lambda: master.state == "SWITCH ON DISABLED")
    master.sdo["Homing method"].raw = 17  # the negative limit switch
    assert master.homing(timeout=TIMEOUT_S)
    assert abs(drive.far_end.angle() - math.radians(-30)) < math.radians(3)
    master.op_mode = "PROFILED POSITION"
    wait_for(lambda: master.op_mode == "PROFILED POSITION")
    master.sdo["Profile velocity"].raw = 60000
    master.rpdo[2]["Profile velocity"].raw = 60000
    for target in (9000, -4000):
        go(master, target)
        wait_for(lambda target=target: bool(master.statusword & 0x400) and abs(position(master) - target) <= 20)
        assert abs(master.sdo["Position actual value"].raw - target) <= 20


def test_their_master_reads_the_emergency_and_resets_the_fault(master: BaseNode402, drive: Emulated) -> None:
    master.state = "OPERATION ENABLED"
    drive.node.axis.fail(0x4310)
    wait_for(lambda: master.state == "FAULT")
    wait_for(lambda: bool(master.emcy.active))
    assert master.emcy.active[0].code == 0x4310
    assert master.sdo["Error code"].raw == 0x4310
    master.controlword = 0x00
    master.controlword = 0x80
    wait_for(lambda: master.state == "SWITCH ON DISABLED")
    wait_for(lambda: not master.emcy.active)


def test_their_synchronisation_is_answered(master: BaseNode402, drive: Emulated) -> None:
    master.nmt.state = "PRE-OPERATIONAL"
    master.tpdo[1].trans_type = 1
    master.tpdo[1].save()
    master.nmt.state = "OPERATIONAL"
    heard = []
    master.tpdo[1].add_callback(heard.append)
    time.sleep(0.2)
    assert heard == []
    for number in range(1, 4):
        master.network.sync.transmit()
        wait_for(lambda number=number: len(heard) == number)


def test_their_reset_boots_our_drive(master: BaseNode402, drive: Emulated) -> None:
    master.sdo["Profile velocity"].raw = 77
    master.nmt.state = "RESET"
    master.nmt.wait_for_bootup(TIMEOUT_S)
    assert master.sdo["Profile velocity"].raw == 10000


def test_their_reads_and_writes_that_are_refused_tell_why(master: BaseNode402) -> None:
    with pytest.raises(canopen.SdoAbortedError, match="0x06010002"):
        master.sdo.download(0x6041, 0, b"\0\0")
    with pytest.raises(canopen.SdoAbortedError, match="0x06020000"):
        master.sdo.upload(0x2000, 0)
    with pytest.raises(canopen.SdoAbortedError, match="0x06070010"):
        master.sdo.download(0x6081, 0, b"\0")
    with pytest.raises(canopen.SdoAbortedError, match="0x06040041"):
        master.sdo.download(0x1A00, 1, (0x60850020).to_bytes(4, "little"))


def test_their_reader_finds_in_our_data_sheet_what_our_drive_has() -> None:
    theirs = canopen.import_od(str(SHEET), node_id=NODE)
    ours = Objects(NODE).entries
    found = {}
    for entry in theirs.values():
        variables = entry.values() if hasattr(entry, "values") else [entry]
        found |= {(variable.index, variable.subindex): variable for variable in variables}
    assert found.keys() == ours.keys()
    for key, variable in found.items():
        assert (variable.default, variable.access_type) == (ours[key].default, ours[key].access), key
        assert (variable.min, variable.max) == (ours[key].lowest, ours[key].highest), key
        assert len(variable) == 8 * ours[key].item.size, key


def test_our_driver_drives_our_drive_on_a_bus_of_python_can(channel: str) -> None:
    """In real time: what the package's master can do, ours can on the same bus."""
    clock = SystemClock()
    services = Services(clock, lambda url: open_wire(url, clock))
    with Emulated(channel) as drive:
        actuator = backend.open(Options(port=f"can:virtual:{channel}", node_id=NODE), services)
        with actuator:
            end = clock.now() + TIMEOUT_S
            while not actuator.state().homed:
                actuator.poll(clock.now())
                assert clock.now() < end, actuator.state()
                clock.sleep(0.005)
            actuator.command(0.5)
            while not actuator.state().settled:
                actuator.poll(clock.now())
                assert clock.now() < end, actuator.state()
                clock.sleep(0.005)
            assert drive.far_end.angle() == pytest.approx(0.5, abs=math.radians(0.1))
        assert actuator.state().healthy
