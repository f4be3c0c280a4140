"""The turntable of a payload in another process as a gimbal: for MAVSDK, through an autopilot, and for an autopilot."""

import json
import math
import re
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

from ross_payload.clock import SystemClock
from ross_payload.transport.open_port import open_port
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import euler
from ross_sim.devices.gimbal_device import Servo
from ross_sim.devices.gimbal_manager import ArduPilot
from waiting import wait_for

mavsdk = pytest.importorskip("mavsdk", minversion="4", reason="needs the Python package mavsdk, 4 or later")
gimbals = pytest.importorskip("mavsdk.plugins.gimbal.gimbal")
direct = pytest.importorskip("mavsdk.plugins.mavlink_direct.mavlink_direct")

ONCE, STREAM = gimbals.SendMode.ONCE, gimbals.SendMode.STREAM
FOLLOW, LOCK = gimbals.GimbalMode.YAW_FOLLOW, gimbals.GimbalMode.YAW_LOCK
PRIMARY, NONE = gimbals.ControlMode.PRIMARY, gimbals.ControlMode.NONE
EXPLORE, CANCELLED = 54000, 6
STANDALONE, DEVICE = '[gimbal]\nmode = "standalone"\n', '[gimbal]\nmode = "device"\n'


class Client:
    """A MAVSDK ground station that has found the gimbal."""

    def __init__(self, sdk):
        (self.system,) = wait_for(lambda: [one for one in sdk.get_systems() if 154 in one.component_ids()])
        self.gimbal = gimbals.Gimbal(self.system)
        self.direct = direct.MavlinkDirect(self.system)
        (self.item,) = wait_for(lambda: self.gimbal.gimbal_list().gimbals)
        self.id = self.item.gimbal_id
        wait_for(lambda: not math.isnan(self.yaw()))

    def yaw(self):
        """Clockwise from the nose [deg]."""
        return self.gimbal.get_attitude(self.id).euler_angle_forward.yaw_deg

    def north(self):
        return self.gimbal.get_attitude(self.id).euler_angle_north.yaw_deg

    def rate(self):
        """Clockwise [deg/s]."""
        return math.degrees(self.gimbal.get_attitude(self.id).angular_velocity.yaw_rad_s)

    def primary(self):
        status = self.gimbal.get_control_status(self.id)
        return status.sysid_primary_control, status.compid_primary_control

    def mode(self):
        return self.gimbal.get_control_status(self.id).control_mode


@contextmanager
def ground_station(port, home):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HOME", str(home))
        kind = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
        with mavsdk.Mavsdk(kind) as sdk:
            assert sdk.add_any_connection(f"udpin://127.0.0.1:{port}") == mavsdk.ConnectionResult.SUCCESS
            yield Client(sdk)


@pytest.fixture(scope="module")
def client(ross_run, free_port, tmp_path_factory):
    port, folder = free_port(), tmp_path_factory.mktemp("standalone")
    with (
        ross_run(folder, f'url = "udpout:127.0.0.1:{port}"', more=STANDALONE) as payload,
        ground_station(port, folder) as client,
    ):
        client.payload = payload
        yield client


def test_it_finds_the_gimbal_and_who_made_it(client):
    item = client.item
    assert (item.gimbal_manager_component_id, item.gimbal_device_id) == (154, 1)
    assert (item.vendor_name, item.model_name) == ("RoSS", "tb6600")


def test_it_takes_control_and_sees_that_it_has_it(client):
    client.gimbal.take_control(client.id, PRIMARY)
    wait_for(lambda: client.mode() == PRIMARY)
    assert client.primary() == (245, 190)


@pytest.mark.parametrize(("mode", "yaw"), [(ONCE, 35.0), (STREAM, -20.0)])
def test_it_points_and_reads_where_the_array_is(client, mode, yaw):
    client.gimbal.set_angles(client.id, 0.0, 0.0, yaw, FOLLOW, mode)
    wait_for(lambda: abs(client.yaw() - yaw) < 0.2)


def test_a_rate_that_is_renewed_turns_the_array_and_one_that_is_not_ends(client):
    for _ in range(20):
        client.gimbal.set_angular_rates(client.id, 0.0, 0.0, 10.0, FOLLOW, STREAM)
        time.sleep(0.05)
    wait_for(lambda: client.rate() == pytest.approx(10.0, abs=0.5))
    wait_for(lambda: client.rate() == 0.0, seconds=10.0)
    assert client.yaw() < -20 + 10 * 10


def test_a_yaw_from_north_is_refused_where_nobody_knows_it(client):
    with pytest.raises(gimbals.GimbalError):
        client.gimbal.set_angles(client.id, 0.0, 0.0, 10.0, LOCK, ONCE)


def test_it_gives_control_back(client):
    client.gimbal.release_control(client.id)
    wait_for(lambda: client.mode() == NONE)
    assert client.primary() == (0, 0)


def test_while_a_task_runs_it_is_refused_until_it_takes_control_which_ends_the_task(client):
    ends = []
    client.direct.send_command_async(
        explore(), lambda result, ack, user: ends.append(json.loads(ack.fields_json)["result"])
    )
    wait_for(lambda: client.primary() == (1, 191))
    with pytest.raises(gimbals.GimbalError):
        client.gimbal.set_angles(client.id, 0.0, 0.0, 5.0, FOLLOW, ONCE)
    client.gimbal.take_control(client.id, PRIMARY)
    client.gimbal.set_angles(client.id, 0.0, 0.0, 5.0, FOLLOW, ONCE)
    wait_for(lambda: ends == [CANCELLED])
    wait_for(lambda: abs(client.yaw() - 5.0) < 0.2)
    client.gimbal.release_control(client.id)
    wait_for(lambda: client.primary() == (0, 0))


def explore():
    fields = {"target_system": 1, "target_component": 191, "command": EXPLORE, "confirmation": 0}
    fields |= {f"param{index}": 0 for index in range(1, 8)}
    return direct.MavlinkMessage("COMMAND_LONG", 0, 0, 1, 191, json.dumps(fields))


@pytest.mark.soak
def test_through_an_autopilot_it_points_from_north(ross_run, free_port, living, tmp_path):
    inside, outside = free_port(), free_port()
    ways = ("--link", f"udpin:127.0.0.1:{inside}", "--link", f"udpout:127.0.0.1:{outside}")
    link = f'url = "udpout:127.0.0.1:{inside}"\nrole = "autopilot"'
    with (
        living(("autopilot", *ways, "--yaw", "30"), tmp_path / "autopilot", code=130),
        ross_run(tmp_path / "payload", link, more=STANDALONE + '[mount]\nsource = "autopilot"\n'),
        ground_station(outside, tmp_path) as client,
    ):
        client.gimbal.take_control(client.id, PRIMARY)
        client.gimbal.set_angles(client.id, 0.0, 0.0, 70.0, LOCK, ONCE)
        wait_for(lambda: abs(client.north() - 70.0) < 0.5)
        wait_for(lambda: abs(client.yaw() - 40.0) < 0.5)


class Flight:
    """The simulated ArduPilot as manager, in real time; what the gimbal tells it."""

    def __init__(self, port):
        self._clock = SystemClock()
        self._port = open_port(f"udpin:127.0.0.1:{port}", self._clock.now)
        servo = Servo(lower=-3.4, upper=3.4, max_speed=4.0, max_acceleration=2.0)
        self.manager = ArduPilot((1, 1), (1, 154), servo, lambda now: 0.0)
        self._ear, self._voice = Decoder(), Encoder(1, 1)
        self.attitudes = []

    def close(self):
        self._port.close()

    def until(self, true, seconds=30.0):
        """Fly until something is true."""
        end = self._clock.now() + seconds
        while not true():
            assert self._clock.now() < end, f"waited {seconds} s in vain"
            self._step()
            self._clock.sleep(0.01)

    def point(self, yaw):
        """Let the pilot point, clockwise [deg]."""
        message = common.MAVLink_gimbal_manager_set_pitchyaw_message(
            1, 1, 32, 0, 0.0, math.radians(yaw), math.nan, math.nan
        )
        (packet,) = Decoder().feed(Encoder(255, 190).encode(message))
        self.manager.on_packet(packet, self._clock.now())

    def yaw(self):
        return math.degrees(euler(self.attitudes[-1].q)[0]) if self.attitudes else math.nan

    def failures(self):
        return self.attitudes[-1].failure_flags if self.attitudes else None

    def _step(self):
        now = self._clock.now()
        packets = [packet for data in self._port.receive() for packet in self._ear.feed(data)]
        self.attitudes += [one.message for one in packets if one.name == "GIMBAL_DEVICE_ATTITUDE_STATUS"]
        said = [answer for packet in packets for answer in self.manager.on_packet(packet, now)]
        for message in (*said, *self.manager.live(now)):
            self._port.send(self._voice.encode(message))


def test_an_autopilot_manages_and_points_it(ross_run, free_port, tmp_path):
    port = free_port()
    flight = Flight(port)
    link = f'url = "udpout:127.0.0.1:{port}"\nrole = "autopilot"'
    try:
        with ross_run(tmp_path, link, more=DEVICE):
            flight.until(lambda: flight.failures() == 0)
            assert flight.yaw() == pytest.approx(0.0, abs=0.1)
            flight.point(45.0)
            flight.until(lambda: abs(flight.yaw() - 45.0) < 0.2)
    finally:
        flight.close()


@pytest.mark.soak
def test_the_guide_points_a_simulated_payload(free_port, living, request, tmp_path):
    page = (request.config.rootpath / "docs" / "how-to" / "turntable-as-gimbal.md").read_text(encoding="utf-8")
    scenario = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)[1]
    program = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
    (tmp_path / "gimbal.toml").write_text(scenario)
    url = f"127.0.0.1:{free_port()}"
    served = ("sitl", "--serve", "--speed", "1", "--scenario", "gimbal.toml", "--telemetry", f"udpout:{url}")
    with living(served, tmp_path):
        command = [sys.executable, "-c", program, f"udpin://{url}"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=100)
    assert done.stdout.splitlines()[-1] == "there"
