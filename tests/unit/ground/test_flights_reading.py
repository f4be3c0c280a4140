"""Any telemetry log can be opened: anybody's, mixed, damaged, cut off, still growing."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as pymavlink_common

from examples import examples
from flight_logs import MAVLOGDUMP, UNIX, frames, full_tick, log_of, vehicle_frames
from ross_payload.ground.errors import GroundError
from ross_payload.ground.flights import bookmarks, log_file
from ross_payload.ground.flights.frame_stats import tallies
from ross_payload.ground.flights.reading import open_flight
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.tunnel import Wrapper
from ross_protocols.mavlink.values import Health, Heartbeat, Named, Severity, Status, Text

US = ComponentId(1, 191)


def test_every_frame_of_a_log_is_found_with_its_sender_and_time(opened):
    ours = frames()
    flight = opened(log_of(ours))
    assert len(flight.index) == len(ours) == 110
    assert flight.payloads == (US,)
    assert flight.start == UNIX / 1e6
    assert flight.duration == pytest.approx(1.09)
    assert flight.notes == ()
    assert [packet.frame for _, packet in flight.packets(np.arange(len(ours)))] == ours


def test_a_log_in_simulated_time_does_not_claim_a_date(opened):
    flight = opened(log_of(frames(), start=20_000))
    assert flight.start is None
    assert flight.at[0] == 0.0


def test_frames_of_a_vehicle_do_not_disturb(opened):
    mixed = [frame for pair in zip(frames(3), vehicle_frames(steps=11), strict=True) for frame in pair]
    counted = tallies(opened(log_of(mixed)))
    assert {str(who): tally.frames for who, tally in counted.items()} == {"1-1": 33, "1-191": 33}


def test_mavlink_1_and_signed_frames_count_as_any_other(opened):
    old = pymavlink_common.MAVLink(None, srcSystem=1, srcComponent=1)
    beats = [bytes(pymavlink_common.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3).pack(old, True)) for _ in range(5)]
    assert beats[0][0] == 0xFE
    signed = frames(1, key=bytes(32))
    assert signed[0][2] == 1
    flight = opened(log_of(beats + signed))
    assert [tally.frames for tally in tallies(flight).values()] == [5, 11]
    assert len(list(flight.packets(np.arange(16)))) == 16


def test_a_payload_behind_an_autopilot_is_found_inside_tunnel(opened):
    wrapper, encoder = Wrapper(1, 191), Encoder(1, 191)
    flight = opened(log_of([encoder.encode(wrapper.wrap(value)) for value in full_tick(0.0, 0)][:10]))
    counted = tallies(flight)[US]
    assert flight.payloads == (US,)
    assert counted.tunnelled
    assert {kind.name: kind.count for kind in counted.kinds}["ROSS_SOURCE"] == 3


def test_a_payload_that_only_its_mirrors_tell_of_is_found(opened):
    encoder = Encoder(1, 191)
    flight = opened(log_of([encoder.encode(Named(1.0, "ross_k", 3.0)), *vehicle_frames()]))
    assert flight.payloads == (US,)


def test_changes_of_the_state_and_texts_are_marked(opened):
    encoder = Encoder(1, 191)
    said = [Status(0, 0.0, state, True) for state in (3, 3, 6, 6, 6)] + [Text(Severity.INFO, "RoSS: heard somebody")]
    flight = opened(log_of(map(encoder.encode, said), step=1_000_000))
    assert [(mark.at, mark.words) for mark in flight.marks] == [
        (0.0, "explore listen"),
        (2.0, "run"),
        (5.0, "heard somebody"),
    ]


def test_events_that_are_too_many_to_be_listed_are_told_of(opened, monkeypatch):
    encoder = Encoder(1, 191)
    log = log_of([encoder.encode(Status(0, 0.0, 3 + number % 2, True)) for number in range(30)], step=1_000_000)
    assert opened(log).notes == ()
    monkeypatch.setattr(bookmarks, "MOST", 12)
    flight = opened(log)
    assert len(flight.marks) == 12
    assert flight.notes == ("events after 11 s are too many to be listed",)


@pytest.mark.parametrize("lost", [1, 9, 20, 60])
def test_a_last_frame_that_is_cut_off_is_told_and_left_out(opened, lost):
    ours = frames(1)[:4]
    flight = opened(log_of(ours)[:-lost])
    assert flight.notes == ("the last frame is cut off",)
    assert len(flight.index) == (3 if lost < 8 + len(ours[-1]) else 2)


def test_garbage_in_the_middle_is_skipped_and_told(opened):
    log = log_of(frames())
    place = 8 + len(frames()[0])
    flight = opened(log[:place] + b"\xfd\xfegarbage\xfd" * 7 + log[place:])
    assert len(flight.index) == 110
    assert flight.notes == ("70 bytes in 1 place are no frames and were skipped",)


def test_a_frame_with_a_wrong_checksum_costs_no_other(opened):
    log = bytearray(log_of(frames()))
    log[8 + len(frames()[0]) + 8 + 20] ^= 0xFF
    flight = opened(bytes(log))
    assert len(flight.index) == 109
    assert flight.notes == ("1 frames have a wrong checksum (damaged, or of another dialect): ROSS_SOURCE x 1",)


def test_damage_on_the_edge_of_what_is_read_at_once_costs_as_little(opened, monkeypatch):
    piece = 1 << 18  # in place of one of 4 MB
    monkeypatch.setattr(log_file, "PIECE", piece)
    log = log_of(frames() * (piece // 6000))
    assert len(log) > piece + 1000
    edge = piece - 590
    whole = opened(log)
    broken = opened(log[:edge] + b"\x00" * 700 + log[edge:])
    assert len(whole.index) - 1 <= len(broken.index) <= len(whole.index)
    assert len(opened(log[:edge] + log[edge + 300 :]).index) > len(whole.index) - 8


def test_messages_that_nobody_here_knows_are_named_and_kept_out_of_the_way(opened):
    foreign = bytearray(Encoder(1, 1).encode(Heartbeat(Health.ACTIVE, 0)))
    foreign[7:10] = (48_000).to_bytes(3, "little")
    flight = opened(log_of([bytes(foreign)] * 3 + frames() + [bytes(foreign)]))
    assert "messages of another dialect: 48000 x 4" in flight.notes
    assert len(flight.index) == 114


def test_a_log_without_us_says_whose_it_is(opened):
    (note,) = opened(log_of(vehicle_frames(system=7))).notes
    begin, names = note.rsplit(": ", 1)
    assert begin == "no messages of a payload: this is a log of system 7"
    assert set(names.split(", ")) == {"HEARTBEAT x 10", "ATTITUDE x 10", "GLOBAL_POSITION_INT x 10"}


def test_a_clock_that_is_set_back_or_ahead_leaves_no_hole(opened):
    ours = frames(2)
    early, late = log_of(ours[:11], start=5_000_000), log_of(ours[11:])
    flight = opened(early + late)
    assert flight.duration == pytest.approx(0.2)
    assert flight.start == pytest.approx(UNIX / 1e6 - 0.1)
    assert flight.notes == ("the clock of the log jumped once: the jumps are left out",)


def test_one_absurd_stamp_moves_nothing_else(opened):
    log = bytearray(log_of(frames(2)))
    second = 8 + len(frames(1)[0])
    log[second : second + 8] = (2**63 + 5).to_bytes(8, "big")
    flight = opened(bytes(log))
    assert flight.start == UNIX / 1e6
    assert flight.duration == pytest.approx(0.21)
    assert np.all(np.diff(flight.at) >= 0)


def test_a_log_that_grows_is_read_as_far_as_it_was(tmp_path):
    path, log = tmp_path / "growing.tlog", log_of(frames(2))
    path.write_bytes(log[: len(log) // 2])
    early = open_flight(path)
    with path.open("ab") as file:
        file.write(log[len(log) // 2 :])
    assert len(list(early.packets(np.arange(len(early.index))))) == len(early.index)
    assert len(open_flight(path).index) == 22 > len(early.index)


def test_a_log_that_shrinks_under_the_reader_ends_early(tmp_path):
    path = tmp_path / "shrinking.tlog"
    path.write_bytes(log_of(frames(2)))
    flight = open_flight(path)
    os.truncate(path, 500)
    assert 0 < len(list(flight.packets(np.arange(22)))) < 22


@pytest.mark.soak
def test_mavlogdump_reads_as_many_of_every_message(opened, tmp_path):
    mixed = [*frames(4), *vehicle_frames(), *frames(2, component=192)]
    flight = opened(log_of(mixed))
    command = [sys.executable, "-c", MAVLOGDUMP, "--dialect", "ross", "--format", "json", flight.path]
    told = subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, "MAVLINK20": "1"})
    theirs = [json.loads(line)["meta"]["type"] for line in told.stdout.splitlines() if line.startswith("{")]
    ours = {}
    for tally in tallies(flight).values():
        for kind in tally.kinds:
            ours[kind.name] = ours.get(kind.name, 0) + kind.count
    assert ours == {name: theirs.count(name) for name in set(theirs)}


BASE = log_of([*frames(2), *vehicle_frames(steps=3), *frames(1, key=bytes(32))])

CHANGES = st.lists(
    st.tuples(st.sampled_from(["flip", "drop", "insert", "double"]), st.integers(0, len(BASE)), st.binary(max_size=40)),
    max_size=6,
)


def changed(data, changes):
    for kind, place, octets in changes:
        here, there = data[:place], data[place:]
        if kind == "flip":
            data = here + bytes(a ^ b for a, b in zip(there, octets, strict=False)) + there[len(octets) :]
        elif kind == "drop":
            data = here + there[len(octets) :]
        else:
            data = here + octets + (there if kind == "insert" else data)
    return data


@settings(max_examples=examples(150))
@given(changes=CHANGES, end=st.integers(0, 2 * len(BASE)))
def test_no_damage_raises_anything_else_or_is_read_as_a_message(tmp_path_factory, changes, end):
    path = tmp_path_factory.getbasetemp() / "mutated.tlog"
    data = changed(BASE, changes)[:end]
    path.write_bytes(data)
    try:
        flight = open_flight(path)
    except GroundError:
        return
    assert np.all(np.diff(flight.at) >= 0)
    assert int((flight.index.size.astype(int) + 8).sum()) <= len(data)
    found = [packet.frame for _, packet in flight.packets(np.arange(len(flight.index)))]
    assert all(any(Decoder().feed(frame)) for frame in found)


@settings(max_examples=examples(30))
@given(data=st.binary(min_size=1, max_size=4000))
def test_noise_is_no_log(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "noise.tlog"
    path.write_bytes(data)
    with pytest.raises(GroundError):
        open_flight(path)
