"""A stop that is not answered: to whom it is still being sent, and what telemetry says of it."""

import asyncio
from dataclasses import replace

import pytest

from client_bench import WHO
from ground_page import browser, page
from hand_station import HandStation
from ross_payload.ground.client.command_protocol import STOP_LASTS_S
from ross_payload.ground.client.command_types import Rearm, Stop, Turn
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.web.overview import overview
from ross_payload.ground.web.positions import Positions
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.values import Audio, Health, Heartbeat, Status

STOP, STOPPED, RUN = ross.MAV_CMD_ROSS_STOP, ross.ROSS_STATE_STOPPED, ross.ROSS_STATE_RUN
TELEMETRY = "its telemetry says that it has stopped"


def by_status(state, at):
    return PayloadState(WHO, 0.0, at, status=Status(0, 0.0, state, earth=True), status_at=at)


def by_heartbeat(state, at):
    return PayloadState(WHO, 0.0, at, heartbeat=Heartbeat(Health.ACTIVE, state))


def by_mirror(state, at):
    return PayloadState(WHO, 0.0, at, mirrors=(("ross_state", float(state)),))


@pytest.mark.parametrize("told", [by_status, by_heartbeat, by_mirror])
def test_an_unanswered_stop_says_that_telemetry_says_stopped_and_is_sent_on(told, script):
    script.wait(1)
    script.orders.order(WHO, Stop())
    script.wait(1)
    script.orders.on_state(told(STOPPED, script.now))
    script.wait(2)
    assert [(each.state, each.reason) for each in script.orders.doing] == [("no_answer", TELEMETRY)]
    assert script.orders.stopping == {WHO}
    script.orders.on_state(told(RUN, script.now))
    script.wait(2)
    assert "check that it is in range" in script.orders.doing[0].reason


def test_what_telemetry_said_before_a_stop_says_nothing_of_it(script):
    script.wait(1)
    script.orders.on_state(by_status(STOPPED, 0.5))
    script.orders.order(WHO, Stop())
    script.wait(4)
    assert "check that it is in range" in script.orders.doing[0].reason


def test_no_other_order_is_explained_by_a_stop(script):
    script.wait(1)
    script.orders.order(WHO, Turn(40))
    script.orders.on_state(by_status(STOPPED, 1.5))
    script.wait(8)
    assert "check that it is in range" in script.orders.doing[0].reason


def test_a_stop_is_being_sent_until_it_is_answered_or_a_rearming_or_half_a_minute_ends_it(script):
    assert script.orders.stopping == frozenset()
    script.orders.order(WHO, Stop())
    script.wait(STOP_LASTS_S - 1)
    assert script.orders.stopping == {WHO}
    script.wait(2)
    assert script.orders.stopping == frozenset()
    script.orders.order(WHO, Stop())
    assert script.orders.stopping == {WHO}
    script.ack(STOP, Result.ACCEPTED)
    assert script.orders.stopping == frozenset()
    script.wait(12)
    script.orders.order(WHO, Stop())
    script.wait(5)
    script.orders.order(WHO, Rearm())
    script.wait(2)
    assert script.orders.stopping == frozenset()


def test_a_state_is_as_old_as_the_status_that_told_it():
    told = replace(by_status(STOPPED, 0.5), last=3.0)
    assert row_of(told)["state_at"] == 0.5
    assert row_of(by_heartbeat(STOPPED, 2.0))["state_at"] == 2.0


def row_of(payload):
    fleet = Fleet()
    fleet.payloads[WHO] = payload
    return overview(fleet, (), Positions(), 3.0)["payloads"][0]


async def test_every_browser_is_told_to_whom_a_stop_is_being_sent():
    station = HandStation()
    station.say(Audio(time_usec=0))
    async with page(station) as served, browser(served.url) as one, browser(served.url) as other:
        assert (await other.next("fleet"))["stopping"] == []
        await one.say(type="order", id="1-191", order={"kind": "stop"})
        told = await other.next("fleet", lambda message: message["stopping"] == ["1-191"])
        assert [(each["id"], each["words"], each["state"]) for each in told["stops"]] == [("1-191", "stop", "sent")]
        for _ in range(int(STOP_LASTS_S) + 2):
            station.later += 1.0
            await asyncio.sleep(0.12)
        told = await other.next("fleet", lambda message: message["stopping"] == [])
        assert [each["state"] for each in told["stops"]] == ["no_answer"]
