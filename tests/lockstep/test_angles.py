"""One mission, one convention: everything that people read counts degrees as a compass does, from the same zero."""

import io
import json
import logging
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from examples import in_soak
from ross_payload.events import Slipped, SourcesEstimated, TurnStarted
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.flights.plot import figure_of as flight_figure
from ross_payload.ground.flights.reading import open_flight
from ross_payload.ground.flights.summary import FlightContent, summary
from ross_payload.ground.flights.table import show as show_flight
from ross_payload.ground.mavproxy.shell import Shell
from ross_payload.ground.model.view import view
from ross_payload.ground.terminal import blocks
from ross_payload.ground.terminal.change_log import ChangeLog
from ross_payload.logs import LogObserver, Text, words
from ross_payload.service.replay import in_words as replay_in_words
from ross_payload.service.replay import perform as perform_replay
from ross_payload.telemetry.status_texts import line
from ross_protocols.mavlink.commands import direction
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_sim.scenario import load
from ross_sim.sitl.mission_figure import figure_of as mission_figure
from ross_sim.sitl.mission_session import perform
from ross_sim.sitl.mission_view import LiveView, PlainLines, in_words
from ross_sim.sitl.report import EventLog, Truth
from ross_sim.sitl.results_folder import ResultsFolder
from ross_sim.sitl.summary import show
from ross_sim.sitl.talker_selection import talkers_of
from short_mission import SHORT

pytestmark = pytest.mark.usefixtures("undrawn")

TALKERS = (40.0, 155.0, -80.0)  # of SHORT, counter-clockwise
FRAMES = {"from the nose": "", "from north": "[payload.mount]\nyaw_deg = 30\n"}
NORTH = {"from the nose": 0.0, "from north": 30.0}  # compass degrees of the payload's nose
ERROR = 3.0  # of a short mission [deg]
ROUNDING = 0.51  # of whole degrees
NUMBERS = r"-?\d+(?:\.\d+)?"


@dataclass
class Eyes:
    """Looks at a mission in every way that a terminal offers, and keeps its story."""

    stream: io.StringIO = field(default_factory=io.StringIO)
    live: io.StringIO = field(default_factory=io.StringIO)
    log: io.StringIO = field(default_factory=io.StringIO)
    event_log: EventLog = field(default_factory=EventLog)

    def __post_init__(self):
        self.lines = PlainLines(Console(file=self.stream, width=200))
        self.view = LiveView(Console(file=self.live, force_terminal=True, width=120, height=40), expected=10.0)
        handler = logging.StreamHandler(self.log)
        handler.setFormatter(Text(journal=False))
        self.logger = logging.getLogger("ross_payload.mission")
        self.logger.addHandler(handler)
        self.handler, self.before = handler, self.logger.level
        self.logger.setLevel(logging.INFO)

    def on_input(self, heard):
        self.view.on_input(heard)

    def on_event(self, event, heard):
        for each in (self.lines, self.view, LogObserver()):
            each.on_event(event, heard)
        self.event_log.events.append(event)
        self.event_log.earth = heard.pointing.earth

    def close(self):
        self.view.close()
        self.logger.removeHandler(self.handler)
        self.logger.setLevel(self.before)


@dataclass
class Flown:
    """A mission, and what was seen of it."""

    frame: str
    eyes: Eyes
    summary: str
    report: dict
    out: Path
    session: Path

    @property
    def north(self):
        return NORTH[self.frame]

    @property
    def earth(self):
        return self.frame == "from north"

    @property
    def azimuths(self):
        """Of the sources as the report has them, turned around here by hand [deg of a compass]."""
        return [-source["azimuth_deg"] % 360 for source in self.report["sources"]]

    @property
    def heading(self):
        return -self.report["alignment"]["used"]["heading_deg"] % 360

    @property
    def told(self):
        flight = open_flight(self.out / "mission.tlog")
        return FlightContent(flight, flight.payloads)


@pytest.fixture(scope="module", params=["from north", *in_soak("from the nose")])
def flown(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("flown")
    (folder / "short.toml").write_text(SHORT + FRAMES[request.param])
    scenario, eyes, out = load(str(folder / "short.toml")), Eyes(), folder / "out"
    try:
        with ResultsFolder(out) as written:
            finished = perform(scenario, talkers_of(scenario, None, None), eyes, written, None, record=folder / "tape")
    finally:
        eyes.close()
    printed = io.StringIO()
    show(finished, out, as_json=False, console=Console(file=printed, width=80))
    report = json.loads((out / "report.json").read_text())
    session = next(path.parent for path in sorted((folder / "tape").rglob("session.json")))
    return Flown(request.param, eyes, printed.getvalue(), report, out, session)


def same(ours, theirs, within=ROUNDING):
    """Whether directions are the same, in the same order."""
    assert len(ours) == len(theirs), (ours, theirs)
    apart = [abs((one - other + 180) % 360 - 180) for one, other in zip(ours, theirs, strict=True)]
    assert max(apart) <= within, (ours, theirs)


def numbers(pattern, text):
    """All numbers in the groups of the last match of a pattern."""
    match = list(re.finditer(pattern, text))[-1]
    return [float(number) for group in match.groups() for number in re.findall(NUMBERS, group)]


def column(table, header):
    """The numbers in the first column of that name in drawn tables."""
    drawn = (part.splitlines()[1:] for part in table.split("┏")[1:])
    heads, *body = next(rows for rows in drawn if header in [name.strip() for name in rows[0].split("┃")])
    place = [name.strip() for name in heads.split("┃")].index(header)
    rows = [row.split("│") for row in body if row.startswith("│")]
    return [float(cells[place]) for cells in rows]


def test_the_report_is_where_the_talkers_are_and_names_its_frame(flown):
    talkers = [(flown.north - azimuth) % 360 for azimuth in TALKERS]
    same(sorted(flown.azimuths), sorted(talkers), ERROR)
    assert flown.report["frame"] == ("earth" if flown.earth else "mount")


def test_the_lines_of_the_terminal_say_it(flown):
    said = flown.eyes.stream.getvalue()
    same(numbers(rf"K = 3 at (.*) deg {flown.frame}", said), flown.azimuths)
    assert numbers(rf"turning to (.*) deg {flown.frame}: alignment", said) == pytest.approx([flown.heading], abs=0.06)
    assert re.search(rf"headings to try, {flown.frame}: .*\b{flown.heading:.1f} deg for source", said)


def test_the_live_view_of_the_terminal_says_it(flown):
    drawn = re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", flown.eyes.live.getvalue())
    same(numbers(rf"heading +({NUMBERS}) deg {flown.frame}", drawn), [flown.heading], 1.0)
    same([float(found) for found in re.findall(rf"\d +({NUMBERS}) deg +{NUMBERS} +", drawn)[-3:]], flown.azimuths)


def test_the_table_of_the_terminal_says_it(flown):
    same(column(flown.summary, "found"), flown.azimuths)
    true = [-source["azimuth_true_deg"] % 360 for source in flown.report["sources"]]
    same(column(flown.summary, "true"), true)
    errors = [-source["azimuth_error_deg"] for source in flown.report["sources"]]
    assert column(flown.summary, "error") == pytest.approx(errors, abs=0.006)
    assert f"azimuths in degrees, clockwise {flown.frame}" in flown.summary
    assert f"aligned at heading {flown.heading:.1f} deg {flown.frame}" in flown.summary


def test_no_line_of_the_table_is_wider_than_80_columns_and_no_word_is_cut(flown):
    tables = [line for line in flown.summary.splitlines() if line.startswith(("│", "┃", "┏"))]
    assert max(map(len, tables)) <= 80
    assert "…" not in flown.summary
    assert "confidence" in flown.summary


def test_the_log_says_it(flown):
    turns = [event for event in flown.eyes.event_log.events if isinstance(event, TurnStarted)]
    said = re.findall(rf"turning to heading ({NUMBERS}) deg {flown.frame}, joint", flown.eyes.log.getvalue())
    assert [float(each) for each in said] == pytest.approx([-np.rad2deg(t.heading) % 360 for t in turns], abs=0.06)
    assert numbers(rf"separated .* at heading ({NUMBERS}) deg {flown.frame}", flown.eyes.log.getvalue()) == (
        pytest.approx([flown.heading], abs=1.0)
    )


def test_both_pictures_are_compasses_and_have_the_sources_in_the_same_place(flown):
    truth = Truth(
        names=tuple(source["name"] for source in flown.report["sources"]),
        azimuths=np.deg2rad([source["azimuth_true_deg"] for source in flown.report["sources"]]),
        elevations=np.zeros(3),
        images=np.zeros((3, 1), np.float32),
        mixture=np.ones(16000 * 60, np.float32),
        target=flown.report["target"],
    )
    mission = mission_figure(flown.eyes.event_log, truth, rate=16000, unit=0.05 / 343, title="")
    flight = flight_figure(flown.told)
    for figure in (mission, flight):
        rose = next(axes for axes in all_axes(figure) if axes.name == "polar")
        assert rose.get_theta_offset() == pytest.approx(np.pi / 2)  # 0 is at the top
        assert rose.get_theta_direction() == -1  # clockwise
        assert rose.get_title().endswith(f"degrees clockwise {flown.frame}")
        assert [label.get_text() for label in rose.get_xticklabels()] == [f"{angle}" for angle in range(0, 360, 45)]
        same([np.rad2deg(wedge.get_x() + wedge.get_width() / 2) for wedge in rose.patches], flown.azimuths)
    isolation = next(axes for axes in all_axes(mission) if axes.get_title().startswith("where to turn"))
    upright = next(drawn for drawn in isolation.lines if drawn.get_label() == "array")
    assert upright.get_xdata()[0] == pytest.approx(flown.heading % 180, abs=0.06)


def all_axes(figure):
    return [axes for part in (figure, *figure.subfigs) for axes in part.axes]


def test_a_picture_turns_with_the_headings_that_it_draws(flown):
    """The densities are drawn at their headings, and the ticks name them as a compass does."""
    truth = Truth((), np.zeros(0), np.zeros(0), np.zeros((0, 1), np.float32), np.ones(16000 * 60, np.float32), "")
    figure = mission_figure(flown.eyes.event_log, truth, rate=16000, unit=0.05 / 343, title="")
    densities = next(axes for axes in figure.axes if axes.get_title().startswith("heard"))
    assert densities.get_ylabel() == f"heading {flown.frame} [deg]"
    levels = [drawn.get_paths()[0].vertices[:, 1].min() for drawn in densities.collections]
    steps = [event.heading for event in flown.eyes.event_log.events if type(event).__name__ == "OrientationHeard"]
    same(levels, [-np.rad2deg(heading) % 360 for heading in steps], 0.1)
    assert densities.yaxis.get_major_formatter()(-15.0, 0) == "345"


def test_the_table_of_the_telemetry_log_says_it(flown):
    printed = io.StringIO()
    show_flight(summary(flown.told), Console(file=printed, width=120))
    table = printed.getvalue()
    same(column(table, "azimuth [deg]"), flown.azimuths)
    assert any(heading == pytest.approx(flown.heading, abs=0.1) for heading in column(table, "heading [deg]"))
    assert f"angles clockwise {flown.frame}" in table


def ground(flown):
    """A prompt with everything that was said on the way, and what it answered."""
    answers = []
    sent = []
    shell = Shell(CommandProtocol(lambda message, who: sent.append(message), 255, 190), answers.append)
    for at, packet in packets(flown):
        shell.on_packet(packet, at)
    return shell, answers, sent


def packets(flown):
    flight = open_flight(flown.out / "mission.tlog")
    return flight.packets(np.arange(len(flight.index)))


def test_the_page_the_monitor_and_the_prompt_of_mavproxy_say_it(flown):
    shell, answers, _ = ground(flown)
    picture = view(shell.fleet.payloads[ComponentId(1, 191)])
    same([source["azimuth"] for source in picture["sources"]], flown.azimuths)
    same([picture["pointing"]["heading"]], [flown.heading], 1.0)
    assert picture["pointing"]["earth"] is flown.earth
    shell.execute(["status"])
    assert re.search(rf"axis {picture['pointing']['heading']:.1f} deg, {flown.frame}", "\n".join(answers))
    answers.clear()
    shell.execute(["sources"])
    same([float(answer.split()[1]) for answer in answers[1:4]], flown.azimuths)
    assert answers[1:4] == [text.plain for text in blocks.sources(picture, chosen=None)[1:4]]
    told = next(text for text in ChangeLog().words(picture) if text.startswith("sources"))
    same([float(azimuth) for azimuth in re.findall(rf"at ({NUMBERS})", told)], flown.azimuths)
    assert told.endswith(flown.frame)


def test_stations_without_our_dialect_read_it(flown):
    said = [packet for _, packet in packets(flown)]
    arrays = [packet.message for packet in said if packet.name == "DEBUG_FLOAT_ARRAY"]
    same(list(arrays[-1].data[1:4]), flown.azimuths)
    named = [packet.message for packet in said if packet.name == "NAMED_VALUE_FLOAT"]
    headings = [message.value for message in named if message.name.startswith("ross_head")]
    same(headings[-1:], [flown.heading], 1.0)


@pytest.mark.soak
def test_a_replay_says_it(flown):
    said = "\n".join(replay_in_words(perform_replay(flown.session, None, None, ())))
    same(numbers(rf"sources: (.*) deg {flown.frame}", said), flown.azimuths)


def test_a_turn_that_is_ordered_in_degrees_of_the_page_is_one_to_that_heading(flown):
    shell, _, sent = ground(flown)
    shell.execute(["turn", f"{flown.heading:.1f}"])
    ordered = next(message for message in sent if message.command == ross.MAV_CMD_ROSS_TURN)
    assert -np.rad2deg(direction(ordered.param1)) % 360 == pytest.approx(flown.heading, abs=0.06)


def test_a_slip_has_the_same_sense_for_the_pilot_the_log_and_the_terminal():
    slipped = Slipped(1.0, shift=np.deg2rad(-12.0))
    for said in (line(slipped)[1], words(slipped, earth=True)[1], in_words(slipped, earth=True)):
        assert re.search(r"all azimuths shifted by 12(\.0)? deg clockwise", said)


def test_the_events_say_no_angle_in_their_texts(flown):
    """What is written into events.jsonl is read by machines in radians; no sentence in it has a second convention."""
    events = [json.loads(each) for each in (flown.out / "events.jsonl").read_text().splitlines()]
    texts = [value for event in events for value in event.values() if isinstance(value, str)]
    assert not [text for text in texts if re.search(r"\d deg", text)]
    estimated = [event for event in events if event["event"] == SourcesEstimated.__name__][-1]
    same([-np.rad2deg(source["azimuth"]) % 360 for source in estimated["estimate"]["sources"]], flown.azimuths)
