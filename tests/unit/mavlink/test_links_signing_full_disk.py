"""Signed links while the disk takes nothing: a stop is obeyed, and nothing else is believed that was not before."""

import shutil
from pathlib import Path

import pytest

from full_disk import lose
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.signing import SECOND, link_and_time, timestamp_of
from signing_bench import BEAT, EXPLORE, OTHER, STOP, TODAY, GroundStation, Payload, order


@pytest.fixture
def full(payload: Payload, tmp_path: Path) -> GroundStation:
    """A ground station of a payload whose disk takes nothing, when the saved time is over."""
    ground = GroundStation()
    assert payload.hear(ground.say()) == 1
    assert ground.believes(payload.say())
    lose(tmp_path / "state" / "signing-time")
    payload.clock.time += 70.0
    ground.mav.signing.timestamp += 70 * SECOND
    payload.links.component(191).send(BEAT)
    payload.settle()
    payload.links.component(191).send(BEAT)
    assert payload.links.trouble.endswith("signing-time: Is a directory")
    return ground


def test_a_stop_is_obeyed_whatever_the_disk_says(payload: Payload, full: GroundStation) -> None:
    frames = [order(full, STOP) for _ in range(20)]
    assert payload.hear(*frames) == 20
    assert all(heard.may_order for heard in payload.heard[-20:])


def test_a_stop_that_is_played_again_is_obeyed_while_the_disk_takes_nothing(
    payload: Payload, full: GroundStation
) -> None:
    frame = order(full, STOP)
    assert payload.hear(*[frame] * 20) == 20
    assert all(heard.may_order for heard in payload.heard[-20:])


def test_a_stop_that_is_played_again_is_nothing_while_the_disk_is_well(payload: Payload) -> None:
    frame = order(GroundStation(), STOP)
    assert payload.hear(*[frame] * 20) == 1


def test_a_stop_of_a_station_ahead_of_us_does_not_wait_for_the_disk(payload: Payload) -> None:
    assert payload.hear(order(GroundStation(unix=TODAY + 3600), STOP)) == 1
    assert payload.heard[-1].may_order


def test_other_orders_are_heard_and_refused_while_the_disk_takes_nothing(payload: Payload, full: GroundStation) -> None:
    assert payload.hear(order(full, EXPLORE), full.say()) == 2
    assert [heard.may_order for heard in payload.heard[-2:]] == [False, False]
    assert all("signing-time: Is a directory" in heard.refusal for heard in payload.heard[-2:])


def test_what_is_played_again_or_forged_is_nothing_to_a_full_disk_either(payload: Payload, full: GroundStation) -> None:
    frame = order(full, EXPLORE)
    assert payload.hear(frame) == 1
    forged = GroundStation(OTHER, unix=TODAY + 90)
    assert payload.hear(frame, order(forged, STOP), Encoder(255, 190).encode(BEAT)) == 0


def test_answers_are_signed_and_believed_while_the_disk_takes_nothing(payload: Payload, full: GroundStation) -> None:
    frames = []
    for _ in range(500):
        payload.clock.time += 0.05
        frames.append(payload.say())
    assert all(full.believes(frame) for frame in frames)
    assert link_and_time(frames[-1])[1] < timestamp_of(TODAY + 60), "nothing beyond what was saved"


def test_a_disk_with_room_again_ends_it(payload: Payload, full: GroundStation, tmp_path: Path) -> None:
    shutil.rmtree(tmp_path / "state" / "signing-time")
    for _ in range(3):
        payload.clock.time += 2.0
        payload.links.poll()
        payload.say()
        payload.settle()
    payload.say()
    assert payload.links.trouble == ""
    assert payload.hear(order(full, EXPLORE)) == 1
    assert payload.heard[-1].may_order
