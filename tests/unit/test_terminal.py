"""At 80 columns no table and no list cuts a word."""

import re

import pytest
from rich.console import Console
from rich.table import Table

from ross_payload.audio.command import table as devices_table
from ross_payload.audio.sound_devices import Device
from ross_payload.evaluation.results import _table as evaluation_table
from ross_payload.terminal_tables import listed, with_whole_words
from ross_sim.sitl.summary import _groups, _sources
from ross_sim.study.rows.tables import Table as StudyTable

NAMES = ("arthur", "bella", "cedric", "dora", "edgar")
SOURCES = {
    "informed": False, "rotations": 12, "k": 5, "k_true": 5, "target": "cedric", "frame": "mount",
    "sources": [
        {"name": name, "azimuth_true_deg": -170.0, "azimuth_deg": -169.9, "azimuth_error_deg": 0.12, "sigma_deg": 12.34,
         "confidence": 0.99, "elevation_true_deg": 0.0, "elevation_deg": None, "front_back_resolved": True}
        for name in NAMES
    ],
}  # fmt: skip
GROUPS = {
    "target": "cedric",
    "groups": [
        {"separator": "fastmnmf2", "why": "directions known, 3 groups, not two", "talkers": [*names], "score": -12.3,
         "si_sdr_db": -10.1, "si_sdri_db": 20.2, "target": "cedric" in names}
        for names in (NAMES[:2], NAMES[2:3], NAMES[3:])
    ],
}  # fmt: skip
EVALUATION = {
    "separator": "gaussian", "why": "", "azimuths_deg": [170.0, 70.0, -50.0], "tdoas_us": [-143.6, 49.9, 93.7],
    "si_sdr_in_db": -12.3,
    "groups": [
        {"dbfs": -40.1, "si_sdr_db": -11.1, "si_sdri_db": 12.2, "best": True, "sources": [0, 2]},
        {"dbfs": -40.1, "si_sdr_db": -11.1, "si_sdri_db": 12.2, "best": False, "sources": [1]},
    ],
}  # fmt: skip
STUDY = StudyTable(
    "Mean SI-SDRi", ("", "duet", "auxiva", "gaussian", "refined", "fastmnmf2"),
    (("S1, K = 3", *["16.0 / 14.9 / 14.03 / -5.1"] * 5), ("reverberation", *["16.0 / 14.9 / 14.03 / -5.1"] * 5)),
)  # fmt: skip
DEVICES = [Device(0, "ReSpeaker 4 Mic Array (UAC1.0): USB Audio (hw:1,0)", "ALSA", 6, 16000.0, "respeaker-usb")]

TABLES = {
    "sitl sources": lambda: _sources(SOURCES),
    "sitl groups": lambda: _groups(GROUPS),
    "evaluate": lambda: evaluation_table(EVALUATION),
    "study": STUDY.screen,
    "devices": lambda: devices_table(DEVICES),
}


def drawn(table, width=80):
    console = Console(width=width, no_color=True)
    with console.capture() as capture:
        console.print(table)
    return capture.get()


def words_of(table):
    texts = [str(cell) for column in table.columns for cell in (column.header, *column.cells)]
    return {word for text in texts for word in re.sub(r"\\\[|\[/?[a-z ]+\]", "[", text).split()}


@pytest.mark.parametrize("make", TABLES.values(), ids=TABLES)
def test_a_table_cuts_no_word_at_80_columns(make):
    table = make()
    shown = drawn(table)
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= 80
    assert [word for word in words_of(table) if word.isalpha() and word not in shown] == []


def test_without_the_width_of_words_a_column_would_be_cut():
    header = ("source", "a talker", "true [deg]", "found [deg]", "error [deg]", "sigma [deg]", "confidence")
    table = Table(*(text.replace("[", r"\[") for text in header))
    table.add_row("0", "arthur (target)", *["-170.0"] * 5)
    assert "…" in drawn(table, 76)
    assert "…" not in drawn(with_whole_words(table), 76)


def test_a_list_continues_below_its_text():
    lines = listed(f"{'tb6600':<16} {'usable':<11} ", "Stepper motor behind a TB6600 module: " * 3, 80).splitlines()
    assert len(lines) > 1
    assert all(len(line) <= 80 for line in lines)
    assert all(line.startswith(" " * 29) for line in lines[1:])


def test_a_list_on_a_pipe_has_one_line_for_each_row():
    assert "\n" not in listed("head ", "words " * 100)


def test_the_flight_table_cuts_no_word():
    from ross_payload.ground.flights.table import _table

    rows = [["39.0 s", "check", "fastmnmf2", "0", "0, 1, 2", "-10.5", "-100.0", "target"]]
    columns = ("at", "phase", "method", "group", "sources", "score", "criterion", "is")
    screen = Console(width=80, no_color=True)
    with screen.capture() as capture:
        _table(screen, "Separations", columns, rows, 1)
    assert all(word in capture.get() for word in [*columns, "fastmnmf2"])
    assert "…" not in capture.get()
