"""What the terminal shows of a payload, at any size."""

import math
from dataclasses import replace

import pytest
from rich.cells import cell_len
from rich.console import Console, Group

from emulated_scene import full
from fleet_ear import status
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_types import Stop, Turn
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.view import view
from ross_payload.ground.terminal import blocks
from ross_payload.ground.terminal.blocks import clean
from ross_payload.ground.terminal.polar_plot import polar_plot
from ross_payload.ground.terminal.screen import ScreenState, compose
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.values import Information, Severity, Source, Status, Text

SIZES = [(80, 24), (200, 60), (60, 20), (40, 12), (20, 6), (10, 2)]
NOTHING = {
    "pointing": {"earth": True, "heading": None, "goal": None, "limits": None, "mount_yaw": None},
    "sources": [],
    "plan": {"current": None, "candidates": []},
}
SOURCE = {"source": 0, "azimuth": 0.0, "mirror": None, "sigma": 5.0, "target": False, "trail": []}


def known(*said, sources=3):
    """A payload that told everything at 30 s, and then this."""
    fleet, encoder, decoder = Fleet(), Encoder(1, 191), Decoder()
    for value in [*full(30.0, sources, 1), *said]:
        for packet in decoder.feed(encoder.encode(value)):
            fleet.on_packet(packet, at=100.0)
    return fleet.payloads[ComponentId(1, 191)]


def shown(*said, sources=3, now=100.5, **more):
    return ScreenState(view=clean(view(known(*said, sources=sources))), now=now, **more)


def text(*said, size=(80, 24), sources=3, now=100.5, braille=True, **more):
    lines = compose(shown(*said, sources=sources, now=now, **more), *size, braille=braille)
    return "\n".join(line.plain for line in lines)


def drawn(sections, columns=40, rows=20, **more):
    return [line.plain for line in polar_plot(NOTHING | sections, columns, rows, **more)]


def place(lines, label):
    """The angle [deg, clockwise from the top] and distance [rows] of a label from the middle."""
    row = next(index for index, line in enumerate(lines) if label in line)
    x, y = lines[row].index(label) + len(label) / 2 - len(lines[0]) / 2, len(lines) / 2 - (row + 0.5)
    return math.degrees(math.atan2(x / 2, y)) % 360, math.hypot(x / 2, y)


def apart(one, other):
    return abs((one - other + 180) % 360 - 180)


def dots(lines):
    return sum(
        (ord(letter) - 0x2800).bit_count() for line in lines for letter in line if 0x2800 <= ord(letter) < 0x2900
    )


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("sources", [0, 200])
@pytest.mark.parametrize("braille", [True, False])
def test_it_fills_any_screen_and_no_more(size, sources, braille):
    width, height = size
    lines = compose(shown(sources=sources), width, height, braille=braille)
    assert len(lines) == height
    assert max(cell_len(line.plain) for line in lines) <= width
    console = Console(width=width, height=height, record=True, file=None, force_terminal=True)
    with console.capture() as capture:
        console.print(Group(*lines), end="")
    assert len(capture.get().splitlines()) == height


def test_a_small_terminal_shows_all_that_matters():
    seen = text()
    assert "RoSS 1-191  RUN  last telemetry 0.5 s ago" in seen
    assert "K 3 final  target 1" in seen
    assert "axis " in seen and "from north" in seen
    assert "s STOP" in seen.splitlines()[-1]
    for part in (
        "microphones",
        "actuator",
        "reception",
        "processor",
        "recording",
        "source azimuth",
        "heading  isolates",
    ):
        assert part in seen


def test_a_large_one_shows_densities_isolation_and_groups():
    seen = text(size=(200, 60))
    assert "ITD density of each orientation, -146 to 146 us" in seen
    assert "isolation of each source" in seen
    assert "separated (run, gaussian)" in seen
    assert "o-O axis" in seen


@pytest.mark.parametrize("angle", range(0, 360, 30))
def test_the_axis_points_where_it_does_both_ways(angle):
    lines = drawn({"pointing": NOTHING["pointing"] | {"heading": float(angle)}})
    assert apart(place(lines, "O")[0], angle) < 12
    assert apart(place(lines, "o")[0], angle + 180) < 12


@pytest.mark.parametrize("angle", range(15, 360, 30))
def test_a_source_stands_where_it_is_and_at_its_mirror(angle):
    lines = drawn({"sources": [SOURCE | {"source": 7, "azimuth": float(angle), "mirror": angle + 100.0}]})
    assert apart(place(lines, "7?")[0], angle + 100) < 10
    assert apart(place([line.replace("7?", "  ") for line in lines], "7")[0], angle) < 10


def test_a_wedge_is_as_wide_as_the_source_is_uncertain():
    empty = dots(drawn({}))
    areas = [
        dots(drawn({"sources": [SOURCE | {"azimuth": 40.0, "sigma": sigma}]})) - empty for sigma in (5.0, 10.0, 20.0)
    ]
    assert areas[1] / areas[0] == pytest.approx(2, abs=0.5)
    assert areas[2] / areas[1] == pytest.approx(2, abs=0.3)


def test_the_target_is_marked():
    assert any("*0" in line for line in drawn({"sources": [SOURCE | {"target": True}]}))


@pytest.mark.parametrize("yaw", [0.0, 60.0, 200.0])
def test_the_nose_of_the_vehicle_is_where_it_points(yaw):
    lines = drawn({"pointing": NOTHING["pointing"] | {"heading": 90.0, "mount_yaw": yaw}})
    assert apart(place(lines, "V")[0], yaw) < 10


def test_the_goal_lies_on_the_ring():
    lines = drawn({"pointing": NOTHING["pointing"] | {"heading": 0.0, "goal": 135.0}})
    angle, distance = place(lines, "x")
    assert apart(angle, 135.0) < 10
    assert distance > 8


def test_no_direction_is_shown_as_360_degrees():
    north = math.radians(0.03)  # 359.97 degrees of a compass
    picture = text(status(30.1, heading=north, heading_goal=north), size=(200, 60))
    assert "axis 0.0 deg" in picture
    assert "360.0" not in picture


def test_the_ring_is_thin_where_the_axis_cannot_point():
    free = dots(drawn({}))
    half = dots(drawn({"pointing": NOTHING["pointing"] | {"limits": [270.0, 90.0]}}))
    assert 0.45 < half / free < 0.75


def test_north_is_named_only_where_it_is_known():
    assert any("N" in line for line in drawn({}))
    mount = drawn({"pointing": NOTHING["pointing"] | {"earth": False}})
    assert any("270" in line for line in mount)
    assert not any("N" in line for line in mount)


def test_a_heading_that_is_not_known_is_said():
    assert any("heading not known" in line for line in drawn({}))


@pytest.mark.parametrize("size", [(200, 60), (80, 24), (40, 12)])
def test_without_braille_everything_is_ascii(size):
    assert text(size=size, braille=False).isascii()


def test_silence_is_said_and_how_long_it_is():
    assert "NO TELEMETRY FOR 4 s" in text(now=104.2)
    assert "NO TELEMETRY" not in text(now=102.0)


def test_what_is_missing_is_said_above_the_picture():
    seen = text(advice="only summary values arrive from 1-191: behind ArduPilot it needs a role").splitlines()
    assert seen[3].startswith("only summary values arrive from 1-191")
    assert len(seen) == 24


def test_too_many_sources_are_counted():
    seen = text(sources=200)
    assert "200 announced, 32 received" in seen
    assert "microphones" in seen, "the table left no room for health"


def test_a_message_with_a_number_that_is_none_is_odd():
    [*_, source] = [value for value in full(30.0, 3, 1) if isinstance(value, Source)]
    assert "WARNING: ROSS_SOURCE with a number that is NaN" in text(replace(source, azimuth=math.nan))


def test_limits_are_read_from_what_the_payload_tells():
    information = Information(
        time_usec=1,
        spacing=0.05,
        speed_of_sound=343.0,
        axis_offset=0.0,
        joint_lower=-1.0,
        joint_upper=1.0,
        joint_speed=1.0,
        unit=2.0,
        rate=16000,
        k_max=6,
        software_version="1",
        actuator="grbl",
    )
    assert dots(drawn(view(known(information)))) < dots(drawn(view(known())))


def test_texts_of_others_cannot_move_the_cursor():
    seen = text(Text(Severity.INFO, "RoSS: \x1b[2J\x07 gone"), size=(80, 24))
    assert "?[2J? gone" in seen
    assert all(letter.isprintable() or letter == "\n" for letter in seen)


def test_a_mission_that_knows_nothing_yet_is_drawn():
    fleet, encoder = Fleet(), Encoder(1, 191)
    for packet in Decoder().feed(encoder.encode(Status(time_usec=1, mission_time=0.0, state=0, earth=False))):
        fleet.on_packet(packet, at=0.0)
    picture = view(fleet.payloads[ComponentId(1, 191)])
    seen = "\n".join(line.plain for line in compose(ScreenState(picture, 0.1), 80, 24))
    assert "IDLE" in seen
    assert "none yet" in seen


def test_what_was_ordered_is_followed():
    orders = CommandProtocol(lambda message, who: None, 255, 190)
    orders.order(ComponentId(1, 191), Turn(40.0))
    orders.order(ComponentId(1, 191), Stop())
    seen = text(doings=orders.doing)
    assert "1-191 turn to 40 deg: cancelled: stop was sent" in seen
    assert "1-191 stop: sent" in seen


def test_nothing_heard_shows_the_advice():
    lines = compose(ScreenState(None, 9.0, advice="nothing received on udpin:127.0.0.1:1: " + "do this " * 40), 40, 20)
    seen = "\n".join(line.plain for line in lines)
    assert "no telemetry yet" in seen
    assert seen.count("this") == 40
    assert len(lines) == 20


def test_the_time_is_that_of_the_latest_mission_and_none_without_one(ground):
    ground.say(status(3600.0, state=0))
    assert blocks.strip(ground.view)[0].plain.startswith("-  orientation")
    ground.say(status(3610.0), status(3622.5))
    assert blocks.strip(ground.view)[0].plain.startswith("12.5 s  orientation")
