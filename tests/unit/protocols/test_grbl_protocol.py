"""The lines of grbl 1.1: every documented form is read, nothing else is taken for one, nothing breaks the reader."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ross_protocols.grbl.error_texts import ALARMS, ERRORS
from ross_protocols.grbl.protocol import (
    LONGEST,
    Alarm,
    Banner,
    Error,
    Garbage,
    Info,
    Lines,
    Ok,
    Report,
    Setting,
    State,
    jog,
    read,
)


def degrees(angles):
    return tuple(round(math.degrees(angle), 3) for angle in angles)


def test_a_full_report_is_read():
    report = read(b"<Hold:0|MPos:-12.250,0.000,5.000|Bf:15,128|FS:600,8000|Pn:XPH|WCO:1.000,0.000,0.000|Ov:100,50,10>")
    assert (report.state, report.substate) == (State.HOLD, 0)
    assert degrees(report.machine) == (-12.25, 0.0, 5.0)
    assert report.work is None
    assert degrees(report.offset) == (1.0, 0.0, 0.0)
    assert report.speed == pytest.approx(math.radians(10))
    assert (report.buffers, report.pins, report.overrides) == ((15, 128), "XPH", (100, 50, 10))


def test_a_report_of_a_work_position_has_no_machine_position():
    report = read(b"<Idle|WPos:1.000,2.000,3.000|F:0>")
    assert report.machine is None
    assert degrees(report.work) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("state", [*State])
def test_every_state_is_known(state):
    assert read(f"<{state}|MPos:0.000|FS:0,0>".encode()).state is state


@pytest.mark.parametrize(
    ("doing", "words"),
    [("Hold:1", "coming to a hold"), ("Door:0", "ready to resume"), ("Door:1", "the door is open"), ("Jog", "Jog")],
)
def test_a_substate_has_words(doing, words):
    assert words in read(f"<{doing}|MPos:0.000|FS:0,0>".encode()).doing


@pytest.mark.parametrize("number", [*ERRORS])
def test_every_error_has_words(number):
    error = read(f"error:{number}".encode())
    assert error == Error(number)
    assert error.words.startswith(f"error {number}: ")


@pytest.mark.parametrize("number", [*ALARMS])
def test_every_alarm_has_words(number):
    alarm = read(f"ALARM:{number}".encode())
    assert alarm == Alarm(number)
    assert alarm.words.startswith(f"alarm {number}: ")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b"ok", Ok()),
        (b"Grbl 1.1h ['$' for help]", Banner("1.1h")),
        (b"GrblHAL 1.1f ['$' or '$HELP' for help]", Banner("1.1f")),
        (b"Grbl 3.7 [FluidNC v3.7.8 (noradio) '$' for help]", Banner("3.7")),
        (b"$100=8.889", Setting(100, 8.889)),
        (b"$0=10 (step pulse, usec)", Setting(0, 10.0)),
        (b"[VER:1.1h.20190825:]", Info("VER", "1.1h.20190825:")),
        (b"[MSG:Caution: Unlocked]", Info("MSG", "Caution: Unlocked")),
    ],
)
def test_lines_are_read(line, message):
    assert read(line) == message


@pytest.mark.parametrize(
    "line",
    [
        b"okok",
        b"error:",
        b"error:15x",
        b"<Idle|MPos:1.0.0|FS:0,0>",
        b"<Idle|MPos:nan|FS:0,0>",
        b"<Idle|MPos:1e9|FS:0,0>",
        b"<Idle|FS:0,0>",
        b"<Idle|MPos:1.000|WPos:1.000>",
        b"<Idle|MPos:1.000|MPos:2.000>",
        b"<Jump|MPos:1.000|FS:0,0>",
        b"<Idle|MPos:1.000|FS:0,0",
        b"Idle|MPos:1.000|FS:0,0>",
        b"$100=abc",
        b"\xff\xfe",
        b"ok\x01",
    ],
)
def test_anything_else_is_garbage(line):
    assert isinstance(read(line), Garbage)


@given(st.binary(max_size=400))
def test_no_bytes_break_the_reader_and_what_follows_is_read(data):
    lines = Lines()
    lines.feed(data)
    assert lines.feed(b"\nok\n")[-1] == Ok()


@given(
    st.lists(st.sampled_from([b"ok", b"error:9", b"<Idle|MPos:1.000,0.000|FS:0,0>", b"$1=255"]), max_size=8), st.data()
)
def test_pieces_of_any_size_give_the_same_messages(sent, data):
    whole = b"".join(line + b"\r\n" for line in sent)
    lines, got = Lines(), []
    while whole:
        n = data.draw(st.integers(1, len(whole)))
        got += lines.feed(whole[:n])
        whole = whole[n:]
    assert got == [read(line) for line in sent]


def test_a_line_without_end_is_garbage_once_and_is_not_kept():
    lines = Lines()
    got = [message for _ in range(100) for message in lines.feed(b"x" * LONGEST)]
    assert len(got) == 1
    assert isinstance(got[0], Garbage)
    assert lines.feed(b"tail of it\nok\n") == [Ok()]


@given(st.floats(-30, 30), st.floats(0.01, 10))
def test_a_jog_names_its_goal_to_a_ten_thousandth_of_a_degree(goal, speed):
    text = jog("A", goal, speed).decode()
    assert text.startswith("$J=G90G21G53A")
    assert len(text) <= 80
    place, rate = text.removeprefix("$J=G90G21G53A").split("F")
    assert float(place) == pytest.approx(math.degrees(goal), abs=0.6e-4)
    assert float(rate) == pytest.approx(math.degrees(speed) * 60, abs=0.06)


def test_a_report_that_grbl_may_send_is_a_report():
    assert isinstance(read(b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>"), Report)
