"""``ross tlog``: a flight as a table, as JSON and as a picture."""

import json
import math
import sys
from dataclasses import replace
from functools import partial

import pytest
from click.testing import CliRunner

from command_line import called
from examples import rows_in_soak
from flight_logs import UNIX, full_tick, record, vehicle_frames
from mission_fixtures import without_picture
from ross_payload.ground.flights.command import command
from ross_protocols.mavlink.codec import Encoder, chunks
from ross_protocols.mavlink.commands import Result, acknowledgement
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from ross_protocols.mavlink.values import (
    Alignment,
    CandidateState,
    Health,
    Heartbeat,
    Information,
    Named,
    Rule,
    Severity,
    Source,
    Status,
    Text,
)
from ross_sim.sitl.command import command as sitl
from short_mission import PAIR

pytestmark = pytest.mark.lockstep

TURN = 54003
STOP = 54004


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    """The results of a short simulated mission, and its report."""
    folder = tmp_path_factory.mktemp("mission")
    (folder / "short.toml").write_text(PAIR)
    arguments = ["--scenario", str(folder / "short.toml"), "--out", str(folder / "out"), "--seed", "1", "--json"]
    with without_picture():
        flown = CliRunner().invoke(sitl, arguments, standalone_mode=False)
    assert flown.exception is None, flown.output
    return folder / "out", json.loads((folder / "out" / "report.json").read_text())


@pytest.fixture
def tlog(monkeypatch, capsys):
    """Run ``ross tlog``; exit code, output, errors."""

    return partial(called, monkeypatch, capsys, "tlog")


@pytest.fixture
def told(tlog, tmp_path):
    """Write frames with their times [s] as a log; what ``ross tlog --json`` tells."""

    def call(*frames):
        path = tmp_path / "flight.tlog"
        path.write_bytes(b"".join(record(UNIX + round(at * 1e6), frame) for at, frame in frames))
        code, out, err = tlog(path, "--json")
        assert code == 0, err
        return json.loads(out)

    return call


def apart(a, b):
    return abs(math.remainder(a - b, 360))


def test_a_mission_is_told_as_its_report_tells_it(tlog, mission):
    folder, report = mission
    code, out, _ = tlog(folder, "--json")
    assert code == 0
    (payload,) = json.loads(out)["payloads"]
    assert [each["state"] for each in payload["states"]][-1] == "done"
    assert sum(each["duration"] for each in payload["states"]) == pytest.approx(payload["last"] - payload["first"])
    (explored,) = payload["explorations"]
    assert explored["k"][-1][1] == report["k"] == len(explored["sources"])
    for source, found in zip(explored["sources"], report["sources"], strict=True):
        assert apart(source["azimuth"], -found["azimuth_deg"]) < 0.01
        assert source["sigma"] == pytest.approx(found["sigma_deg"], abs=0.01)
    used = [each for each in payload["alignments"] if each["state"] == "accepted"]
    assert len(used) == 1
    assert apart(used[0]["heading"], -report["alignment"]["used"]["heading_deg"]) < 0.01
    assert payload["events"][-1]["text"].startswith("mission over")


def test_the_table_says_it_to_a_person(tlog, mission):
    code, out, _ = tlog(mission[0])
    assert code == 0
    for words in ("payload 1-191", "explore listen", "Exploration 1", "accepted", "mission over", "ROSS_STATUS"):
        assert words in out


def test_k_is_told_over_time_and_silence_is(told):
    one = Encoder(1, 191)
    said = [(0.0, 1, 3), (1.0, 2, 3), (2.0, 2, 3), (8.5, 3, 3), (9.0, 3, 6)]
    frames = [(at, one.encode(Status(round(at * 1e6), at, state, True, k=k))) for at, k, state in said]
    (payload,) = told(*frames)["payloads"]
    assert payload["explorations"][0]["k"] == [[0.0, 1], [1.0, 2], [8.5, 3]]
    assert payload["gaps"] == [{"at": 2.0, "duration": 6.5}]
    assert [each["state"] for each in payload["states"]] == ["explore_listen", "run"]
    assert payload["states"][0]["duration"] == 9.0


def test_a_status_that_was_overtaken_is_no_other_state(told):
    one = Encoder(1, 191)
    said = [(0.0, 3, 0.0), (1.0, 6, 1.0), (1.1, 3, 0.9), (2.0, 6, 2.0)]
    frames = [(at, one.encode(Status(round(time * 1e6), time, state, True))) for at, state, time in said]
    (payload,) = told(*frames)["payloads"]
    assert [each["state"] for each in payload["states"]] == ["explore_listen", "run"]


def test_two_explorations_keep_their_own_sources(told):
    one = Encoder(1, 191)

    def explored(at, estimate, azimuth):
        time = round(at * 1e6)
        yield at, one.encode(Status(time, at, 3, True, k=1))
        yield at + 1, one.encode(Source(time, estimate, 0, 1, azimuth, 0.05, 0.9, 1.0, True, True, final=True))
        yield at + 2, one.encode(Status(time + 2_000_000, at + 2, 6, True, k=1))
        again = Source(time, estimate, 0, 1, azimuth, 0.05, 0.9, 1.0, True, True, final=True, score=4.5)
        yield at + 3, one.encode(again)

    (payload,) = told(*explored(0.0, 1, -0.5), *explored(10.0, 2, -1.0))["payloads"]
    first, second = payload["explorations"]
    assert first["sources"][0]["azimuth"] == pytest.approx(math.degrees(0.5), abs=1e-4)
    assert second["sources"][0]["azimuth"] == pytest.approx(math.degrees(1.0), abs=1e-4)
    assert first["sources"][0]["score"] == 4.5


def test_the_sources_are_those_of_the_latest_estimate_though_an_older_one_was_overtaken(told):
    one = Encoder(1, 191)

    def at(time, state=6):
        return time, one.encode(Status(round(time * 1e6), time, state, True, k=1))

    def estimate(heard, number, azimuth, found):
        return heard, one.encode(Source(round(found * 1e6), number, 0, 1, azimuth, 0.05, 0.9, 1.0, True, True))

    overtaken = (at(500.0), estimate(501.0, 2, -1.0, 500.0), estimate(501.1, 1, -0.5, 400.0))
    (payload,) = told(*overtaken)["payloads"]
    assert [each["azimuth"] for each in payload["sources"]] == [pytest.approx(math.degrees(1.0), abs=1e-4)]
    again = [(600.0, at(60.0)[1]), estimate(601.0, 1, -0.2, 60.0)]
    (payload,) = told(*overtaken, *again)["payloads"]
    assert [each["azimuth"] for each in payload["sources"]] == [pytest.approx(math.degrees(0.2), abs=1e-4)]


def test_what_became_of_a_candidate_is_its_last_word(told):
    one = Encoder(1, 191)
    states = (CandidateState.PLANNED, CandidateState.TURNING, CandidateState.REJECTED, CandidateState.REJECTED)
    frames = [
        (place, one.encode(Alignment(5, 1, 0, 1, 0, 0.5, 0.5, 2e-4, (1, 2), Rule.GAIN, state, True)))
        for place, state in enumerate(states)
    ]
    (payload,) = told(*frames)["payloads"]
    assert [(each["state"], each["aliased"]) for each in payload["alignments"]] == [("rejected", [1, 2])]


def test_orders_are_told_with_their_answers(told):
    ground, payload, other = Encoder(255, 190), Encoder(1, 191), Encoder(254, 190)

    def order(sender, confirmation=0, heading=30.0):
        numbers = (heading, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        return sender.encode(common.MAVLink_command_long_message(1, 191, TURN, confirmation, *numbers))

    def answer(result, to=255, progress=None):
        return payload.encode(acknowledgement(TURN, result, ComponentId(to, 190), progress))

    (told_of,) = told(
        (0.0, payload.encode(Status(0, 0.0, 0, True))),
        (1.0, order(ground)),
        (1.1, answer(Result.IN_PROGRESS, progress=0.1)),
        (1.2, order(ground, confirmation=1)),
        (1.5, answer(Result.IN_PROGRESS, progress=0.6)),
        (1.6, order(other, heading=90.0)),
        (1.7, answer(Result.TEMPORARILY_REJECTED, to=254)),
        (2.0, answer(Result.ACCEPTED)),
    )["payloads"]
    mine, theirs = told_of["commands"]
    assert (mine["from"], mine["command"], mine["numbers"]) == ("255-190", "turn", [30.0])
    assert [(each["result"], each["progress"]) for each in mine["answers"]] == [
        ("in_progress", 0.6),
        ("accepted", None),
    ]
    assert [each["result"] for each in theirs["answers"]] == ["temporarily_rejected"]


def test_orders_hold_nothing_that_is_meant_for_other_components(told):
    ground, autopilot, payload = Encoder(255, 190), Encoder(1, 1), Encoder(1, 191)

    def command(sender, number, *target):
        return sender.encode(common.MAVLink_command_long_message(*target, number, 0, *[148.0] + [0.0] * 6))

    (told_of,) = told(
        (0.0, payload.encode(Status(0, 0.0, 0, True))),
        (1.0, command(ground, common.MAV_CMD_REQUEST_MESSAGE, 1, 1)),
        (1.1, command(ground, common.MAV_CMD_REQUEST_MESSAGE, 1, 0)),  # to all, as ground stations ask an autopilot
        (1.2, command(autopilot, common.MAV_CMD_REQUEST_MESSAGE, 0, 0)),
        (1.3, command(ground, STOP, 0, 0)),  # only payloads know it
        (1.4, command(ground, common.MAV_CMD_SET_MESSAGE_INTERVAL, 1, 0)),
        (
            1.5,
            payload.encode(
                acknowledgement(common.MAV_CMD_SET_MESSAGE_INTERVAL, Result.ACCEPTED, ComponentId(255, 190))
            ),
        ),
        (1.6, command(ground, common.MAV_CMD_REQUEST_MESSAGE, 1, 191)),
    )["payloads"]
    found = [(each["at"], each["command"]) for each in told_of["commands"]]
    assert found == [(1.3, "stop"), (1.4, "SET_MESSAGE_INTERVAL"), (1.6, "REQUEST_MESSAGE")]


def test_answers_to_orders_that_were_not_heard_are_told_too(told):
    one = Encoder(1, 191)
    (payload,) = told(
        (0.0, one.encode(Status(0, 0.0, 0, True))),
        (1.0, one.encode(acknowledgement(TURN, Result.ACCEPTED, ComponentId(255, 190)))),
    )["payloads"]
    (order,) = payload["commands"]
    assert (order["at"], order["command"], order["answers"][0]["result"]) == (None, "turn", "accepted")


def test_streams_are_told_as_long_as_they_carried_the_same_to_the_same(told):
    encoder = Encoder(1, 191)
    stream = StreamReport(
        1, 0, 1, "rtp", Selection.TARGET, True, 48000, on=True, codec=Codec.OPUS, address="10.0.0.2", port=5004
    )
    steps = [(0, stream), (2, replace(stream, level=-20.0, lost=5)), (4, replace(stream, selection=Selection.MIXTURE)),
             (6, replace(stream, on=False)), (8, replace(stream, on=False))]  # fmt: skip
    frames = [(0.0, encoder.encode(Status(1, 0.0, 0, True)))]
    (payload,) = told(*frames, *((at, encoder.encode(each)) for at, each in steps))["payloads"]
    first, second = payload["streams"]
    assert (first["at"], first["duration"], first["whom"], first["lost"]) == (0, 4, "target", 5)
    assert (second["at"], second["duration"], second["whom"]) == (4, 2, "mixture")
    assert (second["place"], second["sink"], second["codec"]) == ("10.0.0.2:5004", "rtp", "opus")


def test_long_texts_are_put_together(told):
    one, text = Encoder(1, 191), "RoSS: " + "word " * 20 + "end"
    parts = [one.encode(part) for part in chunks(Severity.WARNING, text, 9)]
    (payload,) = told((0.0, one.encode(Status(0, 0.0, 0, True))), *((1.0, part) for part in parts))["payloads"]
    assert [(each["severity"], each["text"]) for each in payload["events"]] == [(4, text.removeprefix("RoSS: "))]


@pytest.mark.parametrize("rest", [(), (30.0,)])
def test_a_text_that_was_not_heard_to_its_end_is_told_at_its_time_whatever_comes_after_it(told, rest):
    one, text = Encoder(1, 191), "RoSS: " + "word " * 20 + "end"
    parts = [one.encode(part) for part in chunks(Severity.WARNING, text, 9)]
    said = [(at, one.encode(Status(round(at * 1e6), at, 0, True))) for at in (0.0, 20.0, 40.0)]
    later = [(at, one.encode(Text(Severity.INFO, "RoSS: later"))) for at in rest]
    (payload,) = told(said[0], (1.0, parts[0]), (1.1, parts[1]), said[1], *later, said[2])["payloads"]
    assert [each["at"] for each in payload["events"]] == [3.0, *rest]
    assert payload["events"][0]["text"] == text.removeprefix("RoSS: ")[:94] + " ..."


def test_lost_frames_and_rates_are_counted(told):
    one = Encoder(1, 191)
    frames = [(place / 4, one.encode(Status(place * 250_000, 0.0, 0, True))) for place in range(41)]
    kept = [frame for place, frame in enumerate(frames) if place not in (7, 8, 20)]
    (payload,) = told(*kept)["payloads"]
    assert payload["lost"] == 3
    assert payload["kinds"] == [{"name": "ROSS_STATUS", "count": 38, "rate": 3.7}]


def test_a_payload_that_only_mirrors_tell_of_has_states_and_k(told):
    one = Encoder(1, 191)
    frames = [
        (at, one.encode(value))
        for at, state, k in ((0.0, 3, 1), (1.0, 3, 2), (2.0, 6, 2))
        for value in (Heartbeat(Health.ACTIVE, state), Named(at, "ross_k", k), Named(at, "ross_state", state))
    ]
    (payload,) = told(*frames)["payloads"]
    assert [each["state"] for each in payload["states"]] == ["explore_listen", "run"]
    assert payload["explorations"][0]["k"] == [[0.0, 1], [1.0, 2]]


@pytest.fixture
def fleet_log(tmp_path):
    """Two payloads and a vehicle."""
    encoders = [Encoder(system, 191) for system in (1, 2)]
    frames = [encoder.encode(value) for step in range(4) for encoder in encoders for value in full_tick(step, step)]
    path = tmp_path / "fleet.tlog"
    mixed = [*frames, *vehicle_frames(system=3)]
    path.write_bytes(b"".join(record(UNIX + 10_000 * place, frame) for place, frame in enumerate(mixed)))
    return path


def test_one_of_many_can_be_asked_for(tlog, fleet_log):
    code, out, _ = tlog(fleet_log, "--json", "--payload", "2-191")
    assert code == 0
    told = json.loads(out)
    assert [each["who"] for each in told["payloads"]] == ["2-191"]
    assert [each["who"] for each in told["others"]] == ["3-1"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--payload", "9-191"], "payload: expected one of 1-191, 2-191, got 9-191"),
        (["--payload", "x"], "expected system-component, as in 1-191, got 'x'"),
        (["--picture", "a.tlog"], "expected a name that ends with .png or .svg, got a.tlog"),
        (["--mcap", "a.png"], "expected a name that ends with .mcap, got a.png"),
        (["--picture", "/nowhere/a.png"], "/nowhere/a.png: cannot be written: No such file or directory"),
    ],
)
def test_a_mistake_costs_one_line_and_exit_code_2(tlog, fleet_log, arguments, words):
    code, _, err = tlog(fleet_log, *arguments)
    assert code == 2
    assert words in err
    assert len(err.splitlines()) == 1


def test_a_log_of_somebody_else_is_told_but_not_drawn(tlog, tmp_path):
    path = tmp_path / "other.tlog"
    path.write_bytes(b"".join(record(UNIX, frame) for frame in vehicle_frames()))
    code, out, _ = tlog(path)
    assert code == 0
    assert "no messages of a payload: this is a log of system 1" in out
    code, _, err = tlog(path, "--picture", tmp_path / "a.png")
    assert code == 2
    assert "expected a payload for a picture" in err
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(
    ("name", "magic", "times", "options"),
    [("a.svg", b"<?xml", 2, ["--payload", "1-191"]), *rows_in_soak(("a.png", b"\x89PNG", 1, []))],
)
def test_the_picture_is_drawn_whole_and_the_same_again(tlog, fleet_log, tmp_path, *, name, magic, times, options):
    """What could differ, names and the date, is in the vector graphics, of one payload as of two."""
    pytest.importorskip("matplotlib", reason="needs the extra 'sim'")
    path = tmp_path / name
    path.write_text("an earlier one")
    drawn = []
    for _ in range(times):
        assert tlog(fleet_log, "--picture", path, *options)[0] == 0
        drawn.append(path.read_bytes())
    assert drawn[0].startswith(magic)
    assert len(set(drawn)) == 1
    assert not [each for each in tmp_path.iterdir() if each.name.startswith(".")]


def test_names_from_the_air_are_not_taken_for_markup(tlog, tmp_path):
    one = Encoder(1, 191)
    said = Information(0, 0.2, 340.0, 0.0, None, None, None, 3.0, 16_000, 6, "[red]1[/nope]", "[bold]x")
    frames = [one.encode(said), *(one.encode(part) for part in chunks(Severity.INFO, "[/bad] $x_$\x1b[2J\x07", 1))]
    path = tmp_path / "odd.tlog"
    path.write_bytes(b"".join(record(UNIX, frame) for frame in frames))
    code, out, _ = tlog(path, "--picture", tmp_path / "a.png")
    assert code == 0
    assert "[/bad] $x_$?[2J?" in out
    assert "[red]1[/nope]" in out


def test_help_names_what_it_reads():
    assert "Mission Planner" in CliRunner().invoke(command, ["--help"]).output


@pytest.mark.parametrize(
    ("absent", "module", "option", "extra", "package"),
    [
        ("matplotlib", "plot", "--picture=a.png", "sim", "'matplotlib>="),
        ("foxglove", "mcap", "--mcap=a.mcap", "mcap", "'foxglove-sdk>="),
    ],
)
def test_a_missing_extra_is_named_in_one_line(tlog, monkeypatch, fleet_log, *, absent, module, option, extra, package):
    monkeypatch.setitem(sys.modules, absent, None)
    monkeypatch.delitem(sys.modules, f"ross_payload.ground.flights.{module}", raising=False)
    code, _, err = tlog(fleet_log, option)
    assert code == 2
    assert f"needs the extra '{extra}': " in err
    assert package in err.partition("pip install ")[2]
    assert len(err.splitlines()) == 1
