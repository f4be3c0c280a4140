"""MAVSDK's gimbal plugin, a client that we did not write, takes, points, reads and releases a simulated gimbal."""

import json
import math
import time

import pytest

from device_bench import device
from ports import free_port

mavsdk = pytest.importorskip("mavsdk", minversion="4", reason="needs the Python package mavsdk, 4 or later")
plugin = pytest.importorskip("mavsdk.plugins.gimbal.gimbal")
direct = pytest.importorskip("mavsdk.plugins.mavlink_direct.mavlink_direct")

GOAL = 40.0  # [deg], clockwise


class Client:
    """A ground station of MAVSDK that has found a gimbal."""

    def __init__(self, sdk, until):
        (self.system,) = until(lambda: [system for system in sdk.get_systems() if system.component_ids()])
        self.gimbal = plugin.Gimbal(self.system)
        self.seen, self.controls = [], []
        self.gimbal.subscribe_attitude(lambda attitude, user: self.seen.append(attitude))
        self.gimbal.subscribe_control_status(lambda status, user: self.controls.append(status))
        (self.item,) = until(lambda: self.gimbal.gimbal_list().gimbals, 60.0, "a gimbal")
        self.id = self.item.gimbal_id
        self._ask_for_attitudes()

    def _ask_for_attitudes(self):
        """Like an ArduPilot, the autopilot passes them on only when somebody has set their interval."""
        fields = {"target_system": 1, "target_component": 1, "command": 511, "confirmation": 0}
        fields |= {"param1": 285, "param2": 50_000} | {f"param{index}": 0 for index in range(3, 8)}
        message = direct.MavlinkMessage("COMMAND_LONG", 0, 0, 1, 1, json.dumps(fields))
        answer = direct.MavlinkDirect(self.system).send_command(message)
        assert json.loads(answer.fields_json)["result"] == 0

    def yaw(self):
        """What the gimbal reported last [deg], clockwise from the nose."""
        return self.seen[-1].euler_angle_forward.yaw_deg

    def point(self, yaw, mode=None, how=None):
        mode = mode or plugin.GimbalMode.YAW_FOLLOW
        self.gimbal.set_angles(self.id, 0.0, 0.0, yaw, mode, how or plugin.SendMode.ONCE)


@pytest.fixture(scope="module")
def gimbal(tmp_path_factory):
    port = free_port()
    with device(tmp_path_factory.mktemp("gimbal"), "gimbal", "--wire", f"udpout:127.0.0.1:{port}") as process:
        process.port = port
        yield process


@pytest.fixture(scope="module")
def client(gimbal, until, tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setenv("HOME", str(tmp_path_factory.mktemp("home")))
    kind = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    with mavsdk.Mavsdk(kind) as sdk:
        assert sdk.add_any_connection(f"udpin://127.0.0.1:{gimbal.port}") == mavsdk.ConnectionResult.SUCCESS
        yield Client(sdk, until)
    patch.undo()


def truth(gimbal):
    """Where the gimbal really points [deg], clockwise."""
    return -gimbal.ask("status")["angle_deg"]


def steady(gimbal):
    before = truth(gimbal)
    time.sleep(0.3)
    return truth(gimbal) == before


def test_it_finds_the_gimbal_of_the_autopilot(client):
    assert (client.item.gimbal_manager_component_id, client.item.gimbal_device_id) == (1, 1)


def test_it_takes_control_and_sees_that_it_has_it(client, until):
    client.gimbal.take_control(client.id, plugin.ControlMode.PRIMARY)
    until(lambda: client.controls and client.controls[-1].control_mode == plugin.ControlMode.PRIMARY)
    assert client.controls[-1].sysid_primary_control == 245


@pytest.mark.parametrize("how", ["ONCE", "STREAM"])
def test_it_points_and_the_gimbal_goes_there_and_says_so(client, gimbal, until, how):
    client.gimbal.take_control(client.id, plugin.ControlMode.PRIMARY)
    goal = GOAL if how == "ONCE" else -GOAL
    client.point(goal, how=plugin.SendMode[how])
    until(lambda: abs(truth(gimbal) - goal) < 0.1)


def test_what_it_reads_is_where_the_gimbal_is(client, gimbal, until):
    client.point(25.0)
    until(lambda: abs(truth(gimbal) - 25.0) < 0.1)
    until(lambda: client.seen and abs(client.yaw() - 25.0) < 0.2)


def test_rates_turn_it_until_they_are_stopped(client, gimbal, until):
    client.point(0.0)
    until(lambda: abs(truth(gimbal)) < 0.1)
    turn = client.gimbal.set_angular_rates
    turn(client.id, 0.0, 0.0, 10.0, plugin.GimbalMode.YAW_FOLLOW, plugin.SendMode.ONCE)
    until(lambda: truth(gimbal) > 5.0)
    turn(client.id, 0.0, 0.0, 0.0, plugin.GimbalMode.YAW_FOLLOW, plugin.SendMode.ONCE)
    until(lambda: steady(gimbal))


def test_a_stuck_gimbal_is_seen_where_it_is_although_the_command_succeeds(client, gimbal, until):
    client.point(0.0)
    until(lambda: abs(truth(gimbal)) < 0.1)
    gimbal.ask("stuck")
    client.point(60.0)
    count = len(client.seen)
    until(lambda: len(client.seen) > count + 5)
    assert abs(client.yaw()) < 0.2
    gimbal.ask("stuck off")


def test_it_gives_control_back(client, until):
    client.gimbal.take_control(client.id, plugin.ControlMode.PRIMARY)
    until(lambda: client.controls[-1].control_mode == plugin.ControlMode.PRIMARY)
    client.gimbal.release_control(client.id)
    until(lambda: client.controls[-1].control_mode == plugin.ControlMode.NONE)
    assert client.controls[-1].sysid_primary_control == 0


def test_a_gimbal_that_nobody_has_is_refused(client):
    with pytest.raises(plugin.GimbalError):
        client.gimbal.take_control(7, plugin.ControlMode.PRIMARY)
    assert math.isfinite(client.yaw())
