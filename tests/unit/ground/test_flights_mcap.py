"""An MCAP export says what the log says, in standard schemas, read back by a reader that is not ours."""

import json
import math
import os
import resource
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from flight_logs import UNIX, full_tick, record, vehicle_frames
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights.frame_stats import tallies
from ross_payload.ground.flights.reading import open_flight
from ross_protocols.mavlink.codec import Encoder, chunks
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import MESSAGES
from ross_protocols.mavlink.tunnel import Wrapper
from ross_protocols.mavlink.values import Severity, Source, Status, Text

pytest.importorskip("foxglove", reason="needs the extra 'mcap'")

US = ComponentId(1, 191)
TEXTS = 13  # field of foxglove.SceneEntity


@pytest.fixture
def flown(tmp_path):
    """Write values of a payload, and frames of others, as a log; open it."""

    def call(values, others=(), start=UNIX):
        encoder = Encoder(1, 191)
        frames = [*map(encoder.encode, values), *others]
        path = tmp_path / "flight.tlog"
        path.write_bytes(b"".join(record(start + 100_000 * place, frame) for place, frame in enumerate(frames)))
        return open_flight(path)

    return call


def exported(flight, path):
    from ross_payload.ground.flights.mcap import export

    export(flight, flight.payloads, path)
    with path.open("rb") as file:
        reader = make_reader(file)
        return reader.get_summary(), list(reader.iter_messages(log_time_order=False)), list(reader.iter_metadata())


def on(messages, topic):
    return [message for _, channel, message in messages if channel.topic == topic]


def decoded(messages, topic):
    """Decode protobuf with the schemas inside the file, by field number: nothing of ours, nothing of foxglove's."""
    return [fields_of(message.data) for message in on(messages, topic)]


def fields_of(data):
    """Return the fields of a protobuf message by number: bytes, doubles and integers; the last of each."""
    found, place = {}, 0
    while place < len(data):
        key, place = varint(data, place)
        kind = key & 7
        if kind == 0:
            found[key >> 3], place = varint(data, place)
        elif kind == 1:
            found[key >> 3] = float(np.frombuffer(data[place : place + 8], "<f8")[0])
            place += 8
        else:
            assert kind == 2
            size, place = varint(data, place)
            found[key >> 3] = data[place : place + size]
            place += size
    return found


def varint(data, place):
    number, shift = 0, 0
    while True:
        octet = data[place]
        number |= (octet & 127) << shift
        place, shift = place + 1, shift + 7
        if octet < 128:
            return number, place


def yaw_of(quaternion):
    """Angle about z of a protobuf quaternion: x 1, y 2, z 3, w 4; zeros are not sent."""
    parts = fields_of(quaternion)
    assert 1 not in parts
    assert 2 not in parts
    return 2 * math.atan2(parts.get(3, 0.0), parts.get(4, 0.0))


def test_every_message_of_ours_is_there_once_in_order_at_its_time(flown, tmp_path):
    flight = flown([value for step in range(20) for value in full_tick(step / 10, step)])
    summary, messages, _ = exported(flight, tmp_path / "a.mcap")
    topics = Counter(channel.topic for _, channel, _ in messages)
    ours = {kind.name: kind.count for kind in tallies(flight)[US].kinds if kind.name.startswith("ROSS_")}
    assert {f"/1-191/{name}": count for name, count in ours.items()}.items() <= topics.items()
    times = [message.log_time for _, _, message in messages]
    assert times == sorted(times)
    assert times[0] == UNIX * 1000
    assert summary.statistics.message_count == len(messages)


def test_the_values_are_those_of_the_log(flown, tmp_path):
    values = [value for step in range(5) for value in full_tick(step / 10, step)]
    flight = flown(values)
    _, messages, _ = exported(flight, tmp_path / "a.mcap")
    for _, packet in flight.packets(np.arange(len(flight.index))):
        if not packet.name.startswith("ROSS_"):
            continue
        told = json.loads(on(messages, f"/1-191/{packet.name}").pop(0).data)
        messages = [each for each in messages if json_of(each) != told or each[1].topic != f"/1-191/{packet.name}"]
        for field, number in told.items():
            wire = getattr(packet.message, field)
            same = number == (list(wire) if isinstance(wire, tuple | list) else wire)
            assert same or number is None, field


def json_of(each):
    return json.loads(each[2].data) if each[1].message_encoding == "json" else None


def test_what_is_not_known_is_null(flown, tmp_path):
    _, messages, _ = exported(flown([Status(0, 0.0, 3, True, heading=None, k=None, target=2)]), tmp_path / "a.mcap")
    told = json.loads(on(messages, "/1-191/ROSS_STATUS")[0].data)
    assert (told["heading"], told["k"], told["outcome"], told["target"]) == (None, None, None, 2)
    assert not on(messages, "/tf")


def test_the_json_channels_bring_schemas_with_units(flown, tmp_path):
    summary, *_ = exported(flown(list(full_tick(0.0, 0))), tmp_path / "a.mcap")
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        if channel.message_encoding != "json":
            assert schema.name.startswith("foxglove.")
            continue
        told = json.loads(schema.data)
        by_name = {message.msgname: message for message in MESSAGES.values()}
        assert list(told["properties"]) == by_name[schema.name].fieldnames
    status = next(json.loads(each.data) for each in summary.schemas.values() if each.name == "ROSS_STATUS")
    assert status["properties"]["heading"]["description"] == "[rad]"
    assert "3 explore_listen" in status["properties"]["state"]["description"]


@pytest.mark.parametrize(
    ("compass", "enu"),
    [(0.0, 90.0), (90.0, 0.0), (180.0, -90.0), (270.0, 180.0)],
    ids=["north is y", "east is x", "south is -y", "west is -x"],
)
def test_headings_turn_into_those_of_foxglove(flown, tmp_path, compass, enu):
    heading = math.radians(-compass)
    status = Status(0, 0.0, 3, earth=True, heading=math.remainder(heading, 2 * math.pi), mount_yaw=0.0)
    _, messages, _ = exported(flown([status]), tmp_path / "a.mcap")
    (pose,) = decoded(messages, "/1-191/heading")
    assert pose[2] == b"earth"
    turned = yaw_of(fields_of(pose[3])[2])
    assert math.cos(turned - math.radians(enu)) == pytest.approx(1.0)


def test_the_frames_lead_from_the_earth_over_the_mount_to_the_axis(flown, tmp_path):
    status = Status(0, 0.0, 3, earth=True, heading=0.7, mount_yaw=0.2)
    _, messages, _ = exported(flown([status]), tmp_path / "a.mcap")
    mount, axis = decoded(messages, "/tf")
    assert (mount[2], mount[3]) == (b"earth", b"1-191/mount")
    assert (axis[2], axis[3]) == (b"1-191/mount", b"1-191/axis")
    assert yaw_of(mount[5]) == pytest.approx(0.2 + math.pi / 2)
    assert yaw_of(axis[5]) == pytest.approx(0.5)


def test_without_a_north_all_counts_from_the_mount(flown, tmp_path):
    _, messages, _ = exported(flown([Status(0, 0.0, 3, earth=False, heading=0.7)]), tmp_path / "a.mcap")
    (axis,) = decoded(messages, "/tf")
    assert axis[2] == b"1-191/mount"
    assert yaw_of(axis[5]) == pytest.approx(0.7)


def test_a_source_in_the_east_has_its_name_on_the_x_axis(flown, tmp_path):
    east = Source(0, 1, 0, 1, -math.pi / 2, 0.05, 0.9, 1.0, earth=True, resolved=True, target=True)
    _, messages, _ = exported(flown([east]), tmp_path / "a.mcap")
    (update,) = decoded(messages, "/1-191/scene")
    entity = fields_of(update[2])
    text = fields_of(entity[TEXTS])
    place = fields_of(fields_of(text[1])[1])
    assert b"0 target" in text.values()
    assert place[1] > 5.0
    assert abs(place.get(2, 0.0)) < 1e-6


def test_texts_are_logs_with_their_weight(flown, tmp_path):
    said = [Text(Severity.INFO, "RoSS: quiet"), Text(Severity.ERROR, "RoSS: loud")]
    _, messages, _ = exported(flown([Status(0, 0.0, 3, True), *said]), tmp_path / "a.mcap")
    logs = decoded(messages, "/1-191/log")
    assert [(each[2], each[3]) for each in logs] == [(2, b"RoSS: quiet"), (4, b"RoSS: loud")]


def test_a_text_that_was_not_heard_to_its_end_is_told_all_the_same(flown, tmp_path):
    flight = flown([Status(0, 0.0, 3, earth=True), *chunks(Severity.WARNING, "x" * 60, 9)[:1]])
    _, messages, _ = exported(flight, tmp_path / "out.mcap")
    assert [fields[3].decode() for fields in decoded(messages, "/1-191/log")] == ["x" * 50 + " ..."]
    assert [(mark.at, mark.words) for mark in flight.marks][1:] == [(0.1, "x" * 50 + " ...")]


def test_the_vehicle_has_a_place_and_a_heading_clockwise_from_north(flown, tmp_path):
    flight = flown([Status(0, 0.0, 3, True)], vehicle_frames(steps=3))
    _, messages, _ = exported(flight, tmp_path / "a.mcap")
    fix = decoded(messages, "/vehicle-1/location")[0]
    numbers = sorted(value for value in fix.values() if isinstance(value, float))
    assert any(value == pytest.approx(47.3977) for value in numbers)
    assert any(value == pytest.approx(8.5455) for value in numbers)
    assert any(value == pytest.approx(math.pi / 2) for value in numbers)


def test_what_came_through_a_tunnel_is_exported_as_what_it_is(flown, tmp_path):
    wrapper = Wrapper(1, 191)
    _, messages, _ = exported(flown([wrapper.wrap(Status(0, 0.0, 3, True, k=2))]), tmp_path / "a.mcap")
    assert json.loads(on(messages, "/1-191/ROSS_STATUS")[0].data)["k"] == 2


def test_a_log_without_a_date_counts_from_its_first_frame_and_says_so(flown, tmp_path):
    flight = flown([Status(0, 0.0, 3, True)], start=7_000_000)
    _, messages, about = exported(flight, tmp_path / "a.mcap")
    assert messages[0][2].log_time == 0
    assert about[0].metadata["time"] == "since the first frame"


def threads():
    return {path.name for path in Path("/proc/self/task").iterdir()}


def test_the_same_flight_makes_the_same_bytes_and_no_thread(flown, tmp_path):
    flight = flown([value for step in range(20) for value in full_tick(step / 10, step)], vehicle_frames())
    before = threads()
    for name in ("a.mcap", "b.mcap"):
        exported(flight, tmp_path / name)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    assert threads() == before


def test_an_export_that_fails_says_so_once_and_leaves_the_earlier_one(flown, tmp_path):
    flight = flown([value for step in range(50) for value in full_tick(step / 10, step)])
    path = tmp_path / "a.mcap"
    path.write_bytes(b"the earlier one")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, limits[1]))
    try:
        with pytest.raises(GroundError, match=r"a\.mcap: cannot be written: File too large"):
            exported(flight, path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == b"the earlier one"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.mcap", "flight.tlog"]


def test_a_place_that_is_not_there_is_told(flown, tmp_path):
    flight = flown([Status(0, 0.0, 3, True)])
    with pytest.raises(GroundError, match="cannot be written: No such file"):
        exported(flight, tmp_path / "nowhere" / "a.mcap")


def test_the_script_of_the_manual_reads_the_export(flown, tmp_path):
    exported(flown([Status(0, 0.0, 3, True, k=2, score=1.5)], start=7_000_000), tmp_path / "flight.mcap")
    page = (Path(__file__).parents[3] / "docs" / "how-to" / "look-at-a-flight.md").read_text(encoding="utf-8")
    script = page.split("```python\n")[1].split("```")[0]
    said = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert said.stdout == "0.0 2 1.5\n"


def test_a_flight_whose_name_is_no_utf_8_is_exported(tmp_path):
    log = tmp_path / os.fsdecode(b"fl\xffight.tlog")
    log.write_bytes(record(UNIX, Encoder(1, 191).encode(Text(Severity.INFO, "hello"))))
    _, _, about = exported(open_flight(log), tmp_path / "flight.mcap")
    assert about[0].metadata["flight"] == "fl\\udcffight.tlog"
