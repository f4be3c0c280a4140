"""A flight of the past that is played on the page keeps time."""

import time

import pytest

from flight_logs import write_hour
from ground_page import browser, page
from ross_payload.ground.web.flight_library import FlightLibrary


@pytest.mark.soak
async def test_a_playing_flight_goes_on_with_the_wall_clock_times_its_speed(tmp_path):
    write_hour(tmp_path / "two.tlog", seconds=60, payloads=2)
    async with page(None, FlightLibrary(tmp_path)) as served, browser(served.url) as one:
        await one.say(type="flight", slot="a", open="two.tlog")
        await one.next("flight", lambda message: message["slot"] == "a")
        await one.say(type="flight", slot="a", speed=8)
        await one.say(type="flight", slot="a", play=True)
        first = await one.next("flight", lambda message: message["playing"])
        start = time.monotonic()
        last = await one.next("flight", lambda message: message["at"] > first["at"] + 8)
        lasted = time.monotonic() - start
        assert last["speed"] == 8
        assert 0.4 * 8 * lasted < last["at"] - first["at"] < 1.3 * 8 * lasted + 3
        times = [each["now"] for each in one.got if each["type"] == "payload"]
        assert times == sorted(times)
        await one.say(type="flight", slot="a", play=False)
        paused = await one.next("flight", lambda message: not message["playing"])
        await one.next("fleet")
        await one.next("fleet")
        assert not [each for each in one.got if each["type"] == "payload" and each["now"] > paused["at"] + 0.01]
