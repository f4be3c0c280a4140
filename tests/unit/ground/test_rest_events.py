"""Server-sent events: what happens at a payload and to its orders, from now on."""

import asyncio
import json
from contextlib import AsyncExitStack

import pytest

from ground_page import page
from rest_program import PAYLOAD, program
from ross_payload.ground.client.events import Event
from ross_payload.ground.web.page_state import CONTROL_GRACE_S
from ross_payload.ground.web.rest import event_stream, programs
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from scripted_station import Scripted, source, status


async def until(events, kind, want=lambda data: True):
    """Return the data of the next event of a kind; others pass by."""
    async with asyncio.timeout(20):
        async for name, text in events:
            data = json.loads(text)
            if name == kind and want(data):
                return data
    raise AssertionError(f"the stream ended without {kind}")


async def begun(events, station):
    """Wait until a stream is open: only what happens from then on is told."""
    opening = asyncio.create_task(until(events, "TextReceived", lambda data: data["text"] == "RoSS: here"))
    while not opening.done():
        station.say(v.Text(v.Severity.INFO, "RoSS: here"))
        await asyncio.sleep(0.02)


async def test_what_happens_is_told_as_scripts_are_told_it():
    station = Scripted()
    async with page(station) as served, program(served) as one:
        events = one.events(f"{PAYLOAD}/events")
        await begun(events, station)
        station.say(status(2.0, state=ross.ROSS_STATE_RUN, k=2), source(0, 30), source(1, 200))
        changed = await until(events, "StateChanged")
        assert (changed["before"], changed["state"]) == ("idle", "run")
        found = await until(events, "SourceFound", lambda data: data["source"]["source"] == 1)
        assert found["source"]["azimuth_deg"] == pytest.approx(200)
        station.say(status(3.0, state=ross.ROSS_STATE_FAULT), who=ComponentId(2, 191))
        station.say(v.Text(v.Severity.WARNING, "RoSS: look"))
        assert (await until(events, "TextReceived", lambda data: data["severity"] == 4))["text"] == "RoSS: look"


async def test_progress_of_an_order_comes_by_itself():
    station = Scripted(Result.IN_PROGRESS, Result.ACCEPTED)
    async with page(station) as served, program(served) as one:
        events = one.events(f"{PAYLOAD}/events")
        await begun(events, station)
        given = (await one.order(kind="turn", heading=40)).told
        done = await until(events, "OrderStatus", lambda data: data["over"])
        assert (done["url"], done["state"]) == (given["url"], "done")


async def test_who_follows_the_events_keeps_control():
    station = Scripted(Result.ACCEPTED)
    async with page(station) as served, program(served, "a") as one, program(served, "b") as other:
        await one.order(wait=5, kind="park")
        events = one.events(f"{PAYLOAD}/events")
        await begun(events, station)
        station.later += 2 * CONTROL_GRACE_S
        served.state.tick()
        assert (await other.get("/control")).told["name"] == "a at 127.0.0.1"
        assert (await other.order(kind="park")).refused(409, "no-control")


async def test_a_stream_shows_that_it_lives_and_ends_with_the_page(monkeypatch):
    monkeypatch.setattr(event_stream, "KEEP_ALIVE_S", 0.05)
    async with AsyncExitStack() as ending:
        served = await ending.enter_async_context(page(Scripted()))
        async with program(served) as one, one.session.get(f"{one.base}{PAYLOAD}/events") as answer:
            async with asyncio.timeout(20):
                assert b"still here" in await answer.content.readline()
                await ending.aclose()
                await answer.content.read()


async def test_a_program_that_leaves_is_no_fault_of_the_page(monkeypatch, capsys):
    monkeypatch.setattr(event_stream, "KEEP_ALIVE_S", 0.01)
    station = Scripted()
    async with page(station) as served, program(served) as one:
        for _ in range(5):
            answer = await one.session.get(f"{one.base}{PAYLOAD}/events")
            await answer.content.readline()
            answer.close()
            await asyncio.sleep(0.1)
    assert capsys.readouterr().err == ""


async def test_of_a_payload_that_was_not_received_there_are_no_events_and_streams_are_bounded(monkeypatch):
    station = Scripted()
    async with page(station) as served, program(served) as one:
        assert (await one.get("/payloads/9-191/events")).refused(404, "unknown-payload")
        monkeypatch.setattr(programs, "MOST_STREAMS", 0)
        assert "get events already" in (await one.get(f"{PAYLOAD}/events")).refused(503, "too-many")


def test_every_event_of_scripts_can_be_told_but_for_those_that_a_client_makes_up():
    own = {"TaskProgress", "ContactLost", "ContactRestored"}  # OrderStatus, and `heard` of every answer, say as much
    names = {each.__name__ for each in Event.__subclasses__()}
    assert names - own == {each.__name__ for each in event_stream.KINDS} - {"OrderStatus"}
