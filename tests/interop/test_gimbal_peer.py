"""MAVSDK, a client that we did not write, takes, points, reads and releases a simulated gimbal behind an autopilot.

Its gimbal plugin lists none behind an ArduPilot, which does not say who the device is (512/283 fails); MAVLink's own
messages and commands work.
"""

import json
import math
import time

import pytest

from device_bench import device
from ports import free_port
from ross_protocols.mavlink.vehicle import euler
from waiting import wait_for

mavsdk = pytest.importorskip("mavsdk", minversion="4", reason="needs the Python package mavsdk, 4 or later")
plugin = pytest.importorskip("mavsdk.plugins.gimbal.gimbal")
direct = pytest.importorskip("mavsdk.plugins.mavlink_direct.mavlink_direct")

INTERVAL, REQUEST, POINT, CONFIGURE = 511, 512, 1000, 1001
ATTITUDE, STATUS, INFORMATION = "GIMBAL_DEVICE_ATTITUDE_STATUS", "GIMBAL_MANAGER_STATUS", "GIMBAL_MANAGER_INFORMATION"
ACCEPTED, FAILED = 0, 4
ITSELF, NOBODY = -2, -3
NONE = None  # is NaN in JSON
FOLLOW = 12


class Client:
    """A ground station of MAVSDK that has found an autopilot."""

    def __init__(self, sdk):
        (self.system,) = wait_for(lambda: [system for system in sdk.get_systems() if system.component_ids()])
        self.gimbal = plugin.Gimbal(self.system)
        self.direct = direct.MavlinkDirect(self.system)
        self.heard = {ATTITUDE: [], STATUS: [], INFORMATION: []}
        self.direct.subscribe_message("", self._hear)
        assert self.ask(INTERVAL, 285, 50_000) == ACCEPTED  # like an ArduPilot, it passes attitudes on only then

    def _hear(self, message, user):
        if message.message_name in self.heard:
            self.heard[message.message_name].append(json.loads(message.fields_json))

    def ask(self, number, *values):
        """Send a command to the autopilot; return its answer."""
        numbers = [*values, *[0] * (7 - len(values))]
        fields = {"target_system": 1, "target_component": 1, "command": number, "confirmation": 0}
        fields |= {f"param{index}": value for index, value in enumerate(numbers, 1)}
        message = direct.MavlinkMessage("COMMAND_LONG", 0, 0, 1, 1, json.dumps(fields))
        return json.loads(self.direct.send_command(message).fields_json)["result"]

    def point(self, yaw):
        return self.ask(POINT, 0, yaw, NONE, NONE, FOLLOW)

    def yaw(self):
        """What the gimbal reported last [deg], clockwise from the nose."""
        return math.degrees(euler(self.heard[ATTITUDE][-1]["q"])[0])

    def primary(self):
        said = self.heard[STATUS]
        return said and (said[-1]["primary_control_sysid"], said[-1]["primary_control_compid"])


@pytest.fixture(scope="module")
def gimbal(tmp_path_factory):
    port = free_port()
    with device(tmp_path_factory.mktemp("gimbal"), "gimbal", "--wire", f"udpout:127.0.0.1:{port}") as process:
        process.port = port
        yield process


@pytest.fixture(scope="module")
def client(gimbal, tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setenv("HOME", str(tmp_path_factory.mktemp("home")))
    kind = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    with mavsdk.Mavsdk(kind) as sdk:
        assert sdk.add_any_connection(f"udpin://127.0.0.1:{gimbal.port}") == mavsdk.ConnectionResult.SUCCESS
        yield Client(sdk)
    patch.undo()


def truth(gimbal):
    """Where the gimbal really points [deg], clockwise."""
    return -gimbal.ask("status")["angle_deg"]


def steady(gimbal):
    before = truth(gimbal)
    time.sleep(0.3)
    return truth(gimbal) == before


def test_it_learns_of_the_gimbal_from_the_autopilot_and_its_plugin_lists_none(client):
    assert client.ask(REQUEST, 280) == ACCEPTED
    wait_for(lambda: client.heard[INFORMATION])
    assert client.heard[INFORMATION][-1]["gimbal_device_id"] == 1
    assert client.ask(REQUEST, 283) == FAILED
    assert client.gimbal.gimbal_list().gimbals == []


def test_it_takes_control_sees_that_it_has_it_and_gives_it_back(client):
    assert client.ask(CONFIGURE, ITSELF, ITSELF, -1, -1) == ACCEPTED
    wait_for(lambda: client.primary() == (245, 190))
    assert client.ask(CONFIGURE, NOBODY, NOBODY, -1, -1) == ACCEPTED
    wait_for(lambda: client.primary() == (0, 0))


@pytest.mark.parametrize("goal", [40.0, -40.0])
def test_it_points_and_the_gimbal_goes_there_and_says_so(client, gimbal, goal):
    assert client.point(goal) == ACCEPTED
    wait_for(lambda: abs(truth(gimbal) - goal) < 0.1)
    wait_for(lambda: abs(client.yaw() - goal) < 0.2)


def test_rates_turn_it_until_they_are_stopped(client, gimbal):
    client.point(0.0)
    wait_for(lambda: abs(truth(gimbal)) < 0.1)
    assert client.ask(POINT, NONE, NONE, 0, 10, FOLLOW) == ACCEPTED
    wait_for(lambda: truth(gimbal) > 5.0)
    assert client.ask(POINT, NONE, NONE, 0, 0, FOLLOW) == ACCEPTED
    wait_for(lambda: steady(gimbal))


def test_a_stuck_gimbal_is_seen_where_it_is_although_the_command_succeeds(client, gimbal):
    client.point(0.0)
    wait_for(lambda: abs(truth(gimbal)) < 0.1)
    gimbal.ask("stuck")
    assert client.point(60.0) == ACCEPTED
    count = len(client.heard[ATTITUDE])
    wait_for(lambda: len(client.heard[ATTITUDE]) > count + 5)
    assert abs(client.yaw()) < 0.2
    gimbal.ask("stuck off")


def test_a_gimbal_that_nobody_has_is_refused(client):
    assert client.ask(CONFIGURE, ITSELF, ITSELF, -1, -1, 0, 0, 7) == FAILED
