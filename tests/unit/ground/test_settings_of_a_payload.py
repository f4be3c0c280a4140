"""Parameters of a payload: listed, explained, set; on good links and on bad ones."""

from collections import Counter
from types import SimpleNamespace

import pytest
from pymavlink.dialects.v20 import common

from client_bench import US, WHO, Served, Station
from examples import in_soak
from ross_payload.config import Config
from ross_payload.config.parameter_table import TABLE, value_of
from ross_payload.ground.client.param_client import ParamClient
from ross_payload.ground.model.payload_state import PayloadState as Known
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.params import NO_INDEX, ParamError, value_message

(HEARTBEAT,) = Decoder().feed(Encoder(*WHO).encode(common.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)))
DEFAULTS = {name: value_of(Config(), name) for name in TABLE}


def rig_of(sky, **odds):
    payload = Served(sky(**odds))
    station = Station(payload)
    settings = ParamClient(station.send, WHO, *US)
    station.clients.append(settings)
    return SimpleNamespace(payload=payload, station=station, settings=settings)


@pytest.fixture
def rig(sky):
    return rig_of(sky)


def row(settings, name):
    return next(row for row in settings.rows() if row["name"] == name)


def test_all_parameters_come_with_values_in_the_payloads_order(rig):
    assert rig.station.wait(5, lambda: rig.settings.complete)
    assert rig.settings.values == pytest.approx(DEFAULTS)
    assert [row["name"] for row in rig.settings.rows()] == list(TABLE)
    assert {row["state"] for row in rig.settings.rows()} == {"known"}


def test_their_meaning_comes_from_the_payloads_metadata(rig):
    rig.station.wait(15, lambda: rig.settings.complete and all(row["description"] for row in rig.settings.rows()))
    unit, parameter = row(rig.settings, "EXP_UNIT"), TABLE["EXP_UNIT"]
    assert (unit["min"], unit["max"], unit["unit"]) == (parameter.lower, parameter.upper, "s")
    assert parameter.about.rstrip(".") in unit["description"]
    assert unit["group"] == "explore"
    assert (row(rig.settings, "EXP_MAX_ROT")["whole"], unit["whole"]) == (True, False)
    assert rig.settings.notes() == []


def test_what_is_set_is_sent_read_back_and_in_force(rig):
    rig.station.wait(5, lambda: rig.settings.complete)
    rig.settings.set("EXP_UNIT", 2.3)
    assert row(rig.settings, "EXP_UNIT")["state"] == "sending"
    assert rig.station.wait(1, lambda: row(rig.settings, "EXP_UNIT")["state"] == "set")
    assert rig.payload.parameters.value("EXP_UNIT") == rig.settings.values["EXP_UNIT"] == 2.3


def test_what_is_refused_says_why_and_keeps_its_value(rig):
    rig.station.wait(5, lambda: rig.settings.complete)
    rig.settings.set("EXP_STEP", 999)
    assert rig.station.wait(2, lambda: "got 999" in row(rig.settings, "EXP_STEP")["reason"])
    assert row(rig.settings, "EXP_STEP")["state"] == "refused"
    assert rig.settings.values["EXP_STEP"] == 15.0


def test_what_somebody_else_sets_is_seen(rig):
    rig.station.wait(5, lambda: rig.settings.complete)
    other = Station(rig.payload, (254, 190))
    rig.payload.parameters.set("EXP_UNIT", 4.0)
    rig.station.wait(1)
    assert row(rig.settings, "EXP_UNIT")["value"] == 4.0
    assert not other.sent


@pytest.mark.parametrize(("silence", "seen"), [(2.9, 3.0), (3.1, 4.0)])
def test_what_somebody_else_sets_during_an_outage_is_seen_after_it(rig, silence, seen):
    """The payload tells everybody once; a list after every lost frame would be too much for a radio."""
    rig.settings.on_state(Known(WHO, 0.0, 1.0))
    rig.station.wait(5, lambda: rig.settings.complete)
    order = [row["name"] for row in rig.settings.rows()]
    rig.station.clients.clear()
    rig.payload.parameters.set("EXP_UNIT", 4.0)
    rig.station.wait(silence)
    rig.station.clients.append(rig.settings)
    rig.settings.on_state(Known(WHO, 0.0, 1.0 + silence))
    assert [row["name"] for row in rig.settings.rows()] == order
    rig.station.wait(2)
    assert rig.settings.complete
    assert row(rig.settings, "EXP_UNIT")["value"] == seen


def test_a_link_with_outages_without_end_is_not_filled_with_lists(rig):
    """Half a second in every four is heard: what is asked for then arrives, and no more is asked for."""
    rig.station.wait(5, lambda: rig.settings.complete and rig.settings.described)
    before, complete = len(rig.station.sent), []
    for _ in range(20):
        for loss, seconds in ((0.0, 0.5), (1.0, 3.5)):
            rig.payload.ground.air.odds.loss = loss
            if not loss:
                now = rig.payload.clock.now()
                rig.settings.on_state(Known(WHO, 0.0, now))
                rig.settings.on_packet(HEARTBEAT, now)
            rig.station.wait(seconds)
        complete.append(rig.settings.complete)
    asked = Counter(message.get_type() for _, message in rig.station.sent[before:])
    assert asked["PARAM_REQUEST_LIST"] <= 5
    assert asked["PARAM_REQUEST_READ"] <= 80
    assert complete.count(True) > 10


def test_what_was_not_answered_in_an_outage_is_known_after_it(rig):
    rig.settings.on_state(Known(WHO, 0.0, 1.0))
    rig.station.wait(5, lambda: rig.settings.complete)
    rig.station.lose = lambda message: True
    rig.settings.set("EXP_UNIT", 2.3)
    assert rig.station.wait(8, lambda: row(rig.settings, "EXP_UNIT")["state"] == "no_answer")
    rig.station.lose = lambda message: False
    rig.settings.on_state(Known(WHO, 0.0, 9.0))
    rig.station.wait(2)
    told = row(rig.settings, "EXP_UNIT")
    assert (told["value"], told["state"], told["reason"]) == (3.0, "known", "")


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2, 3)])
def test_on_a_bad_link_the_list_and_its_meaning_are_whole_after_all(sky, seed):
    rig = rig_of(sky, loss=0.2, doubled=0.2, delayed=0.2, seed=seed)
    assert rig.station.wait(30, lambda: rig.settings.complete)
    assert rig.settings.values == pytest.approx(DEFAULTS)
    assert rig.station.wait(60, lambda: all(row["description"] for row in rig.settings.rows()))


@pytest.mark.parametrize("seed", [0, *in_soak(1, 2, 3)])
def test_on_a_bad_link_what_is_shown_as_set_is_in_force(sky, seed):
    rig = rig_of(sky, loss=0.2, doubled=0.2, delayed=0.2, damaged=0.05, seed=seed)
    assert rig.station.wait(30, lambda: rig.settings.complete)
    for value in (2.0, 3.5, 2.0, 4.5):
        rig.settings.set("EXP_UNIT", value)
        rig.station.wait(8, lambda: row(rig.settings, "EXP_UNIT")["state"] == "set")
        assert rig.payload.parameters.value("EXP_UNIT") == value
        rig.settings.set("EXP_STEP", 999)
        assert rig.station.wait(8, lambda: row(rig.settings, "EXP_STEP")["state"] == "refused")
        rig.station.wait(1)


def test_who_may_not_set_is_told_that_nobody_answers(rig):
    rig.station.wait(5, lambda: rig.settings.complete)
    rig.station.lose = lambda message: True
    rig.settings.set("EXP_UNIT", 2.3)
    rig.station.wait(8)
    assert row(rig.settings, "EXP_UNIT")["state"] == "no_answer"
    assert "accept" in row(rig.settings, "EXP_UNIT")["reason"]
    assert sum(message.get_type() == "PARAM_SET" for _, message in rig.station.sent) == 5


def test_an_error_that_comes_twice_is_none_of_the_next_value(rig):
    """The first frame of the next value is lost."""
    rig.station.wait(5, lambda: rig.settings.complete)
    rig.settings.set("EXP_UNIT", 99)
    assert rig.station.wait(2, lambda: row(rig.settings, "EXP_UNIT")["state"] == "refused")
    rig.station.lose = lambda message: True
    rig.settings.set("EXP_UNIT", 2.5)
    rig.station.lose = lambda message: False
    error = common.MAVLink_param_error_message(*US, b"EXP_UNIT", -1, ParamError.VALUE_OUT_OF_RANGE)
    for packet in Decoder().feed(Encoder(*WHO).encode(error)):
        rig.settings.on_packet(packet, rig.payload.clock.now())
    assert rig.station.wait(5, lambda: row(rig.settings, "EXP_UNIT")["state"] == "set")
    assert rig.payload.parameters.value("EXP_UNIT") == 2.5


def test_a_value_that_is_read_back_late_does_not_end_the_change_after_the_next(rig):
    """Its first frame is lost."""
    rig.station.wait(5, lambda: rig.settings.complete)
    for value in (2.5, 3.5):
        rig.settings.set("EXP_UNIT", value)
        assert rig.station.wait(2, lambda: row(rig.settings, "EXP_UNIT")["state"] == "set")
    rig.station.lose = lambda message: True
    rig.settings.set("EXP_UNIT", 2.5)
    for packet in Decoder().feed(Encoder(*WHO).encode(value_message("EXP_UNIT", 2.5, NO_INDEX, len(TABLE)))):
        rig.settings.on_packet(packet, rig.payload.clock.now())
    rig.station.wait(0.5)
    assert row(rig.settings, "EXP_UNIT")["state"] == "sending"
    rig.station.lose = lambda message: False
    assert rig.station.wait(5, lambda: row(rig.settings, "EXP_UNIT")["state"] == "set")
    assert rig.payload.parameters.value("EXP_UNIT") == 2.5


@pytest.mark.parametrize("seed", range(2))
def test_with_answers_later_than_a_second_every_end_is_true(sky, seed):
    """Every frame is sent twice, and answered twice."""
    rig = rig_of(sky, delayed=0.9, doubled=0.1, seed=seed)
    assert rig.station.wait(60, lambda: rig.settings.complete)
    for value in (99, 2.5, -1, 3.5, 2.5, 99, 4.5) * 3:
        rig.settings.set("EXP_UNIT", value)
        assert rig.station.wait(20, lambda: row(rig.settings, "EXP_UNIT")["state"] != "sending")
        assert row(rig.settings, "EXP_UNIT")["state"] == ("set" if 0.5 <= value <= 60 else "refused")
        assert row(rig.settings, "EXP_UNIT")["state"] == "refused" or rig.payload.parameters.value("EXP_UNIT") == value


# ------------------------------------------------------------------------------------------- with a scripted payload
