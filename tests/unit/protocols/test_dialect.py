"""The dialect: what is generated is current, and what once flew never changes."""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from pymavlink.dialects.v20 import common

from ross_payload import events, health
from ross_protocols.mavlink import stream_values, values
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import MESSAGES, ross
from ross_protocols.mavlink.message_map import LAYOUTS, Field

ROOT = Path(__file__).resolve().parents[3]
XML = ElementTree.parse(ROOT / "protocols" / "mavlink" / "ross.xml").getroot()  # noqa: S314
OURS = {message.get("name"): message for message in XML.iter("message")}
OUR_LAYOUTS = [layout for layout in LAYOUTS if layout.message.msgname in OURS]

TUNNEL = 128 - 12  # bytes of a TUNNEL, less a frame's header and checksum

# Once flown, never changed: a new field is an extension, and an extension is not in the checksum.
CRC_EXTRA = {
    54000: ("ROSS_INFORMATION", 26),
    54001: ("ROSS_STATUS", 248),
    54002: ("ROSS_SOURCE", 6),
    54003: ("ROSS_ALIGNMENT", 166),
    54004: ("ROSS_SEPARATION", 253),
    54005: ("ROSS_AUDIO", 46),
    54006: ("ROSS_RECORDING", 125),
    54007: ("ROSS_DENSITY", 53),
    54008: ("ROSS_ISOLATION", 111),
    54009: ("ROSS_LINK", 14),
    54010: ("ROSS_STREAM", 95),
}


def entries(enum: str) -> dict[str, int]:
    found = XML.find(f"enums/enum[@name='{enum}']")
    assert found is not None, enum
    return {
        entry.get("name", "").removeprefix(f"{enum}_"): int(entry.get("value", "")) for entry in found.iter("entry")
    }


def extensions(message) -> list[str]:
    """The names of the fields behind ``<extensions/>``."""
    tags = [part.tag for part in message]
    return [part.get("name") for part in list(message)[tags.index("extensions") + 1 :]] if "extensions" in tags else []


def test_what_is_checked_in_is_what_the_xml_generates(tmp_path: Path) -> None:
    subprocess.run([sys.executable, ROOT / "protocols" / "generate.py", tmp_path], check=True)
    for made, kept in (
        ("ross_dialect.py", ROOT / "protocols" / "ross_protocols" / "mavlink" / "ross_dialect.py"),
        ("mavlink.md", ROOT / "docs" / "reference" / "mavlink.md"),
        ("ross.lua", ROOT / "protocols" / "wireshark" / "ross.lua"),
    ):
        assert (tmp_path / made).read_text() == kept.read_text(), f"{kept} is stale: make protocols"


def test_the_page_says_what_is_an_extension_and_what_commands_mean() -> None:
    page = (ROOT / "docs" / "reference" / "mavlink.md").read_text()
    added = {line.split("`")[1] for line in page.splitlines() if "*Extension.*" in line}
    assert added == {name for message in OURS.values() for name in extensions(message)}
    for param in XML.iter("param"):
        unit = f" [{param.get('units')}]" if param.get("units") else ""
        span = f", {param.get('minValue')} to {param.get('maxValue')}" if param.get("maxValue") else ""
        assert f"<br>{param.get('index')}: {param.get('label')}{unit}{span}. {param.text}" in page


def test_no_message_that_has_flown_changes() -> None:
    now = {number: (m.msgname, m.crc_extra) for number, m in MESSAGES.items() if m.msgname.startswith("ROSS_")}
    assert {number: now.get(number) for number in CRC_EXTRA} == CRC_EXTRA
    assert now.keys() == CRC_EXTRA.keys(), "a new message: add its checksum to the table"


def test_standard_messages_have_the_checksums_of_mavlink() -> None:
    """The numbers of MAVLink's own C library."""
    crc_extra = {80: 14, 111: 34, 300: 217, 396: 50, 397: 182}
    assert {number: MESSAGES[number].crc_extra for number in crc_extra} == crc_extra


@pytest.mark.parametrize("layout", OUR_LAYOUTS, ids=lambda layout: layout.message.msgname)
def test_every_message_fits_into_a_tunnel(layout) -> None:
    assert layout.message.unpacker.size <= TUNNEL
    assert 54000 <= layout.message.id <= 54019


@pytest.mark.parametrize("message", OURS.values(), ids=OURS.keys())
def test_every_message_begins_with_its_time(message) -> None:
    first = message.find("field")
    assert (first.get("name"), first.get("type"), first.get("units")) == ("time_usec", "uint64_t", "us")


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.message.msgname)
def test_every_field_carries_something(layout) -> None:
    assert layout.fields.keys() | layout.constant.keys() == set(layout.message.fieldnames)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.message.msgname)
def test_every_attribute_is_sent_once(layout) -> None:
    sent = [
        attribute
        for field in layout.fields.values()
        for attribute in ([field.attribute] if isinstance(field, Field) else field)
    ]
    assert sorted(sent) == sorted(layout.value.__dataclass_fields__)


@pytest.mark.parametrize("layout", OUR_LAYOUTS, ids=lambda layout: layout.message.msgname)
def test_bits_on_the_wire_are_those_of_the_dialect(layout) -> None:
    for name, field in layout.fields.items():
        if not isinstance(field, Field):
            enum = OURS[layout.message.msgname].find(f"field[@name='{name}']").get("enum")
            bits = {attribute.upper().removeprefix("ACTUATOR_"): bit for attribute, bit in field.items()}
            assert bits == entries(enum)


@pytest.mark.parametrize(
    ("enum", "dialect"),
    [
        (events.State, "ROSS_STATE"),
        (events.Outcome, "ROSS_OUTCOME"),
        (values.Rule, "ROSS_ALIGNMENT_RULE"),
        (values.CandidateState, "ROSS_CANDIDATE_STATE"),
        (values.Phase, "ROSS_SEPARATION_PHASE"),
        (values.RecordingState, "ROSS_RECORDING_STATE"),
        (stream_values.Selection, "ROSS_SELECTION"),
        (stream_values.Codec, "ROSS_CODEC"),
        (health.AudioTrouble, "ROSS_AUDIO_TROUBLE"),
    ],
)
def test_the_dialect_and_the_payload_number_alike(enum, dialect: str) -> None:
    assert {entry.name: entry.value for entry in enum} == entries(dialect)


@pytest.mark.parametrize(("enum", "prefix"), [(values.Health, "MAV_STATE_"), (values.Severity, "MAV_SEVERITY_")])
def test_the_payload_numbers_as_mavlink_does(enum, prefix: str) -> None:
    assert {entry: getattr(common, prefix + entry.name) for entry in enum} == {entry: entry.value for entry in enum}


DECLARED = {
    ("NaN", "nan"), ("INT8_MAX", "127"), ("UINT8_MAX", "255"), ("UINT16_MAX", "65535"),
    ("UINT32_MAX", str(2**32 - 1)), ("0", "0.0"),
}  # fmt: skip


def test_an_exploration_of_more_rotations_than_a_byte_holds_is_sent_as_the_most() -> None:
    status = values.Status(0, 0.0, 0, earth=False, rotation=300, rotation_max=1439)
    (packet,) = Decoder().feed(Encoder(1, 191).encode(status))
    assert (packet.message.rotation, packet.message.rotation_max) == (255, 255)


def test_a_number_not_known_is_declared_as_such() -> None:
    """What is sent as None is what the dialect calls invalid, so that a stranger can tell."""
    for layout in OUR_LAYOUTS:
        for name, field in layout.fields.items():
            declared = OURS[layout.message.msgname].find(f"field[@name='{name}']").get("invalid")
            if isinstance(field, Field) and declared is not None:
                sent = field.pair.there(None)
                assert (declared, str(sent)) in DECLARED
                assert field.pair.back(sent) is None


def test_pymavlink_stays_as_it_is() -> None:
    assert not CRC_EXTRA.keys() & common.mavlink_map.keys()
    assert not hasattr(common, "ROSS_STATE_IDLE")
    assert "ROSS_STATE" not in common.enums
    assert ross.mavlink_map.keys() >= common.mavlink_map.keys() | CRC_EXTRA.keys()
