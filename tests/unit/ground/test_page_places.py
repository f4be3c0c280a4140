"""Where payloads stand: told by an autopilot or typed, and bearings that cross."""

import math

import pytest

from ground_page import audio, browser, page
from hand_station import HandStation
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Source, Status


def position(latitude=47.0, longitude=8.0):
    place = round(latitude * 1e7), round(longitude * 1e7)
    return common.MAVLink_global_position_int_message(0, *place, 0, 0, 0, 0, 0, 9000)


async def test_a_payload_stands_where_its_autopilot_says():
    station = HandStation()
    station.say(audio())
    station.say(position(), who=ComponentId(1, 1))
    async with page(station) as served, browser(served.url) as one:
        told = await one.next("fleet", lambda message: message["places"])
        assert told["places"]["1-191"] == {"lat": pytest.approx(47), "lon": pytest.approx(8), "heading": 90.0,
                                           "from": "autopilot"}  # fmt: skip
        assert told["payloads"][0]["position"] == {"lat": pytest.approx(47), "lon": pytest.approx(8)}


async def test_a_typed_place_counts_where_no_autopilot_speaks_and_only_then():
    station = HandStation()
    station.say(audio())
    async with page(station) as served, browser(served.url) as one:
        await one.say(type="place", id="1-191", lat=46.5, lon=7.5, heading=350)
        told = await one.next("fleet", lambda message: message["places"])
        assert told["places"]["1-191"] == {"lat": pytest.approx(46.5), "lon": pytest.approx(7.5), "heading": 350.0,
                                           "from": "typed"}  # fmt: skip
        station.say(position(), who=ComponentId(1, 1))
        await one.next("fleet", lambda message: message["places"]["1-191"]["from"] == "autopilot")
        station.later = 11.0
        await one.next("fleet", lambda message: message["places"]["1-191"]["from"] == "typed")


def hears(direction):
    """A payload hears one talker: clockwise from north [deg]."""
    azimuth = -math.radians(direction)
    yield Status(time_usec=0, mission_time=1.0, state=6, earth=True, k=1)
    yield Source(0, 1, 0, 1, azimuth, 0.02, 1.0, 1.0, earth=True, resolved=True)


async def test_bearings_of_two_payloads_that_stand_somewhere_cross():
    station = HandStation()
    east = math.degrees(100 / 6_378_137 / math.cos(math.radians(47.0)))
    for system, direction, longitude in ((1, 45, 8.0), (2, -45, 8.0 + east)):
        station.say(position(longitude=longitude), who=ComponentId(system, 1))
        for each in hears(direction):
            station.say(each, who=ComponentId(system, 191))
    async with page(station) as served, browser(served.url) as one:
        (fix,) = (await one.next("fleet", lambda message: message["fixes"]))["fixes"]
        assert (fix["east"], fix["north"]) == (pytest.approx(50, abs=0.5), pytest.approx(50, abs=0.5))
        assert fix["payloads"] == ["1-191", "2-191"]
        assert not fix["ghost"]
