"""Parameters of a payload that is scripted: what is asked for and sent again, and what every answer means."""

import math
import tracemalloc

import pytest
from pymavlink.dialects.v20 import common

from client_bench import US, WHO
from examples import in_soak
from ross_payload.ground.client.component_metadata import MOST_PARAMETERS
from ross_payload.ground.client.param_client import ParamClient
from ross_payload.ground.model.payload_state import PayloadState as Known
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.params import NO_INDEX, ParamError, value_message
from ross_protocols.mavlink.values import Severity, Text


def row(settings, name):
    return next(row for row in settings.rows() if row["name"] == name)


class Script:
    """A payload with any parameters."""

    def __init__(self):
        self.heard, self.now = [], 0.0
        self.settings = ParamClient(lambda message, who: self.heard.append(message), WHO, *US)
        self.encoder, self.decoder = Encoder(1, 191), Decoder()
        self.wait(0.05)

    def say(self, message):
        for packet in self.decoder.feed(self.encoder.encode(message)):
            self.settings.on_packet(packet, self.now)

    def tell(self, values, start=0, count=None):
        for index, (name, value) in enumerate(values.items(), start):
            self.say(value_message(name, value, index, len(values) if count is None else count))

    def wait(self, seconds):
        for _ in range(round(seconds * 20)):
            self.now = round(self.now + 0.05, 6)
            self.settings.tick(self.now)

    def names(self):
        return [message.get_type() for message in self.heard]


@pytest.fixture
def script():
    return Script()


def test_a_payload_that_tells_nothing_about_its_parameters_still_shows_them(script):
    script.tell({"ALPHA": 1.0, "BETA": 2.5})
    script.wait(20)
    assert [(row["name"], row["value"], row["description"]) for row in script.settings.rows()] == [
        ("ALPHA", 1.0, ""),
        ("BETA", 2.5, ""),
    ]
    assert script.settings.notes() == ["the payload provides no parameter metadata"]


def test_what_is_being_set_goes_on_when_somebody_asks_for_the_list_again(script):
    script.tell({"ALPHA": 1.0, "BETA": 2.5})
    script.settings.set("BETA", 3.0)
    script.settings.refresh()
    assert script.settings.state_of("BETA")[0] == "sending"
    script.wait(3.0)
    assert script.names().count("PARAM_SET") > 1
    script.tell({"ALPHA": 1.0, "BETA": 3.0})
    assert script.settings.state_of("BETA")[0] == "set"
    assert script.settings.values == {"ALPHA": 1.0, "BETA": 3.0}


def test_a_list_that_nobody_answers_is_asked_for_every_five_seconds(script):
    script.wait(20)
    assert script.names() == ["PARAM_REQUEST_LIST"] * 5 or script.names() == ["PARAM_REQUEST_LIST"] * 4


def test_what_is_missing_is_asked_for_by_index(script):
    script.tell({"ALPHA": 1.0}, count=3)
    script.wait(2.5)
    asked = [message.param_index for message in script.heard if message.get_type() == "PARAM_REQUEST_READ"]
    assert set(asked) == {1, 2}


def test_a_payload_that_starts_with_other_parameters_is_listed_again(script):
    script.settings.on_state(Known(WHO, 0.0, 0.0, boots=1))
    script.tell({"ALPHA": 1.0, "BETA": 2.5})
    script.settings.on_state(Known(WHO, 0.0, 1.0, boots=2))
    assert script.settings.values == {}
    script.wait(0.1)
    assert script.names()[-1] == "PARAM_REQUEST_LIST"
    script.tell({"GAMMA": 3.0})
    assert script.settings.values == {"GAMMA": 3.0}
    assert script.settings.complete


def test_another_set_is_noticed_though_the_start_was_not(script):
    script.tell({"ALPHA": 1.0, "BETA": 2.5})
    script.wait(6)
    script.tell({"GAMMA": 3.0, "DELTA": 1.0, "EPS": 0.5})
    assert list(script.settings.values) == ["GAMMA", "DELTA", "EPS"]


def test_two_sets_at_once_are_noticed_and_no_flood_of_requests_follows(script):
    for _ in range(200):
        script.tell({"ALPHA": 1.0})
        script.tell({"GAMMA": 3.0, "DELTA": 1.0})
        script.wait(0.05)
    assert any("two payloads" in note for note in script.settings.notes())
    assert len(script.heard) < 40


def test_no_more_than_a_thousand_are_kept(script):
    script.tell({f"P{index}": 1.0 for index in range(1200)})
    assert len(script.settings.rows()) == 1000
    assert any("1200" in note for note in script.settings.notes())
    assert script.settings.complete


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_no_number_is_left_out_with_a_note(script, value):
    script.tell({"ALPHA": value, "BETA": 2.5})
    assert script.settings.values == {"BETA": 2.5}
    assert any("invalid value or name" in note for note in script.settings.notes())


@pytest.mark.parametrize("name", [b"", b"\xff\xfe", b"A\x1b[31m"])
def test_a_name_that_is_none_is_left_out_with_a_note(script, name):
    script.say(common.MAVLink_param_value_message(name, 1.0, common.MAV_PARAM_TYPE_REAL32, 1, 0))
    assert script.settings.values == {}
    assert any("invalid value or name" in note for note in script.settings.notes())


@pytest.mark.parametrize(("told", "state"), [(2.0, "set"), (1.5, "known")])
def test_an_answer_that_comes_after_it_was_given_up_counts(script, told, state):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 2.0)
    script.wait(10)
    assert row(script.settings, "ALPHA")["state"] == "no_answer"
    script.say(value_message("ALPHA", told, NO_INDEX, 1))
    assert (script.settings.values["ALPHA"], row(script.settings, "ALPHA")["state"]) == (told, state)


def test_a_value_without_an_index_changes_what_is_known(script):
    script.tell({"ALPHA": 1.0})
    script.say(value_message("ALPHA", 2.0, NO_INDEX, 1))
    assert script.settings.values == {"ALPHA": 2.0}


@pytest.mark.parametrize(("kind", "wire"), [("INT32", 1.6815581571897805e-44), ("INT32", 12.0), ("REAL32", 12.0)])
def test_a_whole_number_is_understood_however_it_is_sent(script, kind, wire):
    number = getattr(common, f"MAV_PARAM_TYPE_{kind}")
    script.say(common.MAVLink_param_value_message(b"ALPHA", wire, number, 1, 0))
    assert script.settings.values == {"ALPHA": 12.0}


def test_a_value_that_stays_is_a_refusal_though_no_error_comes(script):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 5.0)
    for _ in range(8):
        script.tell({"ALPHA": 1.0})
        script.wait(1)
    (row,) = script.settings.rows()
    assert (row["state"], row["reason"]) == ("refused", "it stays at 1")


def test_what_is_no_number_is_not_set(script):
    script.tell({"ALPHA": 1.0})
    for value in ("2", None, 1j, math.nan, 10**400):
        with pytest.raises(ValueError, match="ALPHA: expected a number"):
            script.settings.set("ALPHA", value)
    assert "PARAM_SET" not in script.names()


def test_a_text_about_another_value_is_no_reason(script):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 5.0)
    script.wait(0.1)
    script.say(common.MAVLink_param_error_message(*US, b"ALPHA", -1, 77))
    script.say(Text(Severity.WARNING, "RoSS: ALPHA: expected 0 to 3, got 99"))
    assert script.settings.rows()[0]["reason"] == "refused"
    script.say(Text(Severity.WARNING, "RoSS: ALPHA: expected 0 to 3, got 5"))
    assert script.settings.rows()[0]["reason"] == "expected 0 to 3, got 5"


def test_a_refusal_is_none_the_less_when_another_value_is_told_at_once(script):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 5.0)
    script.say(common.MAVLink_param_error_message(*US, b"ALPHA", -1, ParamError.VALUE_OUT_OF_RANGE))
    script.tell({"ALPHA": 2.0})
    assert (script.settings.values["ALPHA"], script.settings.state_of("ALPHA")[0]) == (2.0, "refused")


def test_what_was_sent_earlier_and_comes_after_it_does_not_end_a_change(script):
    """The network has changed the order of two values, or of their answers, as those of a slider."""
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 2.0)
    script.settings.set("ALPHA", 3.0)
    script.tell({"ALPHA": 3.0})
    script.tell({"ALPHA": 2.0})
    sent = script.names().count("PARAM_SET")
    script.wait(1.2)
    assert script.names().count("PARAM_SET") > sent
    script.tell({"ALPHA": 3.0})
    assert (script.settings.values["ALPHA"], script.settings.state_of("ALPHA")[0]) == (3.0, "set")


def test_the_answer_to_a_value_before_does_not_say_that_the_payload_keeps_it(script):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 2.0)
    script.settings.set("ALPHA", 3.0)
    script.tell({"ALPHA": 2.0})
    script.wait(9)
    assert script.settings.state_of("ALPHA")[0] == "no_answer"


def test_a_slider_that_ends_where_it_was_a_second_ago_is_set_when_its_own_answer_comes(script):
    script.tell({"ALPHA": 1.0})
    for value in (7.0, *range(8, 40), 7.0):
        script.settings.set("ALPHA", value)
    script.tell({"ALPHA": 7.0})
    assert script.settings.state_of("ALPHA")[0] == "sending"
    script.tell({"ALPHA": 39.0})
    script.wait(2.0)
    script.tell({"ALPHA": 7.0})
    assert (script.settings.values["ALPHA"], script.settings.state_of("ALPHA")[0]) == (7.0, "set")


def test_an_error_meant_for_somebody_else_refuses_nothing(script):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 5.0)
    error = ParamError.VALUE_OUT_OF_RANGE
    script.say(common.MAVLink_param_error_message(254, 190, b"ALPHA", -1, error))
    assert script.settings.rows()[0]["state"] == "sending"
    script.say(common.MAVLink_param_error_message(*US, b"ALPHA", -1, error))
    assert script.settings.rows()[0]["state"] == "refused"


def test_a_text_about_another_parameter_is_no_reason(script):
    script.tell({"ALPHA": 1.0})
    script.settings.set("ALPHA", 5.0)
    script.say(common.MAVLink_param_error_message(*US, b"ALPHA", -1, 77))
    script.say(Text(Severity.WARNING, "RoSS: BETA: found 5, wanted 1"))
    assert script.settings.rows()[0]["reason"] == "refused"


@pytest.mark.parametrize(
    ("name", "value"), [("NOBODY", 1.0), ("ALPHA", math.nan), ("ALPHA", 1e39), ("ALPHA", 10**400)], ids=range(4)
)
def test_what_cannot_be_set_says_so_at_once(script, name, value):
    script.tell({"ALPHA": 1.0})
    with pytest.raises(ValueError, match=r"expected .*, got "):
        script.settings.set(name, value)


def test_what_another_component_says_is_no_parameter_of_this_one(script):
    script.encoder = Encoder(1, 1)
    script.tell({"ALPHA": 1.0})
    assert script.settings.values == {}


@pytest.mark.parametrize("times", [2, *in_soak(98)])
def test_hostile_parameter_names_do_not_fill_the_memory(times):
    """Each has a name of its own, and no two agree on how many there are."""
    encoder, decoder, settings = Encoder(1, 191), Decoder(), ParamClient(lambda message, who: None, WHO, *US)
    odd = ["A{:x}", "<script>{:x}", "\x1b[2J{:x}", "__proto__{:x}"]

    def flood(first, last):
        for number in range(first, last):
            name = odd[number % len(odd)].format(number)[:16]
            for packet in decoder.feed(encoder.encode(value_message(name, 1.0, number % 65535, 65535 - number % 7))):
                settings.on_packet(packet, number / 1000)
            if number % 1000 == 0:
                settings.tick(number / 1000)
                settings.rows()

    flood(0, 2000)
    tracemalloc.start()
    flood(2000, 3000)
    before, _ = tracemalloc.get_traced_memory()
    flood(3000, 2000 + times * 1000)
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert after - before < 20_000 * times
    assert len(settings.rows()) <= MOST_PARAMETERS
