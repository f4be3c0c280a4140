"""The picture that page, terminal and logs draw: compass degrees, clockwise, and null for what is not known."""

import math
from dataclasses import replace

import pytest

from ross_payload.config import Config
from ross_payload.config.parameter_table import TABLE, value_of
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.state_reducer import learn
from ross_payload.ground.model.view import SECTIONS, view
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.component_id import ComponentId

WHO = ComponentId(1, 191)


def deg(clockwise):
    """An angle inside: radians, counter-clockwise."""
    return math.radians(-clockwise)


def status(**how):
    return v.Status(**{"time_usec": 0, "mission_time": 1.0, "state": 6, "earth": True} | how)


def information(lower, upper):
    return v.Information(0, 0.05, 343.0, 0.0, lower, upper, 2.0, 3.0, 16000, 6, "1.0", "tb6600")


def payload(**how):
    return PayloadState(WHO, 0.0, 0.0, **how)


def test_of_somebody_unknown_everything_is_null_or_empty():
    shown = view(payload())
    assert set(shown) == set(SECTIONS)
    assert shown["standing"]["state"] is None
    assert shown["pointing"]["heading"] is None
    assert shown["mission"]["k"] is None
    assert [shown[name] for name in ("sources", "densities", "isolation", "groups", "history", "events")] == [[]] * 6


def test_a_heading_in_the_east_is_90_degrees():
    shown = view(payload(status=status(heading=deg(90), heading_goal=deg(-10), joint=deg(400))))
    assert shown["pointing"]["heading"] == pytest.approx(90)
    assert shown["pointing"]["goal"] == pytest.approx(350)
    assert shown["pointing"]["joint"] == pytest.approx(400), "a joint is not wrapped"


def test_limits_are_headings_clockwise_from_the_first_to_the_second():
    """The joint stands at 10 deg and points to 40 deg; it goes from -90 to 60 deg: from 300 to 90 deg."""
    known = payload(status=status(heading=deg(40), joint=deg(10)), information=information(deg(60), deg(-90)))
    assert view(known)["pointing"]["limits"] == pytest.approx([300, 90])


@pytest.mark.parametrize("travel", [(None, None), (None, 1.0), (-math.pi, math.pi), (-10.0, 10.0)])
def test_what_turns_all_round_has_no_limits(travel):
    known = payload(status=status(heading=0.0, joint=0.0), information=information(*travel))
    assert view(known)["pointing"]["limits"] is None


def test_the_candidate_that_is_turned_to_is_the_current_one_and_its_gain_the_predicted_one():
    candidates = tuple(
        v.Alignment(
            0, 1, index, 3, index, deg(30 * index), 0.0, 1e-4, (), v.Rule.GAIN, state, earth=True, gain=index + 1.0
        )
        for index, state in enumerate((v.CandidateState.REJECTED, v.CandidateState.TURNING, v.CandidateState.PLANNED))
    )
    shown = view(payload(status=status(), alignments=candidates))
    assert (shown["plan"]["current"], shown["mission"]["gain"]) == (1, 2.0)
    assert [each["state"] for each in shown["plan"]["candidates"]] == ["rejected", "turning", "planned"]
    assert shown["plan"]["candidates"][1]["heading"] == pytest.approx(30)


def test_the_expected_time_needs_the_parameters_and_grows_with_them():
    defaults = {name: value_of(Config(), name) for name in TABLE}
    known = payload(status=status())
    assert view(known)["mission"]["expected"] is None
    usual = view(known, defaults)["mission"]["expected"]
    longer = view(known, defaults | {"XPL_RUN": defaults["XPL_RUN"] + 10})["mission"]["expected"]
    assert longer == pytest.approx(usual + 10)


def test_states_and_outcomes_are_words():
    shown = view(payload(status=status(state=6, outcome=1)))
    assert shown["standing"]["state"] == "run"
    assert shown["standing"]["state_meaning"]
    assert isinstance(shown["standing"]["outcome"], str)


def test_a_state_of_a_newer_dialect_is_its_number():
    assert view(payload(status=status(state=200)))["standing"]["state"] == "200"


IDLE, LISTENING, DONE = 0, 3, 7  # ROSS_STATE


@pytest.mark.parametrize(
    ("course", "elapsed"),
    [
        ([(0.0, LISTENING), (9.0, LISTENING)], 9.0),  # heard from its beginning
        ([(50.0, LISTENING), (59.0, LISTENING)], None),  # joined late: nobody knows
        ([(50.0, IDLE), (60.0, LISTENING), (72.0, LISTENING)], 12.0),  # a payload that lived before
        ([(0.0, LISTENING), (9.0, DONE), (30.0, DONE)], 9.0),  # over: it counts no more
        ([(0.0, LISTENING), (9.0, DONE), (30.0, LISTENING), (34.0, LISTENING)], 4.0),  # the next one
        ([(50.0, LISTENING), (59.0, DONE)], None),
        ([(0.0, IDLE), (4000.0, IDLE)], None),
    ],
)
def test_elapsed_is_the_latest_missions_own_time(course, elapsed):
    known = payload()
    for mission_time, state in course:
        known = learn(known, status(mission_time=mission_time, state=state), at=mission_time)
    assert view(known)["mission"]["elapsed"] == elapsed


def test_a_mission_longer_than_the_history_still_knows_its_beginning():
    known = payload()
    for second in range(2000):
        known = learn(known, status(mission_time=float(second), state=LISTENING), at=float(second))
    assert known.history[0].mission_time > 0
    assert view(known)["mission"]["elapsed"] == 1999.0


def test_every_direction_is_a_compass_direction_and_an_elevation_goes_up():
    source = v.Source(
        0, 1, 0, 1, deg(30), math.radians(2), 0.9, 1.0, earth=True, resolved=False, mirror=deg(300),
        elevation=math.radians(15),
    )  # fmt: skip
    aim = v.Alignment(
        0, 1, 0, 1, 0, deg(110), deg(-70), 2e-4, (), v.Rule.GAIN, v.CandidateState.PLANNED, earth=True
    )  # fmt: skip
    heard = v.Density(0, 1, 0, deg(45), earth=True, first=-1e-4, last=2e-4, density=(0.0, 1.0))
    curve = v.Isolation(0, 1, 0, earth=True, first=deg(10), last=deg(190), maximum=1e-4, isolation=(0.0, 1.0))
    group = v.Separation(0, 1, 0, 1, v.Phase.RUN, (0,), "refined", earth=True, heading=deg(200))
    known = payload()
    for at, value in enumerate((status(heading=deg(75)), source, aim, heard, curve, group)):
        known = learn(known, value, at=float(at))
    shown = view(known)
    (drawn,) = shown["sources"]
    assert [drawn[name] for name in ("azimuth", "mirror", "sigma", "elevation")] == pytest.approx([30, 300, 2, 15])
    assert [point[1] for point in drawn["trail"]] == pytest.approx([30])
    (candidate,) = shown["plan"]["candidates"]
    assert [candidate["heading"], candidate["joint"]] == pytest.approx([110, -70])
    (density,) = shown["densities"]
    assert [density[name] for name in ("heading", "first_us", "last_us")] == pytest.approx([45, -100, 200])
    assert [shown["isolation"][0][name] for name in ("first", "last")] == pytest.approx([10, 190])
    assert shown["groups"][0]["heading"] == pytest.approx(200)
    assert shown["history"][0]["heading"] == pytest.approx(75)


def test_of_two_troubles_both_remedies_are_told():
    audio = v.Audio(0, trouble=1 | 4)  # clipping, and microphone 2 is dead
    words = view(payload(audio=audio))["health"]["microphones"]["words"]
    assert words == "clipping: lower the gain; microphone 2 is silent: check its wiring"


def mirrored(state, until, known):
    """What is known after mirrors of the state, once a second, as an autopilot passes them, but not our dialect."""
    while known.last + 1.0 <= until:
        at = known.last + 1.0
        known = learn(known, v.Named(at, "ross_state", float(state)), at)
    return known


def test_when_only_mirrors_come_any_longer_what_was_told_before_is_not_shown_as_of_now():
    """The direct link is gone, and the one by way of the autopilot is left."""
    stopped, explores = 8, 3
    known = learn(payload(), replace(status(), state=stopped, mission_time=9.0), 100.0)
    known = mirrored(explores, 134.0, known)
    assert view(known)["standing"]["state"] == "stopped"
    known = mirrored(explores, 136.0, known)
    told = view(known)
    assert (told["standing"]["state"], told["standing"]["mirrors_only"]) == ("explore_listen", True)
    assert told["pointing"]["goal"] is None
    assert len(known.history) == 1
    known = learn(known, replace(status(), state=stopped), 137.0)
    assert view(known)["standing"]["state"] == "stopped"


def test_a_mirror_that_comes_before_the_status_after_an_outage_changes_nothing():
    known = learn(payload(), status(k=1, mission_time=9.0), 100.0)
    known = learn(known, v.Source(0, 1, 0, 1, 0.1, 0.1, 1.0, 1.0, earth=True, resolved=True), 100.1)
    known = learn(known, v.Named(600.0, "ross_state", 6.0), 600.0)
    known = learn(known, status(k=1, mission_time=510.0), 600.5)
    assert len(known.sources) == len(known.trails) == 1
    assert not view(known)["standing"]["mirrors_only"]


def test_when_only_heartbeats_come_any_longer_they_tell_the_state():
    """Another station has disabled status and mirrors on the link, and is gone."""
    known = learn(payload(), replace(status(), state=7), 100.0)
    for at in range(101, 140):
        known = learn(known, v.Heartbeat(v.Health.STANDBY, state=8), float(at))
        assert (view(known)["standing"]["state"] == "stopped") == (at > 135)
    assert view(known)["pointing"]["heading"] is None
    assert not view(known)["standing"]["mirrors_only"]
