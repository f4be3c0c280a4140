"""The client for scripts: what it asks for, what it raises, what it tells, and what it leaves alone."""

import asyncio
import math

import pytest

import ports
from hand_station import PAYLOAD, HandStation
from ross_payload.ground import (
    LinkLost,
    NoPayload,
    Payload,
    RefusedByPayload,
    TaskCancelled,
    TaskFailed,
    UnknownParameter,
    connect,
)
from ross_payload.ground.client import events as e
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.params import value_message
from station_bench import Far

OTHER = ComponentId(2, 191)
NUMBERS = {"EXP_UNIT": 3.0, "EXP_MAX_ROT": 12.0}


def status(seconds, **how):
    told = {"state": ross.ROSS_STATE_IDLE, "earth": True, "heading": 0.0} | how
    return v.Status(round(seconds * 1e6), seconds, **told)


def source(index, azimuth_deg, estimate=1, **how):
    told = {"sigma": 0.02, "confidence": 0.9, "weight": 0.5, "earth": True, "resolved": True} | how
    return v.Source(estimate * 1_000_000, estimate, index, 2, math.radians(-azimuth_deg), **told)


class Scripted(HandStation):
    """A station whose payload answers every command with the results that a test wants; None: with nothing."""

    def __init__(self, *results, text=""):
        super().__init__()
        self.results, self.text = results, text
        self.refuses = False
        self.say(status(1.0))

    def commands(self):
        return [message for message, _ in self.sent if message.get_type() == "COMMAND_LONG"]

    def send(self, message, who=None):
        super().send(message, who)
        kind = message.get_type()
        if kind == "COMMAND_LONG" and message.command >= ross.MAV_CMD_ROSS_EXPLORE:
            for result in self.results:
                asyncio.get_running_loop().call_soon(self.answer, message.command, result)
            if self.text:
                asyncio.get_running_loop().call_later(0.1, self.say, v.Text(v.Severity.WARNING, self.text))
        elif kind == "COMMAND_LONG":
            self.answer(message.command, Result.UNSUPPORTED)
        elif kind == "PARAM_REQUEST_LIST":
            for index, (name, value) in enumerate(NUMBERS.items()):
                self.say(value_message(name, value, index, len(NUMBERS)))
        elif kind == "PARAM_SET" and not self.refuses:
            self.say(value_message("EXP_UNIT", message.param_value, 0, len(NUMBERS)))

    def answer(self, number, result):
        us = self.system_id, self.component_id
        self.say(common.MAVLink_command_ack_message(number, result, 255, 0, *us))


def with_payload(station, work):
    async def claim():
        async with Payload(station, PAYLOAD) as payload:
            return await work(payload)

    return asyncio.run(asyncio.wait_for(claim(), 60))


async def raised(request):
    with pytest.raises(Exception) as caught:
        await request
    return caught.value


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

    assert isinstance(asyncio.run(asyncio.wait_for(claim(), 60)), LinkLost)


def test_what_happens_comes_as_events_in_its_order():
    station = Scripted(Result.ACCEPTED)

    async def work(payload):
        events = payload.events()
        station.say(status(2.0, state=ross.ROSS_STATE_EXPLORE_LISTEN))
        station.say(source(0, 90.0))
        station.say(source(0, 95.0, estimate=2))
        station.say(status(3.0, state=ross.ROSS_STATE_RUN, target=0, target_found=True, fault=True))
        station.say(v.Text(v.Severity.WARNING, "RoSS: fault: it slips"))
        station.say(status(4.0, state=ross.ROSS_STATE_RUN))
        await payload.rearm()
        return [event async for event, _ in zip_async(events, range(10))]

    happened = with_payload(station, work)
    assert [type(each) for each in happened] == [
        e.StateChanged, e.SourceFound, e.SourceMoved, e.StateChanged, e.FaultRaised, e.TargetFound, e.TextReceived,
        e.FaultCleared, e.TargetLost, e.TaskProgress,
    ]  # fmt: skip
    changed, found, moved, running, _, target, text, *_, asked = happened
    assert (changed.before, changed.state, running.state) == ("idle", "explore_listen", "run")
    assert (found.source.azimuth_deg, moved.from_deg) == pytest.approx((90.0, 90.0))
    assert (moved.source.azimuth_deg, target.source) == (pytest.approx(95.0), 0)
    assert (text.text, asked.request, asked.state) == ("RoSS: fault: it slips", "rearm", "sent")


async def zip_async(stream, limit):
    for each in limit:
        yield await anext(stream), each


def test_every_iteration_gets_every_event_and_ends_with_the_client():
    station = Scripted()

    async def claim():
        async with Payload(station, PAYLOAD) as payload:
            streams = payload.events(), payload.events()
            station.say(status(2.0, state=ross.ROSS_STATE_RUN))
        return [[event async for event in stream] for stream in streams]

    one, other = asyncio.run(claim())
    assert [type(each) for each in one] == [e.StateChanged]
    assert one == other


def test_a_restart_and_lost_contact_are_told():
    station = Scripted()

    async def work(payload):
        events = payload.events()
        station.later = 4.0
        lost = await anext(events)
        station.say(status(20.0))
        restored = await anext(events)
        station.say(status(1.0))
        return lost, restored, await anext(events)

    kinds = [type(each) for each in with_payload(station, work)]
    assert kinds == [e.ContactLost, e.ContactRestored, e.PayloadRestarted]


def test_what_others_say_is_no_event():
    station = Scripted()

    async def claim():
        async with Payload(station, PAYLOAD) as payload:
            events = payload.events()
            station.say(status(2.0, state=ross.ROSS_STATE_RUN), who=OTHER)
        return [event async for event in events]

    assert asyncio.run(claim()) == []


def test_exploring_returns_the_sources():
    station = Scripted(Result.ACCEPTED)
    station.say(source(0, 90.0), source(1, 200.0))
    found = with_payload(station, lambda payload: payload.explore())
    assert [each.source for each in found] == [0, 1]
    assert [each.azimuth_deg for each in found] == pytest.approx([90.0, 200.0])


def test_parameters_are_read_and_set_as_a_mapping():
    station = Scripted()

    async def work(payload):
        names = [name async for name in payload.parameters]
        return names, await payload.parameters["EXP_UNIT"], await payload.parameters.set("EXP_UNIT", 2.5)

    assert with_payload(station, work) == (list(NUMBERS), 3.0, 2.5)


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


# ---------------------------------------------------------------------------------------------- connecting


async def test_the_only_payload_is_taken():
    port = ports.free_port()

    with Far(port) as far:
        saying = asyncio.create_task(beating(far))
        async with connect(f"udpin:127.0.0.1:{port}") as payload:
            assert (str(payload.id), payload.view["pointing"]["heading"]) == (
                "1-191",
                pytest.approx(331.35, abs=0.1),
            )
        saying.cancel()


async def test_of_several_one_must_be_named():
    port = ports.free_port()

    with Far(port) as one, Far(port, system=2) as other:
        saying = [asyncio.create_task(beating(far)) for far in (one, other)]
        with pytest.raises(NoPayload, match="got 1-191, 2-191") as several:
            async with connect(f"udpin:127.0.0.1:{port}"):
                pass
        assert several.value.received == ("1-191", "2-191")
        async with connect(f"udpin:127.0.0.1:{port}", payload="2-191") as payload:
            assert payload.id == OTHER
        with pytest.raises(NoPayload, match=r"expected payload 3-191 .*got 1-191, 2-191"):
            async with connect(f"udpin:127.0.0.1:{port}", payload="3-191", timeout_s=0.5):
                pass
        for each in saying:
            each.cancel()


async def test_nothing_at_all_is_told_with_what_to_do():
    port = ports.free_port()

    with pytest.raises(NoPayload, match=rf"nothing received on udpin:127\.0\.0\.1:{port}"):
        async with connect(f"udpin:127.0.0.1:{port}", timeout_s=0.2):
            pass


async def test_an_id_that_is_none_is_refused_at_once():
    with pytest.raises(ValueError, match="expected system-component"):
        async with connect("udpin:127.0.0.1:0", payload="drone"):
            pass


async def beating(far):
    """Let a payload say how it is, until cancelled."""
    seconds = 1.0
    while True:
        far.say(v.Status(round(seconds * 1e6), seconds, 0, earth=True, heading=0.5))
        seconds += 0.1
        await asyncio.sleep(0.05)
