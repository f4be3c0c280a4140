"""Bytes and words of CANopen and CiA 402: what must hold for every value."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import Homing, State, controlword, homing_of
from ross_protocols.canopen.cia402 import state_of as drive_state
from ross_protocols.canopen.eds import data_sheet, entries_of
from ross_protocols.canopen.error_texts import ABORTS, EMERGENCIES, abort_words, emergency_words
from ross_protocols.canopen.frames import (
    Emergency,
    Item,
    NmtState,
    emergency_of,
    heartbeat,
    mapped,
    packed,
    state_of,
    unpacked,
)
from ross_protocols.canopen.sdo import Abort, Read, Value, Write, Written, reply, reply_of, request, request_of

# The state machine of CiA 402 as figure 7 of the standard has it: controlword bits (mask, value) of every transition.
SHUTDOWN, SWITCH_ON, ENABLE = (0x87, 0x06), (0x8F, 0x07), (0x8F, 0x0F)
NO_VOLTAGE, QUICK_STOP = (0x82, 0x00), (0x86, 0x02)
TRANSITIONS = [
    (State.SWITCH_ON_DISABLED, SHUTDOWN, State.READY_TO_SWITCH_ON),
    (State.READY_TO_SWITCH_ON, SWITCH_ON, State.SWITCHED_ON),
    (State.READY_TO_SWITCH_ON, NO_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.SWITCHED_ON, ENABLE, State.OPERATION_ENABLED),
    (State.SWITCHED_ON, NO_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.OPERATION_ENABLED, NO_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.OPERATION_ENABLED, QUICK_STOP, State.QUICK_STOP_ACTIVE),
    (State.QUICK_STOP_ACTIVE, NO_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.FAULT, (0x80, 0x80), State.SWITCH_ON_DISABLED),
]
ALIVE = [state for state in State if state not in (State.NOT_READY, State.FAULT_REACTION)]
index, sub = st.integers(0, 0xFFFF), st.integers(0, 0xFF)
short = st.binary(min_size=1, max_size=4)


def after(state, word):
    return next(
        (end for begin, (mask, bits), end in TRANSITIONS if begin is state and word & mask == bits),
        state,
    )


def path(state, wanted, steps=5):
    states = [state]
    for _ in range(steps):
        states.append(after(states[-1], controlword(states[-1].bits, wanted)))
    return states


@pytest.mark.parametrize("state", [each for each in ALIVE if each not in (State.FAULT, State.QUICK_STOP_ACTIVE)])
def test_every_healthy_state_leads_to_operation_enabled_in_three_steps(state):
    assert path(state, State.OPERATION_ENABLED)[3] is State.OPERATION_ENABLED


def test_a_quick_stop_is_left_through_switch_on_disabled_only():
    states = path(State.QUICK_STOP_ACTIVE, State.OPERATION_ENABLED)
    assert states[1] is State.SWITCH_ON_DISABLED
    assert states[4] is State.OPERATION_ENABLED


@pytest.mark.parametrize("wanted", [State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE, State.SWITCH_ON_DISABLED])
def test_no_wish_resets_a_fault(wanted):
    assert path(State.FAULT, wanted) == [State.FAULT] * 6
    assert controlword(State.FAULT.bits, wanted) & cia402.FAULT_RESET == 0


def test_after_its_reset_a_drive_is_disabled():
    assert after(State.FAULT, cia402.FAULT_RESET) is State.SWITCH_ON_DISABLED


@pytest.mark.parametrize("state", ALIVE)
def test_whoever_wants_a_quick_stop_enables_nothing(state):
    assert State.OPERATION_ENABLED not in path(state, State.QUICK_STOP_ACTIVE)[1:]
    assert State.SWITCHED_ON not in path(state, State.QUICK_STOP_ACTIVE)[1:]


@given(status=st.integers(0, 0xFFFF))
def test_a_statusword_is_of_one_state_at_most_and_the_rest_of_its_bits_do_not_matter(status):
    found = [state for state in State if status & state.value[0] == state.value[1]]
    assert len(found) <= 1
    assert drive_state(status) is (found[0] if found else None)
    assert drive_state(status) is drive_state(status ^ 0x1290)


@given(status=st.integers(0, 0xFFFF), wanted=st.sampled_from(State))
def test_a_statusword_that_nobody_understands_gets_no_voltage(status, wanted):
    if drive_state(status) is None:
        assert controlword(status, wanted) == 0


@pytest.mark.parametrize(
    ("status", "homing"),
    [(0x0237, Homing.RUNNING), (0x1237, Homing.RUNNING), (0x1637, Homing.DONE), (0x3637, Homing.FAILED)],
)
def test_home_is_found_only_when_it_is_reached_and_no_error_is_told(status, homing):
    assert homing_of(status) is homing


@given(index=index, sub=sub, data=short)
def test_reads_and_writes_come_back_as_they_were_sent(index, sub, data):
    for asked in (Read(index, sub), Write(index, sub, data)):
        frame = request(5, asked)
        assert (frame.id, len(frame.data), frame.extended) == (0x605, 8, False)
        assert request_of(frame.data) == asked


@given(index=index, sub=sub, data=short, code=st.integers(0, 2**32 - 1))
def test_answers_come_back_as_they_were_sent(index, sub, data, code):
    for answer in (Value(index, sub, data), Written(index, sub), Abort(index, sub, code)):
        frame = reply(5, answer)
        assert (frame.id, len(frame.data)) == (0x585, 8)
        assert reply_of(frame.data) == answer


@given(data=st.binary(max_size=8))
def test_any_bytes_are_an_answer_or_none(data):
    assert reply_of(data) is None or len(data) == 8
    assert request_of(data) is None or len(data) == 8
    assert emergency_of(data) is None or len(data) == 8
    assert state_of(data) is None or len(data) == 1


def test_frames_are_those_of_the_standard():
    assert request(5, Write(0x1017, 0, struct.pack("<H", 100))).data.hex() == "2b17100064000000"
    assert reply(5, Abort(0x1000, 0, 0x06010002)).data.hex() == "8000100002000106"
    assert heartbeat(5, NmtState.BOOT_UP).data == b"\0"


@given(values=st.tuples(st.integers(0, 0xFFFF), st.integers(-(2**31), 2**31 - 1), st.integers(-128, 127)))
def test_process_data_come_back_as_they_were_sent(values):
    items = (cia402.CONTROLWORD, cia402.TARGET, cia402.MODE)
    data = packed(items, values)
    assert unpacked(items, data) == list(values)
    assert unpacked(items, data[:-1]) is None


@given(index=index, sub=sub, kind=st.sampled_from("bBhHiI"))
def test_a_mapping_names_entry_and_length(index, sub, kind):
    item = Item(index, sub, kind)
    assert mapped(item.mapping) == (index, sub, item.size)


@given(code=st.integers(0, 0xFFFF), register=st.integers(0, 255), vendor=st.binary(min_size=5, max_size=5))
def test_emergencies_come_back_and_every_code_has_words(code, register, vendor):
    emergency = Emergency(code, register, vendor)
    assert emergency_of(emergency.frame(5).data) == emergency
    assert emergency_words(code)
    assert f"0x{code:04X}" in str(emergency)


def test_words_of_codes_are_those_of_their_group():
    assert all(emergency_words(code) == words for code, words in EMERGENCIES.items())
    assert all(abort_words(code) == words for code, words in ABORTS.items())
    assert emergency_words(0x0001) == "unknown error"
    assert emergency_words(0x8612) != emergency_words(0x8611)


def test_our_data_sheet_has_every_object_that_the_drive_is_driven_by():
    entries = entries_of(data_sheet("ross_drive"), node=5)
    items = [item for item in vars(cia402).values() if isinstance(item, Item)]
    assert len(items) > 25
    for item in items:
        assert entries[item.index, item.sub].item == item


def test_the_data_sheet_s_identifiers_follow_the_node():
    assert entries_of(data_sheet("ross_drive"), node=9)[0x1800, 1].default == 0x189
