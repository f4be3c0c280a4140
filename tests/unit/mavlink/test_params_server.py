"""Parameters over the air: a ground station with pymavlink, and the server on the pump."""

import math
import struct

import pytest
from pymavlink.dialects.v20 import common

from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE
from ross_payload.mavlink.param_server import ParamServer
from ross_protocols.mavlink.dialect import ross

NAMES = tuple(TABLE)
COUNT = len(TABLE)


class Payload:
    """The server and what it tells; time moves in steps of 10 ms."""

    def __init__(self, sky, path=None):
        self.sky, self.clock, self.links, self.ground = sky, sky.clock, sky.links, sky.ground
        self.changes, self.texts, self.errors = [], [], []
        self.parameters = Parameters(Config(), path)
        component = self.links.component(191)
        self.server = ParamServer(
            component,
            self.parameters,
            lambda *change: self.changes.append(change),
            lambda _, text: self.texts.append(text),
            self.links.rates,
        )

    def wait(self, seconds):
        """Let time pass; return the PARAM_VALUEs that the ground station hears meanwhile."""
        heard = self.sky.wait(seconds, self.server)
        self.errors += [(one.param_id, one.error) for one in heard if one.get_type() == "PARAM_ERROR"]
        return [message for message in heard if message.get_type() == "PARAM_VALUE"]

    def list(self, target=(1, 191)):
        self.ground.send(ross.MAVLink_param_request_list_message(*target))

    def read(self, name="", index=-1, target=(1, 191)):
        self.ground.send(ross.MAVLink_param_request_read_message(*target, name.encode(), index))

    def set(self, name, value, kind=common.MAV_PARAM_TYPE_REAL32, target=(1, 191), seconds=0.1):
        self.ground.send(ross.MAVLink_param_set_message(*target, name.encode(), value, kind))
        return self.wait(seconds)


@pytest.fixture
def payload(sky, tmp_path):
    payload = Payload(sky(), tmp_path / "params.toml")
    yield payload
    payload.parameters.close()


def test_a_list_has_every_parameter_once_with_its_place_and_value(payload):
    payload.list()
    found = payload.wait(COUNT * 0.06)
    assert [message.param_id for message in found] == list(NAMES)
    assert [message.param_index for message in found] == list(range(COUNT))
    assert {message.param_count for message in found} == {COUNT}
    assert {message.param_type for message in found} == {common.MAV_PARAM_TYPE_REAL32}
    assert [message.param_value for message in found] == pytest.approx([payload.parameters.value(n) for n in NAMES])


def test_a_list_comes_in_portions_that_a_slow_link_can_carry(payload):
    """At 57600 baud half of the line is ours: 2880 bytes/s; a PARAM_VALUE is 37 bytes."""
    payload.list()
    per_second = len(payload.wait(0.2)) / 0.2
    assert 0 < per_second * 37 < 2880 / 2


@pytest.mark.parametrize("budget", [300, 600])
def test_a_list_loses_nothing_on_a_link_that_carries_little(sky, budget):
    payload = Payload(sky(max_bytes_s=budget))
    payload.list()
    assert [message.param_id for message in payload.wait(COUNT * 50 / (budget / 2) + 0.5)] == list(NAMES)
    assert payload.links.status()[0].dropped == 0


def test_a_slow_link_holds_no_other_one_up(sky):
    payload = Payload(sky(max_bytes_s=300))
    payload.list()
    payload.wait(0.1)
    payload.parameters.set("EXP_UNIT", 2.5)  # told everywhere
    assert [message.param_id for message in payload.wait(0.1)] == ["EXP_UNIT"]


def test_of_many_changes_at_once_a_link_that_carries_little_is_told_each(sky):
    payload = Payload(sky(max_bytes_s=300))
    heard = []
    for name in NAMES:  # as a ground station loads a file
        heard += payload.set(name, payload.parameters.value(name), seconds=0.04)
    assert {message.param_id for message in heard + payload.wait(COUNT * 50 / 150)} == set(NAMES)


def test_a_value_that_changes_all_the_time_holds_up_no_list_and_is_told_in_the_end(sky):
    payload = Payload(sky(max_bytes_s=300))
    payload.list()
    heard = []
    for number in range(100):
        heard += payload.set("TLM_STATUS_HZ", 1 + number % 2, seconds=0.2)
    assert {message.param_id for message in heard} == set(NAMES)
    told = [each for each in heard + payload.wait(1.0) if each.param_id == "TLM_STATUS_HZ"]
    assert told[-1].param_value == payload.parameters.value("TLM_STATUS_HZ")


def test_many_lists_at_once_are_not_more_than_one(payload):
    for _ in range(200):
        payload.list()
    assert len(payload.wait(5.0)) == COUNT


def test_one_is_read_by_name_and_by_index(payload):
    payload.read("EXP_UNIT")
    (by_name,) = payload.wait(0.1)
    payload.read(index=by_name.param_index)
    (by_index,) = payload.wait(0.1)
    assert by_name.to_dict() == by_index.to_dict()
    assert (by_name.param_id, by_name.param_value) == ("EXP_UNIT", 3.0)


@pytest.mark.parametrize(
    "request_", [{"name": "NOBODY"}, {"index": COUNT}, {"index": 32767}, {"name": "", "index": -1}]
)
def test_what_does_not_exist_is_an_error(payload, request_):
    payload.read(**request_)
    assert payload.wait(0.2) == []
    assert payload.errors == [(request_.get("name", ""), common.MAV_PARAM_ERROR_DOES_NOT_EXIST)]


def test_who_asks_everybody_for_what_we_do_not_have_hears_nothing_of_us(payload):
    payload.read("NOBODY", target=(1, 0))
    payload.set("NOBODY", 1.0, target=(0, 0))
    assert payload.errors == []


def test_who_asks_too_often_gets_no_more_errors(payload):
    for _ in range(200):
        payload.set("NOBODY", 1.0, seconds=0.01)
    assert 10 <= len(payload.errors) <= 30


def test_a_value_that_is_set_is_in_force_told_to_all_and_to_the_mission(payload):
    (answer,) = payload.set("EXP_UNIT", 2.3)
    assert answer.param_value == pytest.approx(2.3)
    assert payload.parameters.config.explore.unit_s == 2.3  # and not 2.2999999523162842
    assert payload.changes == [("EXP_UNIT", 2.3)]


def test_what_is_in_force_already_is_answered_and_changes_nothing(payload):
    assert len(payload.set("EXP_UNIT", 3.0)) == 1
    assert payload.changes == []


@pytest.mark.parametrize(
    ("name", "value"),
    [("EXP_UNIT", math.nan), ("EXP_UNIT", math.inf), ("EXP_UNIT", 0.0), ("EXP_MAX_ROT", 3.5), ("EXP_MIN_ROT", 20)],
)
def test_what_is_not_allowed_is_answered_with_the_old_value_and_a_text(payload, name, value):
    before = payload.parameters.value(name)
    (answer,) = payload.set(name, value)
    assert answer.param_value == pytest.approx(before)
    assert payload.changes == []
    assert payload.errors == [(name, common.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE)]
    (text,) = payload.texts
    assert text.startswith(f"{name}: ")


KINDS = {
    "UINT8": "<B3x", "INT8": "<b3x", "UINT16": "<H2x", "INT16": "<h2x", "UINT32": "<I", "INT32": "<i",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", ["as a float", "as bytes"])
def test_any_integer_type_is_understood_in_both_encodings(payload, kind, way):
    packed = struct.unpack("<f", struct.pack(KINDS[kind], 20))[0]
    payload.set("EXP_MAX_ROT", 20.0 if way == "as a float" else packed, getattr(common, f"MAV_PARAM_TYPE_{kind}"))
    assert payload.parameters.config.explore.max_rotations == 20


@pytest.mark.parametrize("kind", ["INT8", "INT16", "INT32"])
@pytest.mark.parametrize("way", ["as a float", "as bytes"])
def test_a_negative_integer_is_understood_in_both_encodings(payload, kind, way):
    packed = struct.unpack("<f", struct.pack(KINDS[kind], -3))[0]
    payload.set("XPL_CRITERION", -3.0 if way == "as a float" else packed, getattr(common, f"MAV_PARAM_TYPE_{kind}"))
    assert payload.parameters.value("XPL_CRITERION") == -3.0


def test_a_switch_is_set_by_an_integer_in_both_encodings(payload):
    payload.set("EXP_PIPELINED", struct.unpack("<f", b"\x01\0\0\0")[0], common.MAV_PARAM_TYPE_UINT8)
    assert payload.parameters.config.explore.pipelined
    payload.set("EXP_PIPELINED", 0.0, common.MAV_PARAM_TYPE_INT32)
    assert not payload.parameters.config.explore.pipelined


@pytest.mark.parametrize("kind", [common.MAV_PARAM_TYPE_REAL64, common.MAV_PARAM_TYPE_UINT64, 0, 77])
def test_other_types_are_taken_as_the_number_that_they_are(payload, kind):
    payload.set("EXP_UNIT", 4.0, kind)
    assert payload.parameters.value("EXP_UNIT") == 4.0


@pytest.mark.parametrize("target", [(2, 191), (1, 1), (1, 154)])
def test_requests_to_others_pass_by(payload, target):
    payload.list(target)
    payload.read("EXP_UNIT", target=target)
    assert payload.set("EXP_UNIT", 2.0, target=target, seconds=0.3) == []
    assert payload.parameters.config == Config()


@pytest.mark.parametrize("target", [(1, 0), (0, 0)])
def test_a_list_for_all_is_for_us_too(payload, target):
    payload.list(target)
    assert len(payload.wait(2.0)) == COUNT


def test_who_may_not_order_gets_nothing_and_sets_nothing(sky):
    payload = Payload(sky(accept=(250,)))
    payload.list()
    assert payload.set("EXP_UNIT", 2.0, seconds=1.0) == []
    assert payload.parameters.config == Config()
    payload.parameters.close()


def test_an_operator_hears_what_became_of_the_file(sky, tmp_path):
    path = tmp_path / "params.toml"
    path.write_text("half a fi")
    payload = Payload(sky(), path)
    payload.wait(0.1)
    payload.parameters.close()
    assert any("kept as params.toml.unreadable" in text for text in payload.texts)


def test_an_operator_hears_once_that_nothing_can_be_saved(sky, tmp_path):
    (tmp_path / "state").write_text("a file where the folder should be")
    payload = Payload(sky(), tmp_path / "state" / "params.toml")
    payload.set("EXP_UNIT", 2.0)
    payload.set("EXP_UNIT", 2.5)
    payload.parameters.close()
    payload.wait(0.1)
    assert len([text for text in payload.texts if "cannot be written" in text]) == 1


def test_of_a_flood_of_values_the_mission_hears_a_trickle(payload):
    for step in range(100):
        for value in range(2, 52):
            payload.ground.send(ross.MAVLink_param_set_message(1, 191, b"EXP_UNIT", value + step % 2, 9))
        payload.wait(0.01)
    assert 20 <= len(payload.changes) <= 60
    payload.wait(1.0)
    (answer,) = payload.set("EXP_UNIT", 5.5)
    assert answer.param_value == 5.5


# ------------------------------------------------------------------------------------------- bad links

ODDS = [
    {"loss": 0.01},
    {"loss": 0.2},
    {"doubled": 0.3, "delayed": 0.3},
    {"loss": 0.2, "doubled": 0.2, "delayed": 0.2, "damaged": 0.1},
]


def fetched(payload, patience=20):
    """All parameters as a client fetches them: the list, then whatever is missing, until nothing is."""
    found = {}
    payload.list()
    for _ in range(patience):
        found |= {message.param_id: message.param_value for message in payload.wait(1.5)}
        missing = [index for index, name in enumerate(NAMES) if name not in found]
        if not missing:
            return found
        for index in missing:
            payload.read(index=index)
        if not found:
            payload.list()
    return found


@pytest.mark.parametrize("odds", ODDS, ids="+".join)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_on_a_bad_link_all_parameters_arrive_and_what_is_set_is_set(sky, odds, seed):
    payload = Payload(sky(**odds, seed=seed))
    wanted = {name: payload.parameters.value(name) for name in NAMES}
    assert fetched(payload) == pytest.approx(wanted)
    for _ in range(30):  # a client sets again until it hears the new value
        if any(m.param_id == "EXP_UNIT" and m.param_value == 5.0 for m in payload.set("EXP_UNIT", 5.0, seconds=0.5)):
            break
    payload.wait(5.0)
    payload.parameters.close()
    assert payload.changes == [("EXP_UNIT", 5.0)]
    assert fetched(payload) == pytest.approx(wanted | {"EXP_UNIT": 5.0})


def test_what_is_set_by_another_way_is_told_to_everybody(payload):
    payload.parameters.set("EXP_UNIT", 2.5)
    payload.parameters.set("XPL_RUNS", 3)
    assert [(told.param_id, told.param_value) for told in payload.wait(0.2)] == [("EXP_UNIT", 2.5), ("XPL_RUNS", 3.0)]
    assert payload.wait(0.5) == []
