"""The client for scripts: what it asks for, what it raises, and what it leaves alone."""

import asyncio
import math
import time

import numpy as np
import pytest

from hand_station import PAYLOAD
from ross_payload.ground import (
    LinkLost,
    NoPayload,
    Payload,
    RefusedByPayload,
    TaskCancelled,
    TaskFailed,
    UnknownParameter,
)
from ross_payload.ground.client import payload as payload_client
from ross_payload.ground.model.payload_state import PayloadState
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from scripted_station import NUMBERS, Scripted, raised, source, status, with_payload

OTHER = ComponentId(2, 191)


@pytest.mark.parametrize(
    ("ask", "number", "numbers"),
    [
        (lambda p: p.explore(), ross.MAV_CMD_ROSS_EXPLORE, ()),
        (lambda p: p.listen_to(2), ross.MAV_CMD_ROSS_LISTEN, (ross.ROSS_LISTEN_MODE_SOURCE, 2)),
        (lambda p: p.listen_at(90), ross.MAV_CMD_ROSS_LISTEN, (ross.ROSS_LISTEN_MODE_AZIMUTH, 0, 90)),
        (lambda p: p.find_voice(), ross.MAV_CMD_ROSS_LISTEN, (ross.ROSS_LISTEN_MODE_VOICE,)),
        (lambda p: p.find_voice([10, 75], first=1), ross.MAV_CMD_ROSS_INFORM, (1, 10, 75)),
        (lambda p: p.turn(-40), ross.MAV_CMD_ROSS_TURN, (-40,)),
        (lambda p: p.park(), ross.MAV_CMD_ROSS_PARK, ()),
        (lambda p: p.home(), ross.MAV_CMD_ROSS_HOME, ()),
        (lambda p: p.measure_noise(3), ross.MAV_CMD_ROSS_MEASURE_NOISE, (3,)),
        (lambda p: p.stop(), ross.MAV_CMD_ROSS_STOP, ()),
        (lambda p: p.rearm(), ross.MAV_CMD_ROSS_REARM, ()),
        (lambda p: p.cancel(), ross.MAV_CMD_ROSS_CANCEL, ()),
        (lambda p: p.record(), ross.MAV_CMD_ROSS_RECORD, (1,)),
        (lambda p: p.record(False), ross.MAV_CMD_ROSS_RECORD, (0,)),
    ],
)
def test_every_request_is_its_command_and_ends_when_that_is_done(ask, number, numbers):
    station = Scripted(Result.IN_PROGRESS, Result.ACCEPTED)
    with_payload(station, ask)
    (command,) = station.commands()
    sent = [getattr(command, f"param{i}") for i in range(1, 8)]
    assert (command.command, tuple(sent[: len(numbers)])) == (number, numbers)
    assert not any(value > 0 for value in sent[len(numbers) :])


def test_azimuths_that_are_not_given_are_no_numbers():
    station = Scripted(Result.ACCEPTED)
    with_payload(station, lambda payload: payload.find_voice([10]))
    (command,) = station.commands()
    assert (command.param1, command.param2, math.isnan(command.param3), math.isnan(command.param7)) == (
        -1,
        10,
        True,
        True,
    )


def test_too_many_azimuths_are_not_sent():
    station = Scripted(Result.ACCEPTED)
    error = with_payload(station, lambda payload: raised(payload.find_voice([0] * 7)))
    assert isinstance(error, ValueError)
    assert station.commands() == []


@pytest.mark.parametrize(
    "ask",
    [
        lambda payload: payload.listen_to(None),
        lambda payload: payload.listen_at(None),
        lambda payload: payload.turn(10**400),
        lambda payload: payload.stop_stream(to=("", 0)),
        lambda payload: payload.stop_stream("0"),
        lambda payload: payload.stop_stream(to="127.0.0.1:5004"),
        lambda payload: payload.stream("target", to=("127.0.0.1",)),
        lambda payload: payload.find_voice(first=0),
        lambda payload: payload.find_voice(5),
        lambda payload: payload.request("turn"),
    ],
)
def test_what_was_not_found_is_no_order_to_do_something_else(ask):
    station = Scripted(Result.ACCEPTED)
    error = with_payload(station, lambda payload: raised(ask(payload)))
    assert isinstance(error, ValueError)
    assert station.commands() == []


NOTHING = "was not answered: nothing was sent: the client is"
OUTSIDE = [
    lambda payload: payload.turn(10),
    lambda payload: payload.stop(),
    lambda payload: payload.stream("mixture", to=("127.0.0.1", 5004)),
    lambda payload: payload.session_description(0),
    lambda payload: payload.parameters.set("EXP_UNIT", 2.5),
    lambda payload: payload.parameters["EXP_UNIT"],
]


@pytest.mark.parametrize("ask", OUTSIDE)
async def test_a_client_that_is_not_open_sends_nothing_and_says_so_at_once(ask):
    station = Scripted(Result.ACCEPTED)
    payload = Payload(station, PAYLOAD)
    async with asyncio.timeout(1):
        error = await raised(ask(payload))
    assert isinstance(error, LinkLost)
    assert f"{NOTHING} not open: use it inside of 'async with'" in str(error)
    assert station.sent == []


@pytest.mark.parametrize("ask", OUTSIDE)
async def test_a_client_that_is_closed_sends_nothing_and_says_so_at_once(ask):
    station = Scripted(Result.ACCEPTED)
    async with Payload(station, PAYLOAD) as payload:
        pass
    station.sent.clear()
    async with asyncio.timeout(1):
        error = await raised(ask(payload))
    assert isinstance(error, LinkLost)
    assert f"{NOTHING} closed" in str(error)
    assert station.sent == []


@pytest.mark.parametrize("who", [OTHER, "1-191", None])
def test_a_payload_that_was_not_received_is_named_with_those_that_were(who):
    with pytest.raises(NoPayload, match=r"1-191 is$") as caught:
        Payload(Scripted(), who)
    assert caught.value.received == ("1-191",)


@pytest.mark.parametrize("name", [5, None])
def test_a_name_that_is_no_text_is_unknown(name):
    error = with_payload(Scripted(), lambda payload: raised(payload.parameters[name]))
    assert isinstance(error, UnknownParameter)


def test_an_azimuth_of_zero_in_an_array_is_one():
    station = Scripted(Result.ACCEPTED)
    with_payload(station, lambda payload: payload.find_voice(np.array([0.0])))
    assert [command.command for command in station.commands()] == [ross.MAV_CMD_ROSS_INFORM]


@pytest.mark.parametrize("heading", ["10", None, 1e39, [10.0]], ids=str)
def test_what_is_no_number_is_not_sent_and_a_stop_still_is(heading):
    station = Scripted(Result.ACCEPTED)

    async def work(payload):
        error = await raised(payload.turn(heading))
        sent = station.commands()
        await payload.stop()
        return error, sent

    error, sent = with_payload(station, work)
    assert isinstance(error, ValueError)
    assert f"got Turn(heading={heading!r})" in str(error)
    assert sent == []
    assert [command.command for command in station.commands()] == [ross.MAV_CMD_ROSS_STOP]


@pytest.mark.parametrize(
    ("results", "kind"),
    [
        ((Result.TEMPORARILY_REJECTED,), RefusedByPayload),
        ((Result.DENIED,), RefusedByPayload),
        ((Result.IN_PROGRESS, Result.FAILED), TaskFailed),
        ((Result.IN_PROGRESS, Result.CANCELLED), TaskCancelled),
    ],
)
def test_what_is_not_done_raises_what_became_of_it(results, kind):
    error = with_payload(Scripted(*results), lambda payload: raised(payload.turn(10)))
    assert (type(error), error.request) == (kind, "turn to 10 deg")
    assert error.reason


def test_a_refusal_has_the_payloads_words_which_come_after_it():
    station = Scripted(Result.TEMPORARILY_REJECTED, text="RoSS: turn refused: stopped: re-arm first")
    error = with_payload(station, lambda payload: raised(payload.turn(10)))
    assert error.reason == "stopped: re-arm first"
    assert str(error) == "turn to 10 deg was refused: stopped: re-arm first"


def test_a_request_that_nobody_answers_is_repeated_and_then_lost():
    station = Scripted()
    error = with_payload(station, lambda payload: raised(payload.turn(10)))
    assert isinstance(error, LinkLost)
    assert [command.confirmation for command in station.commands()] == [0, 1, 2, 3, 4]


def test_a_stop_is_lost_after_two_seconds_though_nothing_came_since_the_payload_was_received():
    station = Scripted()
    asked = time.monotonic()
    error = with_payload(station, lambda payload: raised(payload.stop()))
    assert isinstance(error, LinkLost)
    assert time.monotonic() - asked < 6.0


def test_waiting_no_longer_does_not_end_the_task():
    station = Scripted(Result.IN_PROGRESS)

    async def work(payload):
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.2):
                await payload.turn(10)
        await asyncio.sleep(0.2)

    with_payload(station, work)
    assert {command.command for command in station.commands()} == {ross.MAV_CMD_ROSS_TURN}
    assert not [message for message, _ in station.sent if message.get_type() == "COMMAND_CANCEL"]


def test_a_closed_client_lets_nobody_wait():
    station = Scripted(Result.IN_PROGRESS)

    async def work(payload):
        waiting = asyncio.create_task(raised(payload.turn(10)))
        await asyncio.sleep(0.1)
        return waiting

    async def claim():
        async with Payload(station, PAYLOAD) as payload:
            waiting = await work(payload)
        return await waiting

    lost = asyncio.run(asyncio.wait_for(claim(), 60))
    assert isinstance(lost, LinkLost)
    assert (lost.request, lost.reason) == ("turn to 10 deg", "the client is closed")


def test_exploring_returns_the_sources_that_are_told_after_its_acknowledgement():
    station = Scripted(Result.ACCEPTED)
    station.say(source(0, 10.0, 1), source(1, 20.0, 1))  # what was believed on the way
    station.found = (source(0, 90.0, 2, final=True), source(1, 200.0, 2, final=True))
    found = with_payload(station, lambda payload: payload.explore())
    assert [each.source for each in found] == [0, 1]
    assert [each.azimuth_deg for each in found] == pytest.approx([90.0, 200.0])


async def heading_after_a_turn(payload):
    await payload.turn(10)
    return payload.view["pointing"]["heading"]


def test_after_a_turn_the_view_shows_where_the_axis_came_to_rest():
    station = Scripted(Result.ACCEPTED)
    moving, still = (status(2.0 + late, heading=math.radians(-9 - late), settled=late == 1) for late in (0, 1))
    station.turned = (moving, still)
    assert with_payload(station, heading_after_a_turn) == pytest.approx(10)


def test_a_turn_ends_also_where_the_axis_never_rests(monkeypatch):
    monkeypatch.setattr(payload_client, "SETTLED_TIMEOUT_S", 0.3)
    station = Scripted(Result.ACCEPTED)
    station.turned = (status(2.0, heading=math.radians(-9)),)
    assert with_payload(station, heading_after_a_turn) == pytest.approx(9)


def test_exploring_a_silent_room_returns_nobody():
    station = Scripted(Result.ACCEPTED)
    station.say(source(0, 10.0, 1), source(1, 20.0, 1))
    assert with_payload(station, lambda payload: payload.explore()) == ()


def test_what_was_found_and_does_not_arrive_is_not_replaced_by_what_was_believed_before(monkeypatch):
    monkeypatch.setattr(payload_client, "ESTIMATE_TIMEOUT_S", 0.3)
    station = Scripted(Result.ACCEPTED)
    station.say(source(0, 10.0, 1, final=True), source(1, 20.0, 1, final=True))
    station.found = (source(0, 90.0, 2, final=True),)  # the second one is lost
    lost = with_payload(station, lambda payload: raised(payload.explore()))
    assert isinstance(lost, LinkLost)
    assert "what was found did not arrive" in str(lost)


def test_parameters_are_read_and_set_as_a_mapping():
    station = Scripted()

    async def work(payload):
        names = [name async for name in payload.parameters]
        return names, await payload.parameters["EXP_UNIT"], await payload.parameters.set("EXP_UNIT", 2.5)

    assert with_payload(station, work) == (list(NUMBERS), 3.0, 2.5)


def test_a_parameter_is_set_while_the_list_is_read_again_after_an_outage():
    station = Scripted()

    async def work(payload):
        await payload.parameters["EXP_UNIT"]
        station.lists = False
        payload.parameters.settings.on_state(PayloadState(PAYLOAD, 0.0, 1e6))
        assert not payload.parameters.settings.complete
        return await asyncio.wait_for(payload.parameters.set("EXP_UNIT", 2.5), 1.0)

    assert with_payload(station, work) == 2.5


def test_the_list_of_parameters_is_not_asked_for_before_it_is_wanted():
    station = Scripted()
    with_payload(station, lambda payload: asyncio.sleep(0.2))
    assert station.sent == []


def test_an_unknown_parameter_is_a_key_error_that_names_its_neighbours():
    station = Scripted()

    async def work(payload):
        return await raised(payload.parameters["EXP_UNITS"]), await raised(payload.parameters.set("NONE", 1))

    read, put = with_payload(station, work)
    assert isinstance(read, UnknownParameter) and isinstance(read, KeyError)
    assert "EXP_UNIT" in str(read)
    assert isinstance(put, UnknownParameter)


def test_a_parameter_that_stays_as_it_is_raises():
    station = Scripted()
    station.refuses = True

    async def work(payload):
        await payload.parameters["EXP_UNIT"]
        waiting = asyncio.create_task(raised(payload.parameters.set("EXP_UNIT", 99)))
        await asyncio.sleep(0)
        station.say(common.MAVLink_param_error_message(254, 190, b"EXP_UNIT", -1, 2))
        station.say(v.Text(v.Severity.WARNING, "RoSS: EXP_UNIT: expected 0.5 to 10, got 99"))
        return await waiting

    error = with_payload(station, work)
    assert (type(error), error.request) == (RefusedByPayload, "EXP_UNIT = 99")
    assert error.reason == "expected 0.5 to 10, got 99"


def test_two_values_for_one_parameter_at_once_are_each_set_and_returned():
    class Slow(Scripted):
        def send(self, message, who=None):
            late = 0.05 if message.get_type() == "PARAM_SET" else 0.0
            asyncio.get_running_loop().call_later(late, super().send, message, who)

    station = Slow()

    async def work(payload):
        return await asyncio.gather(*(payload.parameters.set("EXP_UNIT", value) for value in (1.5, 2.5)))

    assert with_payload(station, work) == [1.5, 2.5]
    sent = [message.param_value for message, _ in station.sent if message.get_type() == "PARAM_SET"]
    assert sent == [1.5, 2.5]


def test_a_value_that_waited_for_another_one_is_set_though_the_payload_restarted_meanwhile():
    station = Scripted()

    async def work(payload):
        await payload.parameters["EXP_UNIT"]
        station.say(status(20.0))
        station.refuses = True  # no answer yet
        waiting = [asyncio.create_task(payload.parameters.set("EXP_UNIT", value)) for value in (1.5, 2.5)]
        await asyncio.sleep(0.1)
        station.refuses = False
        station.say(status(1.0))  # its clock begins again
        return await asyncio.gather(*waiting, return_exceptions=True)

    first, second = with_payload(station, work)
    assert isinstance(first, LinkLost)
    assert second == 2.5


def test_why_a_value_was_refused_is_no_reason_for_the_next_one():
    station = Scripted()
    station.refuses = True

    async def refused(payload, value, *texts):
        waiting = asyncio.create_task(raised(payload.parameters.set("EXP_UNIT", value)))
        await asyncio.sleep(0.1)
        station.say(common.MAVLink_param_error_message(254, 190, b"EXP_UNIT", -1, 2), *texts)
        return await waiting

    async def work(payload):
        await payload.parameters["EXP_UNIT"]
        text = v.Text(v.Severity.WARNING, "RoSS: EXP_UNIT: expected 0.5 to 10, got 99")
        return await refused(payload, 99, text), await refused(payload, -1)

    first, second = with_payload(station, work)
    assert (first.reason, second.reason) == ("expected 0.5 to 10, got 99", "out of range")


def elsewhere(ask):
    """Return what ``ask`` raises on the event loop of another thread, while that of the client goes on."""

    async def work(payload):
        error = await asyncio.to_thread(lambda: asyncio.run(raised(asyncio.wait_for(ask(payload), 3))))
        await asyncio.sleep(0.2)
        return error

    return work


@pytest.mark.parametrize(
    "ask",
    [
        lambda payload: payload.turn(5),
        lambda payload: payload.until(lambda: None),
        lambda payload: anext(payload.events()),
        lambda payload: payload.parameters.list(),
        lambda payload: payload.parameters.set("EXP_UNIT", 2.5),
    ],
)
def test_the_loop_of_another_thread_is_refused_at_once(ask):
    """Nobody would wake it, and the answer would never come."""
    station = Scripted(Result.ACCEPTED)
    error = with_payload(station, elsewhere(ask))
    assert isinstance(error, RuntimeError)
    assert "run_coroutine_threadsafe" in str(error)
    assert station.commands() == []


def test_a_stop_from_the_loop_of_another_thread_is_sent_all_the_same():
    station = Scripted(Result.ACCEPTED)
    error = with_payload(station, elsewhere(lambda payload: payload.stop()))
    assert isinstance(error, RuntimeError)
    assert [command.command for command in station.commands()] == [ross.MAV_CMD_ROSS_STOP]
