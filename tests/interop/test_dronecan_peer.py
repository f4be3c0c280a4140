"""Nodes of the package `dronecan`, in real time: they drive the simulated servo, and give node ids to it and to us."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from itertools import count, pairwise
from typing import Any

import numpy as np
import pytest

pytest.importorskip("can")
dronecan = pytest.importorskip("dronecan")

from dronecan.app.dynamic_node_id import CentralizedServer  # noqa: E402
from dronecan.app.node_monitor import NodeMonitor  # noqa: E402

from dronecan_bus import peer, spin_until  # noqa: E402
from live_can_node import LiveCanNode  # noqa: E402
from ross_payload.actuators.dronecan_servo.driver import backend  # noqa: E402
from ross_payload.actuators.dronecan_servo.options import Options  # noqa: E402
from ross_payload.actuators.wires import open_wire  # noqa: E402
from ross_payload.clock import SystemClock  # noqa: E402
from ross_payload.interfaces import Services  # noqa: E402
from ross_sim.devices.servo_node import ServoNode  # noqa: E402
from ross_sim.devices.servo_shaft import Drive, Shaft  # noqa: E402

PEER, SERVO = 10, 50
numbers = count()


class Emulated(LiveCanNode):
    """The simulated servo."""

    def __init__(self, channel: str, *, fixed: bool = True, **options: Any) -> None:
        shaft = Shaft(Drive(), np.random.default_rng(0))
        super().__init__(channel, ServoNode(Options(**options), shaft, fixed=fixed))


@pytest.fixture
def channel() -> str:
    return f"peer-{next(numbers)}"


@pytest.fixture
def node(channel: str) -> Iterator[Any]:
    node = peer(channel, PEER)
    yield node
    node.close()


@pytest.fixture
def server(node: Any) -> Iterator[CentralizedServer]:
    """An allocator that we did not write."""
    monitor = NodeMonitor(node)
    server = CentralizedServer(node, monitor)
    yield server
    server.close()
    monitor.close()


def test_it_commands_at_50_hz_and_reads_where_the_servo_is(node: Any, channel: str) -> None:
    actuator = dronecan.uavcan.equipment.actuator
    places: list[float] = []
    counts: list[int] = []
    times: list[float] = []

    def heard(event: Any) -> None:
        times.append(time.monotonic())
        places.append(event.message.position)
        counts.append(event.transfer.transfer_id)

    def command() -> None:
        each = actuator.Command(actuator_id=1, command_type=actuator.Command().COMMAND_TYPE_POSITION, command_value=0.5)
        node.broadcast(actuator.ArrayCommand(commands=[each]))

    with Emulated(channel, command="position"):
        node.add_handler(actuator.Status, heard)
        node.periodic(0.02, command)
        spin_until(node, lambda: places)
        before = len(places)
        spin_until(node, lambda: abs(places[-1] - 0.5) < 0.005 and len(places) - before > 50)
    assert all(after == (earlier + 1) % 32 for earlier, after in pairwise(counts))
    assert len(times) / (times[-1] - times[0]) < 80  # what has waited comes at once
    assert np.quantile(np.diff(times), 0.25) < 0.025  # 20 ms, where nothing else keeps the computer busy
    assert places[0] == pytest.approx(0.0, abs=0.1)


def test_it_turns_a_gimbal_to_the_left_with_a_negative_yaw(node: Any, channel: str) -> None:
    gimbal = dronecan.uavcan.equipment.camera_gimbal
    attitudes: list[Any] = []
    command = gimbal.AngularCommand(gimbal_id=3)
    command.mode.command_mode = command.mode.COMMAND_MODE_ORIENTATION_BODY_FRAME
    command.quaternion_xyzw = [0.0, 0.0, -math.sin(0.3), math.cos(0.3)]
    with Emulated(channel, command="gimbal", gimbal_id=3) as servo:
        node.add_handler(gimbal.Status, lambda event: attitudes.append(event.message))
        node.periodic(0.02, lambda: node.broadcast(command))
        wanted = pytest.approx(list(command.quaternion_xyzw), abs=0.003)
        spin_until(node, lambda: attitudes and list(attitudes[-1].camera_orientation_in_body_frame_xyzw) == wanted)
        spin_until(node, lambda: servo.node.joint() == pytest.approx(0.6, abs=0.006))
    assert attitudes[-1].gimbal_id == 3


def test_it_reads_who_the_servo_is_and_how_it_is_and_reboots_it(node: Any, channel: str) -> None:
    answers: list[Any] = []
    beats: list[int] = []
    restart = dronecan.uavcan.protocol.RestartNode
    node.add_handler(
        dronecan.uavcan.protocol.NodeStatus,
        lambda event: beats.append(event.message.uptime_sec) if event.transfer.source_node_id == SERVO else None,
    )
    with Emulated(channel):
        spin_until(node, lambda: beats and beats[-1] >= 2)
        node.request(dronecan.uavcan.protocol.GetNodeInfo.Request(), SERVO, answers.append)
        spin_until(node, lambda: answers)
        magic = restart.Request().MAGIC_NUMBER
        node.request(restart.Request(magic_number=magic), SERVO, answers.append)
        spin_until(node, lambda: len(answers) == 2 and beats[-1] == 0)
    info, restarted = answers
    assert str(info.response.name) == "org.ross.servo"
    assert info.response.status.mode == info.response.status.MODE_OPERATIONAL
    assert restarted.response.ok


def test_it_gives_a_servo_without_an_id_the_one_it_prefers(node: Any, channel: str, server: Any) -> None:
    with Emulated(channel, fixed=False) as servo:
        spin_until(node, lambda: servo.node.node_id)
        assert servo.node.node_id == SERVO
        spin_until(node, lambda: any(each == SERVO for _, each in server.get_allocation_table()))


def test_a_driver_without_an_id_gets_one_and_turns_the_servo(node: Any, channel: str, server: Any) -> None:
    clock = SystemClock()
    options = Options(port=f"can:virtual:{channel}", own_node_id=0)
    driver = backend.open(options, Services(clock, lambda url: open_wire(url, clock)))
    names: list[str] = []

    def settled_at(goal: float) -> bool:
        driver.poll(clock.now())
        state = driver.state()
        return bool(state.settled) and abs(state.angle - goal) < 0.01

    def named() -> bool:
        driver.poll(clock.now())
        return bool(driver.state().healthy)

    with Emulated(channel), driver:
        driver.poll(clock.now())
        assert driver.state().fault == "waiting for a node id"
        spin_until(node, named)
        (ours,) = (each for _, each in server.get_allocation_table() if each not in (PEER, SERVO))
        driver.command(0.3)
        spin_until(node, lambda: settled_at(0.3))
        node.request(
            dronecan.uavcan.protocol.GetNodeInfo.Request(), ours, lambda event: names.append(str(event.response.name))
        )
        spin_until(node, lambda: settled_at(0.3) and names)
    assert names == ["org.ross.payload"]
