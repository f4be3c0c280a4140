"""The client for scripts: what it tells of the payload as events, and to which payload it connects."""

import asyncio
import math

import pytest

import ports
from hand_station import PAYLOAD
from ross_payload.ground import (
    GroundError,
    NoPayload,
    Payload,
    connect,
)
from ross_payload.ground.client import events as e
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from scripted_station import Scripted, source, status, with_payload
from station_bench import Far

OTHER = ComponentId(2, 191)


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


@pytest.mark.parametrize(
    ("urls", "wrong", "kind", "said"),
    [
        ((), {}, ValueError, "urls: expected one"),
        (("udpin:127.0.0.1:0",), {"system_id": 999}, ValueError, "system_id: expected 1 to 255, got 999"),
        ((["udpin:127.0.0.1:0"],), {}, ValueError, r"urls: expected text such as .*for a list: connect\(\*urls\)"),
        ((None,), {}, ValueError, "urls: expected text such as udpin:127.0.0.1:14550, got None"),
        (("udpin:127.0.0.1:0",), {"system_id": "254"}, ValueError, "system_id: expected 1 to 255, got '254'"),
        (("udpin:127.0.0.1:0",), {"system_id": 252.5}, ValueError, "system_id: expected 1 to 255, got 252.5"),
        (("udpin:127.0.0.1:0",), {"system_id": True}, ValueError, "system_id: expected 1 to 255, got True"),
        (("udpin:127.0.0.1:0",), {"timeout_s": "5"}, ValueError, "timeout_s: expected a number of seconds .*got '5'"),
        (("udpin:127.0.0.1:0",), {"timeout_s": math.nan}, ValueError, "timeout_s: .*got nan"),
        (("udpin:127.0.0.1:0",), {"payload": [1, 191]}, ValueError, r"payload: expected an id .*got \[1, 191\]"),
        (("udpin:127.0.0.1:0",), {"payload": (1, 300)}, ValueError, "expected system-component.*got '1-300'"),
        (("udpin:127.0.0.1:0",), {"key": 5}, ValueError, "key: expected 32 bytes, or their file, got 5"),
        (("udpin:127.0.0.1:0",), {"log": 5}, ValueError, "log: expected a folder, got 5"),
        (("udpin:127.0.0.1:0",), {"key": b"short"}, GroundError, "key: expected 32 bytes, got 5"),
        (("udpin:127.0.0.1:0",), {"key": "no-such-key"}, GroundError, "key no-such-key: cannot be read"),
        (
            (f"udpin:127.0.0.1:{ports.free_port()}",),
            {"log": "/dev/null/logs"},
            GroundError,
            "--log /dev/null/logs: cannot be written",
        ),
    ],
)
async def test_what_cannot_be_connected_with_is_told_at_once(urls, wrong, kind, said):
    with pytest.raises(kind, match=said):
        async with connect(*urls, **{"timeout_s": 0.1} | wrong):
            pass


async def beating(far):
    """Let a payload say how it is, until cancelled."""
    seconds = 1.0
    while True:
        far.say(v.Status(round(seconds * 1e6), seconds, 0, earth=True, heading=0.5))
        seconds += 0.1
        await asyncio.sleep(0.05)
