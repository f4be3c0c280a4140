"""The bridge to ROS 2: what a payload tells as messages of ROS, and its turn, without ROS."""

import asyncio
import math
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from ross_payload.ground import RefusedByPayload
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.dialect import ross
from scripted_station import Scripted, raised, source, status, with_payload

PACKAGE = Path(__file__).parents[3] / "docs" / "examples" / "plugins" / "ros2"


@pytest.fixture(scope="module")
def ross_ros2():
    sys.path.insert(0, str(PACKAGE))
    try:
        from ross_ros2 import bridge, conversions

        yield bridge, conversions
    finally:
        sys.path.remove(str(PACKAGE))
        for name in [name for name in sys.modules if name.startswith("ross_ros2")]:
            del sys.modules[name]


def yaw(pose):
    turned = pose["orientation"]
    return math.degrees(2 * math.atan2(turned["z"], turned["w"]))


@pytest.mark.parametrize(
    ("azimuth", "earth", "expected"), [(0, True, 90), (90, True, 0), (180, True, -90), (0, False, 0), (90, False, -90)]
)
def test_compass_degrees_become_the_yaw_of_ros_and_back(ross_ros2, azimuth, earth, expected):
    _, conversions = ross_ros2
    turned = conversions.yaw_of(azimuth, earth=earth)
    assert math.degrees(turned) == pytest.approx(expected)
    back = conversions.azimuth_of(3 * math.cos(turned), 3 * math.sin(turned), earth=earth)
    assert (back - azimuth + 180) % 360 - 180 == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("point", [(0.0, 0.0), (math.nan, 1.0), (math.inf, 0.0)])
def test_a_point_without_a_direction_is_refused(ross_ros2, point):
    with pytest.raises(ValueError, match="expected a point beside the array"):
        ross_ros2[1].azimuth_of(*point, earth=True)


def told(bridge_module, station, wait=lambda payload: bool(payload.sources)):
    """What is published once a payload is known."""
    said = {}

    async def look(payload):
        await payload.until(lambda: wait(payload))
        bridge_module.Bridge(payload, lambda topic, kind, fields: said.update({topic: (kind, fields)})).say()

    with_payload(station, look)
    return said


def test_bearings_heading_and_state_are_published(ross_ros2):
    station = Scripted()
    station.say(status(2.0, heading=math.radians(-90)))
    for index, azimuth in enumerate((10, 250)):
        station.say(source(index, azimuth))
    said = told(ross_ros2[0], station, lambda payload: len(payload.sources) == 2)
    kind, fields = said["bearings"]
    assert (kind, fields["header"]["frame_id"]) == ("geometry_msgs/msg/PoseArray", "map")
    assert [yaw(pose) for pose in fields["poses"]] == pytest.approx([80, -160])
    assert yaw(said["heading"][1]["pose"]) == pytest.approx(0, abs=1e-4)
    (shown,) = said["/diagnostics"][1]["status"]
    assert shown["level"] == b"\0"
    values = {each["key"]: each["value"] for each in shown["values"]}
    assert values["source 1"] == "azimuth 250.0 deg, sigma 1.1 deg, confidence 0.90"
    assert all(isinstance(value, str) for value in values.values())


def test_a_payload_that_is_silent_is_stale_and_its_bearings_are_not_repeated(ross_ros2, monkeypatch):
    bridge, _ = ross_ros2
    station, said = Scripted(), []
    station.say(source(0, 10))

    async def look(payload):
        between = bridge.Bridge(payload, lambda topic, kind, fields: said.append((topic, fields)))
        between.say()
        now = bridge.time.monotonic()
        monkeypatch.setattr(bridge.time, "monotonic", lambda: now + 60)
        between.say()
        monkeypatch.undo()

    with_payload(station, look)
    assert [topic for topic, _ in said].count("bearings") == 1
    assert said[-1][1]["status"][0]["level"] == b"\3"


def test_a_turn_towards_a_point_is_the_command(ross_ros2):
    station = Scripted(Result.IN_PROGRESS, Result.ACCEPTED)
    with_payload(station, lambda payload: ross_ros2[0].Bridge(payload, print).turn("map", 0.0, -2.0))
    (command,) = station.commands()
    assert (command.command, command.param1) == (ross.MAV_CMD_ROSS_TURN, pytest.approx(180))


def test_a_turn_in_another_frame_moves_nothing_and_a_refusal_says_why(ross_ros2):
    station = Scripted(Result.DENIED, text="TURN denied: stopped")

    async def both(payload):
        between = ross_ros2[0].Bridge(payload, print)
        wrong = await raised(between.turn("ross_mount", 1.0, 0.0))
        assert station.commands() == []
        return wrong, await raised(between.turn("map", 1.0, 0.0)), between.error_deg(1.0, 0.0)

    wrong, refused, beside = with_payload(station, both)
    assert str(wrong) == "expected a target in the frame map, got 'ross_mount'"
    assert isinstance(refused, RefusedByPayload)
    assert beside == pytest.approx(90)


def test_samples_become_16_bit_little_endian(ross_ros2):
    _, conversions = ross_ros2
    data = bytes(conversions.audio(np.array([0.0, 0.5, -1.0, 2.0]))["data"])
    assert np.frombuffer(data, "<i2").tolist() == [0, 16384, -32768, 32767]
    assert conversions.audio_info(16000)["sample_format"] == "S16LE"


def test_a_voice_is_asked_for_published_in_real_time_and_ended(ross_ros2, monkeypatch):
    bridge, _ = ross_ros2
    asked, said = [], []

    class Port:
        rate, codec, place = 16000, "opus", ("127.0.0.1", 5004)

        def __init__(self, *_):
            pass

        async def open(self, _):
            return self

        def read(self, n):
            return np.zeros(n, np.float32), None

        def close(self):
            asked.append("closed")

    class Streamed:
        number = 7

    class Client:
        async def stream(self, what, *, to, codec):
            asked.append((what, to, codec))
            return Streamed()

        async def stop_stream(self, number):
            asked.append(number)

    monkeypatch.setattr(bridge, "RtpPort", Port)

    async def listen():
        async with asyncio.timeout(0.3):
            between = bridge.Bridge(Client(), lambda topic, kind, fields: said.append((topic, fields)))
            await between.voice("127.0.0.1")

    with pytest.raises(TimeoutError):
        asyncio.run(listen())
    assert asked == [("target", ("127.0.0.1", 5004), "opus"), 7, "closed"]
    assert [topic for topic, _ in said][:2] == ["audio_info", "audio"]
    assert all(len(fields["data"]) == 640 for topic, fields in said if topic == "audio")


def test_the_package_says_what_it_imports():
    root = ET.parse(PACKAGE / "package.xml").getroot()  # noqa: S314 - ours
    needs = {each.text for each in root.iter("exec_depend")}
    code = "".join(path.read_text() for path in (PACKAGE / "ross_ros2").glob("*.py"))
    used = {name for name in needs if f"import {name}" in code or f"from {name}" in code or f"{name}/msg" in code}
    assert used == needs
