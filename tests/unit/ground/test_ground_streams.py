"""What the ground knows of the payload's streams: kept by number, told in degrees, places and words."""

import math
from dataclasses import replace

import pytest

from fleet_ear import FILE, RTP, Ground
from ross_payload.ground.model.view import view
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.stream_values import Selection
from ross_protocols.mavlink.tunnel import Wrapper


def test_streams_are_kept_by_number():
    ground = Ground()
    ground.say(FILE, RTP, replace(RTP, time_usec=2_000_000, level=-30.0))
    assert [(stream.number, stream.level) for stream in ground.known.streams] == [(0, -30.0), (1, None)]


def test_a_stream_whose_number_is_gone_is_forgotten():
    ground = Ground()
    ground.say(RTP, FILE, replace(RTP, time_usec=2_000_000, count=1))
    assert [stream.number for stream in ground.known.streams] == [0]


def test_streams_come_through_a_tunnel():
    ground = Ground()
    ground.say(Wrapper(1, 191).wrap(RTP))
    assert ground.known.streams == (replace(RTP, azimuth=pytest.approx(RTP.azimuth), delay=0.12),)


def test_the_view_tells_degrees_place_and_words():
    ground = Ground()
    ground.say(RTP, FILE)
    rtp, kept = view(ground.known)["streams"]
    assert (rtp["selection"], rtp["source"], rtp["azimuth"]) == ("source", 2, pytest.approx(90.0))
    assert (rtp["whom"], rtp["place"], rtp["codec"], rtp["words"]) == ("source 2", "192.168.1.20:5004", "opus", "on")
    assert (kept["whom"], kept["place"], kept["words"]) == ("target", "target.flac", "recording")


@pytest.mark.parametrize(
    ("changes", "level", "words"),
    [
        ({"on": False}, "good", "off"),
        ({"listeners": 0}, "good", "no listener"),
        ({"listeners": 1}, "good", "1 listener"),
        ({"listeners": 3, "muted": True, "detail": "no target yet"}, "good", "3 listeners, muted, no target yet"),
        ({"listeners": 1, "separated": False, "detail": "turning"}, "good", "1 listener, the mixture: turning"),
        (
            {"listeners": 1, "separated": False, "detail": "turning", "level": -120},
            "good",
            "1 listener, silence: turning",
        ),
        ({"listeners": 1, "detail": "buffered", "separated": True}, "good", "1 listener, buffered"),
        ({"fault": True, "detail": "disk full"}, "act", "fault: disk full"),
    ],
)
def test_how_a_stream_is_stands_in_its_words(changes, level, words):
    ground = Ground()
    ground.say(replace(RTP, **changes))
    (row,) = view(ground.known)["streams"]
    assert (row["level"], row["words"]) == (level, words)


@pytest.mark.parametrize(("selection", "name"), [(Selection.AZIMUTH, "azimuth 90 deg"), (9, "9")])
def test_what_a_later_dialect_selects_is_shown_as_a_number(selection, name):
    ground = Ground()
    ground.say(replace(RTP, selection=selection))
    assert view(ground.known)["streams"][0]["whom"] == name


@pytest.mark.parametrize(
    ("said", "level", "words"),
    [
        ((), "unknown", "no data"),
        ((v.Status(1, 0.0, 0, True),), "good", "off"),
        ((v.Status(1, 0.0, 0, True, streaming=True), RTP), "good", "1 stream on, listened to"),
        ((v.Status(1, 0.0, 0, True), RTP, FILE), "good", "2 streams on"),
        ((RTP, replace(FILE, fault=True, detail="disk full")), "act", "stream 1: disk full"),
        ((replace(RTP, on=False),), "good", "off"),
    ],
)
def test_a_stream_that_fails_is_a_matter_of_health(said, level, words):
    ground = Ground()
    ground.say(v.Audio(1), *said)
    part = view(ground.known)["health"]["listening"]
    assert (part["level"], part["words"]) == (level, words)


def test_the_view_tells_whether_anybody_listens_or_records():
    ground = Ground()
    ground.say(v.Status(1, 0.0, 0, True, streaming=True))
    standing = view(ground.known)["standing"]
    assert (standing["streaming"], standing["recording"]) == (True, False)


def test_a_tracked_source_has_rate_and_age_in_the_view():
    ground = Ground()
    told = v.Source(1, 1, 0, 2, 0.5, 0.02, 0.9, 0.5, True, True, rate=math.radians(-5), age=1.5, tracked=True)
    ground.say(told, replace(told, source=1, rate=None, age=None, tracked=False))
    first, second = view(ground.known)["sources"]
    assert (first["tracked"], first["rate"], first["age"]) == (True, pytest.approx(5.0), 1.5)
    assert (second["tracked"], second["rate"], second["age"]) == (False, None, None)
