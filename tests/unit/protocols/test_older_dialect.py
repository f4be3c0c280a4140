"""A payload and a ground of neighbouring versions understand each other: the version before this one is kept.

When the dialect gets a new version, the present one is put beside those in ``dialects`` in the same way, and
``docs/reference/stability.md`` gets a line.
"""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from ross_protocols.mavlink.codec import Decoder
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.values import DIALECT_VERSION

BEFORE = Path(__file__).parent / "dialects" / f"ross-{DIALECT_VERSION - 1}.xml"


@pytest.fixture(scope="module")
def older(tmp_path_factory):
    """The Python module that a ground of the version before has, made by MAVLink's own generator."""
    path = tmp_path_factory.mktemp("older") / "older_dialect.py"
    command = [sys.executable, "-m", "pymavlink.tools.mavgen", "--lang=Python3", "--wire-protocol=2.0", "--no-validate"]
    subprocess.run([*command, f"--output={path}", BEFORE], check=True, capture_output=True)
    spec = importlib.util.spec_from_file_location("older_dialect", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def ours(module):
    """Our messages of a dialect, by name."""
    return {kind.msgname: kind for kind in module.mavlink_map.values() if kind.msgname.startswith("ROSS_")}


def filled(kind):
    """A message whose fields all differ from 0."""
    whole = {"char": b"abc", "float": 1.5, "double": 2.5}
    values = []
    for number, (name, what) in enumerate(zip(kind.fieldnames, kind.fieldtypes, strict=True)):
        length = kind.array_lengths[kind.ordered_fieldnames.index(name)]
        value = whole.get(what, number + 1)
        values.append([value] * length if length and what != "char" else value)
    return kind(*values)


def heard(module, *frames):
    """What a connection of a dialect makes of frames, whatever it does not know left out."""
    connection = module.MAVLink(None)
    connection.robust_parsing = True
    messages = [connection.parse_char(bytes([byte])) for frame in frames for byte in frame]
    return [message for message in messages if message is not None and message.get_type() != "BAD_DATA"]


def sent(module, message):
    """The frame of a message."""
    return bytes(message.pack(module.MAVLink(None, srcSystem=1, srcComponent=191)))


def test_the_version_before_had_fewer_messages_and_each_is_still_there(older):
    before, now = ours(older), ours(ross)
    assert before.keys() < now.keys()
    assert {name: (kind.id, kind.crc_extra) for name, kind in before.items()} == {
        name: (now[name].id, now[name].crc_extra) for name in before
    }


def test_an_older_ground_reads_every_message_of_a_newer_payload(older):
    for name, kind in ours(older).items():
        message = filled(ours(ross)[name])
        (read,) = heard(older, sent(ross, message))
        assert read.get_type() == name
        assert {field: getattr(read, field) for field in kind.fieldnames} == {
            field: getattr(message, field) if not isinstance(getattr(message, field), bytes) else "abc"
            for field in kind.fieldnames
        }


def test_a_newer_ground_reads_every_message_of_an_older_payload(older):
    for name, kind in ours(older).items():
        decoder = Decoder()
        (packet,) = decoder.feed(sent(older, filled(kind)))
        assert packet.name == name
        assert packet.value is not None
        new = set(ours(ross)[name].fieldnames) - set(kind.fieldnames)
        assert all(not getattr(packet.message, field) for field in new), "what is not sent reads as 0"


def test_a_message_that_an_older_ground_does_not_know_costs_it_nothing(older):
    unknown = sorted(ours(ross).keys() - ours(older).keys())
    assert unknown == ["ROSS_STREAM"]
    known = sent(ross, filled(ours(ross)["ROSS_STATUS"]))
    read = heard(older, *(sent(ross, filled(ours(ross)[name])) for name in unknown), known)
    assert [message.get_type() for message in read if message.get_type().startswith("ROSS_")] == ["ROSS_STATUS"]


def test_commands_and_states_keep_their_numbers(older):
    for enum, entries in older.enums.items():
        if not enum.startswith(("ROSS_", "MAV_CMD")):
            continue
        now = {entry.name: value for value, entry in ross.enums[enum].items()}
        old = {
            entry.name: value for value, entry in entries.items() if "ROSS" in entry.name and "END" not in entry.name
        }
        assert {name: now.get(name) for name in old} == old, enum
