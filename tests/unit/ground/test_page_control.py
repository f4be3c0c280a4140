"""Who orders through the page: two browsers, one payload."""

import asyncio

import pytest

from ground_page import browser, page
from hand_station import HandStation
from ross_payload.ground.web.page_state import CONTROL_GRACE_S, Control
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.values import Audio

TURN = {"kind": "turn", "heading": 40}


def there():
    station = HandStation()
    station.say(Audio(time_usec=0))
    return station


def commands(station):
    return [message.command for message, _ in station.sent if message.get_type() == "COMMAND_LONG"]


async def test_an_order_goes_to_the_payload_and_its_fate_comes_back():
    station = there()
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.say(type="order", id="1-191", order=TURN)
        told = await one.next("payload", lambda message: message["sections"].get("orders"))
        doing = told["sections"]["orders"][-1]
        assert doing["words"] == "turn to 40 deg"
        assert doing["state"] == "sent"
        assert commands(station)[-1] == ross.MAV_CMD_ROSS_TURN
        message, who = next(each for each in station.sent if each[0].get_type() == "COMMAND_LONG")
        assert message.param1 == 40.0
        assert str(who) == "1-191"
        station.say(acknowledged(ross.MAV_CMD_ROSS_TURN, common.MAV_RESULT_ACCEPTED))
        await one.next("payload", lambda message: states(message)[-1:] == ["done"])


def acknowledged(command, result):
    return common.MAVLink_command_ack_message(command, result, 0, 0, 254, 190)


def states(message):
    return [each["state"] for each in message["sections"].get("orders", [])]


async def test_an_order_that_nobody_answers_is_told_to_be_so():
    station = there()
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.say(type="order", id="1-191", order={"kind": "park"})
        await one.next("payload", lambda message: states(message) == ["sent"])
        for _ in range(8):
            station.later += 1.0
            await asyncio.sleep(0.15)
        await one.next("payload", lambda message: states(message) == ["no_answer"])
        assert commands(station).count(ross.MAV_CMD_ROSS_PARK) > 1


async def test_the_first_who_orders_has_control_and_the_other_is_refused():
    station = there()
    async with page(station) as served, browser(served.url) as one, browser(served.url) as other:
        mine = (await one.next("hello"))["you"]
        await one.say(type="order", id="1-191", order=TURN)
        assert (await one.next("control", lambda message: message["holder"]))["yours"]
        told = await other.next("control", lambda message: message["holder"])
        assert told["holder"] == mine
        assert not told["yours"]
        await other.say(type="order", id="1-191", order={"kind": "explore"})
        refused = await other.next("refused")
        assert refused["what"] == "explore"
        assert refused["reason"] == f"{told['name']} has control: take control first"
        assert ross.MAV_CMD_ROSS_EXPLORE not in commands(station)


async def test_control_that_is_taken_is_seen_by_both():
    station = there()
    async with page(station) as served, browser(served.url) as one, browser(served.url) as other:
        await one.say(type="control", take=True)
        await one.next("control", lambda message: message["yours"])
        await other.say(type="control", take=True)
        await other.next("control", lambda message: message["yours"])
        await one.next("control", lambda message: message["holder"] and not message["yours"])
        await other.say(type="control", take=False)
        await one.next("control", lambda message: message["holder"] is None)
        await one.say(type="order", id="1-191", order=TURN)
        await one.next("control", lambda message: message["yours"])


async def test_a_stop_is_obeyed_from_everybody_and_takes_no_control():
    station = there()
    async with page(station) as served, browser(served.url) as one, browser(served.url) as other:
        await one.say(type="control", take=True)
        await one.next("control", lambda message: message["yours"])
        await other.say(type="watch", id="1-191")
        await other.say(type="order", id="1-191", order={"kind": "stop"})
        await other.next("payload", lambda message: states(message) == ["sent"])
        assert ross.MAV_CMD_ROSS_STOP in commands(station)
        await one.say(type="order", id="1-191", order=TURN)
        await other.next("payload", lambda message: len(states(message)) == 2)


async def test_a_stop_is_sent_to_a_payload_that_was_not_heard_yet():
    station = HandStation()
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="order", id="1-191", order={"kind": "stop"})
        await one.say(type="order", id="1-191", order=TURN)
        assert "expected a payload that was received, got" in (await one.next("refused"))["reason"]
        assert set(commands(station)) == {ross.MAV_CMD_ROSS_STOP}


async def test_a_browser_that_comes_back_in_time_still_has_control():
    station = there()
    async with page(station) as served, browser(served.url) as other:
        async with browser(served.url) as one:
            mine = (await one.next("hello"))["you"]
            await one.say(type="control", take=True)
            await one.next("control", lambda message: message["yours"])
        async with browser(served.url, you=mine) as again:
            assert (await again.next("hello"))["you"] == mine
            assert (await again.next("control"))["yours"]
            station.later = CONTROL_GRACE_S + 1
            await again.next("fleet")
            await again.next("fleet")
        station.later = 2 * CONTROL_GRACE_S + 2
        await other.next("control", lambda message: message["holder"] is None)


async def test_nobody_takes_the_id_of_a_browser_that_is_there():
    async with page(there()) as served, browser(served.url) as one:
        mine = (await one.next("hello"))["you"]
        await one.say(type="control", take=True)
        async with browser(served.url, you=mine) as other:
            assert (await other.next("hello"))["you"] != mine
            assert not (await other.next("control", lambda message: message["holder"]))["yours"]


async def test_a_browser_whose_network_changed_takes_the_place_of_its_dead_socket():
    """Its old way is silent, and has not been missed yet."""
    async with page(there()) as served, browser(served.url) as one, browser(served.url) as other:
        hello = await one.next("hello")
        await one.say(type="control", take=True)
        await one.next("control", lambda message: message["yours"])
        async with browser(served.url, you=f"{hello['you']}&proof={hello['proof']}") as again:
            assert await again.next("hello") == hello
            assert (await again.next("control"))["yours"]
            with pytest.raises(TypeError):  # the socket is closed
                await one.next("nothing")
            await again.say(type="order", id="1-191", order=TURN)
            await again.say(type="control", take=False)
            await other.next("control", lambda message: message["holder"] is None)
            assert not any(each["type"] == "refused" for each in again.got)


async def test_a_browser_that_returns_has_the_same_proof():
    async with page(there()) as served:
        async with browser(served.url) as one:
            hello = await one.next("hello")
        async with browser(served.url, you=f"{hello['you']}&proof={hello['proof']}") as again:
            assert await again.next("hello") == hello


async def test_what_one_browser_has_shown_is_no_proof_of_the_next_one_with_its_id():
    """Ids are few, and given again; two that could take each other's place would do so for ever."""
    async with page(there()) as served:
        async with browser(served.url) as one:
            hello = await one.next("hello")
        async with browser(served.url, you=hello["you"]) as other:
            assert (await other.next("hello"))["you"] == hello["you"]
            async with browser(served.url, you=f"{hello['you']}&proof={hello['proof']}") as again:
                assert (await again.next("hello"))["you"] != hello["you"]


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ({"id": "1-191", "order": {"kind": "dance"}}, "kind: expected one of"),
        ({"id": "1-191", "order": {"kind": "turn"}}, "heading: expected -360 to 360, got nothing"),
        ({"id": "1-191", "order": {"kind": "turn", "heading": float("nan")}}, "heading: expected -360 to 360, got NaN"),
        ({"id": "1-191", "order": {"kind": "turn", "heading": "9"}}, "heading: expected -360 to 360, got '9'"),
        ({"id": "1-191", "order": {"kind": "listen", "source": 1.5}}, "source: expected a whole number, got 1.5"),
        ({"id": "1-191", "order": {"kind": "record"}}, "on: expected true or false, got nothing"),
        (
            {"id": "1-191", "order": {"kind": "cancel", "number": 7}},
            "number: expected that of an order to 1-191, got 7",
        ),
        ({"id": "1-191", "order": {"kind": ["stop"]}}, "kind: expected one of"),
        ({"id": "1-191", "order": "stop"}, "order: expected an object with a kind, got stop"),
        ({"id": "3-191", "order": TURN}, "id: expected a payload that was received, got 3-191"),
    ],
)
async def test_an_order_that_cannot_be_meant_reaches_no_payload_and_takes_no_control(message, reason):
    station = there()
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="order", **message)
        assert reason in (await one.next("refused"))["reason"]
        assert not commands(station)
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        assert not any(each.get("yours") for each in one.got)


async def test_an_order_can_be_cancelled_by_its_number():
    station = there()
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.say(type="order", id="1-191", order=TURN)
        told = await one.next("payload", states)
        number = told["sections"]["orders"][-1]["number"]
        await one.say(type="order", id="1-191", order={"kind": "cancel", "number": number})
        await one.say(type="order", id="1-191", order={"kind": "record", "on": True})
        await one.next("payload", lambda message: len(states(message)) == 2)
        kinds = [message.get_type() for message, _ in station.sent]
        assert "COMMAND_CANCEL" in kinds


def parameter(name, value, index=0, count=1):
    return common.MAVLink_param_value_message(name.encode(), value, common.MAV_PARAM_TYPE_REAL32, count, index)


def values(message):
    return {row["name"]: (row["value"], row["state"]) for row in message["sections"].get("parameters", [])}


def asked(station, kind):
    return [message for message, _ in station.sent if message.get_type() == kind]


async def test_parameters_are_asked_for_when_somebody_watches_and_not_before():
    station = there()
    async with page(station) as served, browser(served.url) as one:
        await one.next("fleet")
        await one.next("fleet")
        assert not station.sent
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        await one.next("fleet")
        assert asked(station, "PARAM_REQUEST_LIST")
        station.say(parameter("EXP_UNIT", 2.0))
        await one.next("payload", lambda message: values(message) == {"EXP_UNIT": (2.0, "known")})
        await one.say(type="refresh", id="1-191")
        await one.next("payload", lambda message: message["sections"].get("parameters") == [])
        assert len(asked(station, "PARAM_REQUEST_LIST")) == 2


async def test_a_parameter_is_set_by_who_has_control_and_read_back():
    station = there()
    async with page(station) as served, browser(served.url) as one, browser(served.url) as other:
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        station.say(parameter("EXP_UNIT", 2.0))
        await one.next("payload", values)
        await one.say(type="set", id="1-191", name="EXP_UNIT", value=3)
        await one.next("payload", lambda message: values(message).get("EXP_UNIT") == (2.0, "sending"))
        station.say(parameter("EXP_UNIT", 3.0))
        await one.next("payload", lambda message: values(message).get("EXP_UNIT") == (3.0, "set"))
        await other.say(type="set", id="1-191", name="EXP_UNIT", value=4)
        assert "has control" in (await other.next("refused"))["reason"]
        assert len(asked(station, "PARAM_SET")) == 1


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("NO_SUCH", 1, "expected the name of a parameter of 1-191, got 'NO_SUCH'"),
        ("EXP_UNIT", "1", "EXP_UNIT: expected a number, got 1"),
        ("EXP_UNIT", None, "EXP_UNIT: expected a number, got None"),
        ("EXP_UNIT", True, "EXP_UNIT: expected a number, got True"),
        ("EXP_UNIT", float("inf"), "EXP_UNIT: expected a number"),
        ("EXP_UNIT", 10**400, "int too large to convert to float"),
        (["EXP_UNIT"], 1, "expected the name of a parameter"),
    ],
)
async def test_a_parameter_that_cannot_be_meant_is_not_set(name, value, reason):
    station = there()
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="watch", id="1-191")
        await one.next("payload")
        station.say(parameter("EXP_UNIT", 2.0))
        await one.next("payload", values)
        await one.say(type="set", id="1-191", name=name, value=value)
        assert reason in (await one.next("refused"))["reason"]
        assert not asked(station, "PARAM_SET")


def test_control_waits_for_its_holder_for_the_grace_and_no_longer():
    control = Control()
    control.acquire("a1", "chrome")
    control.on_disconnect("a1", now=5.0)
    control.tick(5.0 + CONTROL_GRACE_S)
    assert control.holder == "a1"
    control.tick(5.1 + CONTROL_GRACE_S)
    assert control.holder is None


def test_who_gives_up_what_another_has_changes_nothing():
    control = Control()
    control.acquire("a1", "chrome")
    control.release("b2")
    control.on_disconnect("b2", now=0.0)
    control.tick(100.0)
    assert control.holder == "a1"
