"""A section is sent again when what it shows has changed, and strictly as JSON."""

import json
from dataclasses import replace

import pytest

from emulated_scene import full
from hand_station import PAYLOAD, HandStation
from ross_payload.ground.model.payload_state import Moment, PayloadState
from ross_payload.ground.model.view import SECTIONS
from ross_payload.ground.web.view_cache import DRAWN_FROM, ViewCache
from ross_protocols.mavlink.values import Health, Heartbeat


class Noticing:
    """A payload that notices which of its attributes somebody looks at."""

    def __init__(self, known):
        self._known, self.seen = known, set()

    def __getattr__(self, name):
        if name == "earth":
            self.seen.add("status")
        else:
            self.seen.add(name)
        return getattr(self._known, name)


def rich_payload():
    """Everything is known of it."""
    station = HandStation()
    for seconds in (1.0, 7.0, 19.0):
        for each in full(seconds):
            station.say(each)
    return station.fleet.payloads[PAYLOAD]


@pytest.mark.parametrize("name", SECTIONS)
def test_a_section_is_drawn_again_when_anything_changes_that_it_shows(name):
    for known in (rich_payload(), PayloadState(PAYLOAD, 0.0, 1.0)):
        noticing = Noticing(known)
        SECTIONS[name](noticing, {})
        assert noticing.seen <= set(DRAWN_FROM[name])


def test_what_looks_the_same_is_no_change():
    picture, known = ViewCache(), PayloadState(PAYLOAD, 0.0, 1.0, heartbeat=Heartbeat(Health.ACTIVE, state=6))
    picture.update(known, {})
    number = picture.number
    picture.update(replace(known, heartbeat=Heartbeat(Health.ACTIVE, state=6), mirrors=()), {})
    assert picture.number == number


def test_a_history_that_grows_is_drawn_now_and_then_and_one_that_begins_again_at_once():
    moments = tuple(Moment(index / 10, index / 10, 6, 2, index, 0.0, None) for index in range(40))
    picture, known = ViewCache(pace=1.0), PayloadState(PAYLOAD, 0.0, 0.0)
    drawn = []
    for index in range(1, 40):
        number = picture.number
        picture.update(replace(known, last=index / 10, history=moments[:index]), {})
        drawn += [index] * ("history" in json.loads(picture.since(number) or "{}"))
    assert drawn == [1, 11, 21, 31]
    number = picture.number
    picture.update(replace(known, last=3.95, history=()), {})
    assert json.loads(picture.since(number))["history"] == []


def test_a_number_that_is_none_reaches_no_browser():
    picture = ViewCache()
    picture.put("odd", [float("nan"), {"x": float("inf")}, 1.5])
    assert json.loads(picture.since(0)) == {"odd": [None, {"x": None}, 1.5]}
