"""Mirrors: what a ground station without our dialect can show."""

import math
import re
from pathlib import Path

import pytest

from ross_payload.health import AudioHealth
from ross_payload.telemetry.event_messages import azimuths, named
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Source, Status

STATUS = Status(0, 1.0, 6, earth=True, heading=math.radians(-30), k=2, score=3.5)


def source(index: int, azimuth: float, target: bool = False) -> Source:
    return Source(0, 1, index, 2, azimuth, 0.02, 0.9, 0.5, earth=True, resolved=True, target=target)


SOURCES = [source(0, math.radians(90)), source(1, math.radians(-45), target=True)]


def test_a_person_reads_compass_degrees() -> None:
    numbers = {value.name: value.value for value in named(STATUS, SOURCES, AudioHealth(level_db=(-40.0, -42.0)), 7.0)}
    assert numbers == pytest.approx(
        {"ross_state": 6, "ross_k": 2, "ross_head": 30, "ross_tgt": 45, "ross_score": 3.5, "ross_level": -40}
    )


def test_what_is_not_known_is_not_told() -> None:
    assert [value.name for value in named(Status(0, 0.0, 0, earth=False), [], None, 0.0)] == ["ross_state"]


def test_every_name_fits_into_its_message() -> None:
    names = [value.name for value in named(STATUS, SOURCES, AudioHealth(), 0.0)]
    assert all(len(name) <= 10 for name in names)
    assert len(set(names)) == len(names)


def test_the_array_holds_k_and_every_azimuth() -> None:
    assert azimuths(0, SOURCES).numbers == pytest.approx((2, 270, 45))
    assert azimuths(0, []).numbers == (0,)


def test_a_client_that_knows_only_the_common_dialect_reads_them() -> None:
    parser = common.MAVLink(None)
    encoder = Encoder(1, 191)
    array = parser.parse_buffer(encoder.encode(azimuths(5, SOURCES)))[0]
    assert (array.get_type(), array.name, array.array_id) == ("DEBUG_FLOAT_ARRAY", "ross_az", 1)
    assert list(array.data[:4]) == pytest.approx([2, 270, 45, 0])
    value = parser.parse_buffer(encoder.encode(named(STATUS, SOURCES, None, 5e6)[0]))[0]
    assert (value.get_type(), value.name, value.value) == ("NAMED_VALUE_FLOAT", "ross_state", 6)
    assert value.time_boot_ms == 5_000_000_000 % 2**32, "it wraps after 49 days"
    assert Decoder().feed(encoder.encode(azimuths(5, SOURCES)))[0].value.numbers == pytest.approx((2, 270, 45))


def test_mission_planner_s_fields_are_named_after_them() -> None:
    page = (Path(__file__).parents[3] / "docs" / "how-to" / "ground-stations.md").read_text(encoding="utf-8")
    fields = re.findall(r"<customfield(\d)>MAV_(\w+)</customfield(\d)>", page)
    names = {value.name.upper() for value in named(STATUS, SOURCES, AudioHealth(), 0.0)}
    assert {name for _, name, _ in fields} == names
    assert [(begin, end) for begin, _, end in fields] == [(str(index), str(index)) for index in range(len(names))]
