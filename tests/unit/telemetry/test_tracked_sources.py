"""Tracked sources in telemetry: rate and age, told no more often than needed, and read by older ground stations."""

import json
import math
from dataclasses import replace

import pytest

from ross_payload.events import Estimate, SourceEstimate, SourcesEstimated, SourcesReconsidered, SourcesTracked
from ross_payload.sessions.event_json import line
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder, Encoder

FOUND = Estimate((SourceEstimate(0.5, 0.02, 0.9, True, 0.5), SourceEstimate(-1.0, 0.03, 0.9, True, 0.5)), certain=True)


def moved(time, azimuth, *, rate=0.1, age=0.0):
    first = replace(FOUND.sources[0], azimuth=azimuth, sigma=0.05)
    return SourcesTracked(time, replace(FOUND, sources=(first, FOUND.sources[1])), (rate, 0.0), (age, 3.0))


def test_tracked_sources_carry_rate_and_age_and_stay_those_of_their_estimate(ground):
    ground.say(SourcesEstimated(1.0, FOUND, 4, final=True))
    before = ground.latest(v.Source)
    assert (before.tracked, before.rate, before.age) == (False, None, None)
    ground.say(moved(2.0, 0.6, age=1.5))
    first, second = ground.all(v.Source)[-2:]
    assert (first.azimuth, first.sigma, first.rate, first.age) == (0.6, 0.05, 0.1, 1.5)
    assert (first.tracked, first.estimate, first.final) == (True, before.estimate, True)
    assert (second.azimuth, second.rate, second.age) == (-1.0, 0.0, 3.0)


def test_a_source_that_moves_is_told_at_most_twice_a_second(ground):
    ground.say(SourcesEstimated(1.0, FOUND, 4, final=True))
    ground.forget()
    for step in range(100):  # 10 s, 10 deg/s
        ground.say(moved(2.0 + 0.1 * step, 0.5 + math.radians(10) * 0.1 * step))
        ground.wait(0.1)
    told = [source for source in ground.all(v.Source) if source.source == 0]
    assert 18 <= len(told) <= 24
    assert told[-1].azimuth == pytest.approx(0.5 + math.radians(10) * 9.9, abs=math.radians(5))


def test_a_source_at_rest_is_told_no_more_often_than_before(ground):
    ground.say(SourcesEstimated(1.0, FOUND, 4, final=True))
    ground.wait(0.5)
    ground.forget()
    for step in range(100):
        ground.say(moved(2.0 + 0.1 * step, 0.5 + 0.001 * (step % 2)))
        ground.wait(0.1)
    assert len([source for source in ground.all(v.Source) if source.source == 0]) <= 4


def reconsidered(*sure):
    sources = tuple(replace(source, confidence=each) for source, each in zip(FOUND.sources, sure, strict=True))
    return SourcesReconsidered(2.0, replace(FOUND, sources=sources))


def test_sources_that_are_reconsidered_have_another_confidence_and_nothing_else(ground):
    ground.say(SourcesEstimated(1.0, FOUND, 4, final=True))
    before = ground.all(v.Source)[-2:]
    ground.now = 3.0
    ground.say(reconsidered(0.95, 0.5))
    now = ground.all(v.Source)[-2:]
    assert [source.confidence for source in now] == [0.95, 0.5]
    assert [replace(a, confidence=0.0, time_usec=0) for a in now] == [
        replace(b, confidence=0.0, time_usec=0) for b in before
    ]


def test_tracked_sources_are_a_line_of_the_events():
    told = json.loads(line(moved(2.0, 0.6, age=1.5)))
    assert (told["event"], told["rates"], told["ages"]) == ("SourcesTracked", [0.1, 0.0], [1.5, 3.0])
    assert [source["azimuth"] for source in told["estimate"]["sources"]] == [0.6, -1.0]


OLD_SOURCE = 42  # bytes of ROSS_SOURCE before it grew


def test_an_old_ground_reads_a_source_that_has_grown():
    """It takes the fields that it knows from the front of the payload, and the checksum is the same."""
    tracked = v.Source(7, 1, 0, 2, 0.5, 0.02, 0.9, 0.5, True, True, rate=0.2, age=1.0, tracked=True)
    plain = replace(tracked, rate=None, age=None, tracked=False)
    new, old = Encoder(1, 191).encode(tracked), Encoder(1, 191).encode(plain)
    assert len(new) == 12 + 50
    flags = 10 + OLD_SOURCE - 1
    assert new[10:flags] == old[10:flags]
    assert (new[flags], old[flags]) == (1 | 8, 1)


def test_a_source_of_an_old_payload_is_not_tracked():
    (packet,) = Decoder().feed(
        Encoder(1, 191).encode(v.Source(7, 1, 0, 2, 0.5, 0.02, 0.9, 0.5, True, True))
    )  # fmt: skip
    assert len(packet.frame) <= 12 + OLD_SOURCE
    assert (packet.value.tracked, packet.value.rate, packet.value.age) == (False, None, None)


def test_on_the_wire_a_rate_turns_clockwise():
    tracked = v.Source(7, 1, 0, 2, 0.5, 0.02, 0.9, 0.5, True, True, rate=0.25, age=1.0, tracked=True)
    (packet,) = Decoder().feed(Encoder(1, 191).encode(tracked))
    assert (packet.message.azimuth_rate, packet.message.age) == (-0.25, 1.0)
