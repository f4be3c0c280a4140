"""Orders over REST go the way of those from the page: control, the payload's words, progress, cancel, and a stop."""

import asyncio

import pytest

from ground_page import browser, page
from hand_station import HandStation
from rest_program import PAYLOAD, program
from ross_payload.ground.web.page_state import CONTROL_GRACE_S
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from scripted_station import Scripted, status

TURN = {"kind": "turn", "heading": 40}


def there():
    station = HandStation()
    station.say(status(1.0))
    return station


def commands(station):
    return [message.command for message, _ in station.sent if message.get_type() == "COMMAND_LONG"]


def acknowledge(station, command, result, progress=255):
    station.say(common.MAVLink_command_ack_message(command, result, progress, 0, 254, 190))


async def test_an_order_is_followed_to_its_end_at_the_address_that_it_is_given():
    station = there()
    async with page(station) as served, program(served) as one:
        given = await one.order(**TURN)
        assert given.status == 202
        assert given.headers["Location"] == given.told["url"] == f"/api/v1{PAYLOAD}/orders/1"
        assert (given.told["state"], given.told["over"], given.told["words"]) == ("sent", False, "turn to 40 deg")
        message, who = next(each for each in station.sent if each[0].get_type() == "COMMAND_LONG")
        assert (message.command, message.param1, str(who)) == (ross.MAV_CMD_ROSS_TURN, 40.0, "1-191")
        acknowledge(station, ross.MAV_CMD_ROSS_TURN, Result.IN_PROGRESS, 50)
        under_way = await one.get(f"{PAYLOAD}/orders/1")
        assert (under_way.told["state"], under_way.told["progress"]) == ("in_progress", 0.5)
        acknowledge(station, ross.MAV_CMD_ROSS_TURN, Result.ACCEPTED)
        over = await one.get(f"{PAYLOAD}/orders/1")
        assert (over.told["state"], over.told["over"]) == ("done", True)


async def test_who_waits_for_an_order_is_answered_when_it_is_over_and_not_before():
    station = there()
    async with page(station) as served, program(served) as one:
        waiting = asyncio.create_task(one.order(wait=30, **TURN))
        async with browser(served.url) as watching:
            await watching.say(type="watch", id="1-191")
            await watching.next("payload", lambda told: told["sections"].get("orders"))
        assert not waiting.done()
        acknowledge(station, ross.MAV_CMD_ROSS_TURN, Result.ACCEPTED)
        assert (await waiting).told["state"] == "done"
        assert (await one.order(wait=0.01, kind="park")).told["state"] == "sent"


REFUSES = (Result.TEMPORARILY_REJECTED,)
REASON = "RoSS: listen refused: source 7 is unknown"


async def test_who_waits_is_told_of_a_refusal_in_the_payloads_own_words_though_they_come_after_it():
    station = Scripted(*REFUSES, text=REASON)
    async with page(station) as served, program(served) as one:
        answer = await one.order(wait=10, kind="listen", source=7)
        assert answer.refused(409, "refused") == "listen to source 7 was refused: source 7 is unknown"
        told = (await one.get(answer.headers["Location"].removeprefix("/api/v1"))).told
        assert (told["state"], told["over"], told["reason"]) == ("refused", True, "source 7 is unknown")


async def test_who_does_not_wait_finds_the_refusal_at_the_address_of_the_order():
    station = Scripted(*REFUSES, text=REASON)
    async with page(station) as served, program(served) as one:
        given = await one.order(kind="listen", source=7)
        assert given.status == 202
        told = await one.get(f"{given.told['url'].removeprefix('/api/v1')}?wait=10")
        assert (told.status, told.told["state"]) == (200, "refused")


async def test_one_order_can_be_cancelled_and_the_others_go_on():
    station = there()
    async with page(station) as served, program(served) as one:
        first, second = await one.order(**TURN), await one.order(kind="record", on=True)
        cancelled = await one.ask("POST", f"{PAYLOAD}/orders/{first.told['number']}/cancel")
        assert (cancelled.status, cancelled.told["number"]) == (202, first.told["number"])
        (cancel,) = [each for each, _ in station.sent if each.get_type() == "COMMAND_CANCEL"]
        assert cancel.command == ross.MAV_CMD_ROSS_TURN
        acknowledge(station, ross.MAV_CMD_ROSS_TURN, Result.CANCELLED)
        listed = (await one.get(f"{PAYLOAD}/orders")).told["orders"]
        assert [each["state"] for each in listed] == ["cancelled", "sent"]
        assert [each["number"] for each in listed] == [first.told["number"], second.told["number"]]


async def test_an_order_of_the_page_and_one_of_a_program_are_seen_by_both():
    station = there()
    async with page(station) as served, browser(served.url) as other, program(served) as one:
        await other.say(type="watch", id="1-191")
        await one.order(**TURN)
        await other.next("payload", lambda told: "turn to 40 deg" in str(told["sections"].get("orders")))
        await other.say(type="order", id="1-191", order={"kind": "stop"})
        await other.next("payload", lambda told: len(told["sections"].get("orders", ())) == 2)
        assert [each["words"] for each in (await one.get(f"{PAYLOAD}/orders")).told["orders"]][-1] == "stop"


# ------------------------------------------------------------------------------------------------ control


async def test_who_has_control_is_held_against_programs_as_against_browsers_and_nothing_is_ordered():
    station = there()
    async with page(station) as served, browser(served.url) as other, program(served, "script") as one:
        await other.say(type="control", take=True)
        name = (await other.next("control", lambda told: told["yours"]))["name"]
        assert (await one.order(**TURN)).refused(409, "no-control") == f"{name} has control: take control first"
        refused = await one.ask("PUT", f"{PAYLOAD}/parameters/EXP_UNIT", json={"value": 1})
        assert refused.refused(409, "no-control")
        assert not commands(station)
        taken = await one.ask("PUT", "/control")
        assert (taken.told["name"], taken.told["yours"]) == ("script at 127.0.0.1", True)
        await other.next("control", lambda told: told["name"] == "script at 127.0.0.1")
        assert (await one.order(**TURN)).status == 202
        await other.say(type="order", id="1-191", order={"kind": "explore"})
        assert "script at 127.0.0.1 has control" in (await other.next("refused"))["reason"]
        assert (await one.ask("DELETE", "/control")).told["name"] is None


async def test_the_first_program_that_orders_has_control_and_others_are_told_apart_by_their_names():
    station = there()
    async with page(station) as served, program(served, "a") as one, program(served, "b") as other:
        assert (await one.order(**TURN)).status == 202
        assert (await other.order(**TURN)).refused(409, "no-control").startswith("a at 127.0.0.1 has control")
        assert (await other.ask("DELETE", "/control")).told["name"] == "a at 127.0.0.1"


async def test_a_program_that_asks_for_nothing_any_more_loses_control_after_the_grace_and_one_that_does_keeps_it():
    station = there()
    async with page(station) as served, program(served, "a") as one, program(served, "b") as other:
        await one.order(**TURN)
        for _ in range(3):
            station.later += 0.9 * CONTROL_GRACE_S
            await one.get("/station")
            assert (await other.get("/control")).told["name"] == "a at 127.0.0.1"
        station.later += 1.1 * CONTROL_GRACE_S
        await other.get("/control")
        served.state.tick()
        assert (await other.get("/control")).told["name"] is None


# ------------------------------------------------------------------------------------------------ stop


async def test_a_program_that_dies_while_it_waits_for_an_order_loses_control_after_the_grace_too():
    station = Scripted(Result.IN_PROGRESS)
    async with page(station) as served, program(served, "other") as other:
        async with program(served, "tracker") as one:
            waiting = asyncio.create_task(one.order(wait=60, kind="explore"))
            async with asyncio.timeout(10):
                while not (await other.get("/control")).told["holder"]:
                    await asyncio.sleep(0.01)
            waiting.cancel()
        for _ in range(19):  # nearly twice the grace, in which the order does not end by itself
            station.later += 0.1 * CONTROL_GRACE_S
            await asyncio.sleep(0.05)
        assert (await other.get("/control")).told["holder"] is None


async def test_a_program_that_dies_while_it_waits_for_parameters_loses_control_after_the_grace_too():
    """The payload does not answer when it is asked for them."""
    station = there()
    async with page(station) as served, program(served, "other") as other:
        async with program(served, "tracker") as one:
            await one.ask("PUT", "/control")
            waiting = asyncio.create_task(one.get("/payloads/1-191/parameters?wait=60"))
            await asyncio.sleep(0.1)
            waiting.cancel()
        for _ in range(19):
            station.later += 0.1 * CONTROL_GRACE_S
            await asyncio.sleep(0.05)
        assert (await other.get("/control")).told["holder"] is None


async def test_a_stop_needs_no_control_no_body_and_no_payload_that_was_received():
    station = HandStation()
    async with page(station) as served, browser(served.url) as other, program(served) as one:
        await other.say(type="control", take=True)
        await other.next("control", lambda told: told["yours"])
        stopped = await one.ask("POST", f"{PAYLOAD}/stop")
        assert (stopped.status, stopped.told["words"]) == (202, "stop")
        assert set(commands(station)) == {ross.MAV_CMD_ROSS_STOP}
        assert (await one.get("/control")).told["yours"] is False


@pytest.mark.parametrize(
    "ceremony",
    [
        {"data": b"{", "headers": {"Content-Type": "application/json"}},
        {"data": b"\xff" * 100_000, "headers": {"Content-Type": "nonsense"}},
        {"params": {"now": "please", "wait": "long"}},
        {"headers": {"Ross-Client": "a name with spaces, and much too long a one for that"}},
        {"data": b"{}", "headers": {"Expect": "the-unexpected"}},
        {"data": b"{}", "expect100": True},
    ],
)
async def test_nothing_that_comes_with_a_stop_prevents_it(ceremony):
    station = there()
    async with page(station) as served, program(served) as one:
        assert (await one.ask("POST", f"{PAYLOAD}/stop", **ceremony)).status == 202
        assert commands(station) == [ross.MAV_CMD_ROSS_STOP]


async def test_all_payloads_are_stopped_at_once():
    station = there()
    station.say(status(1.0), who=ComponentId(2, 191))
    async with page(station) as served, program(served) as one:
        stopped = await one.ask("POST", "/stop")
        assert [each["id"] for each in stopped.told["orders"]] == list(map(str, station.fleet.payloads))


async def test_a_stop_for_all_that_reaches_nobody_is_no_success():
    async with page(HandStation()) as served, program(served) as one:
        assert "expected a payload that was received" in (await one.ask("POST", "/stop")).refused(
            404, "unknown-payload"
        )


async def test_a_page_for_recorded_flights_accepts_no_order_not_even_a_stop():
    async with page(None) as served, program(served) as one:
        assert (await one.get("/station")).told["mode"] == "flight"
        assert (await one.order(**TURN)).refused(409, "not-live") == "a recorded flight accepts no commands"
        assert (await one.ask("POST", f"{PAYLOAD}/stop")).refused(409, "not-live")
