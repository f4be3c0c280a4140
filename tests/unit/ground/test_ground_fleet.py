"""What is known of payloads from their frames alone: starts, twins, losses, texts in pieces."""

import math
from dataclasses import replace

import pytest

from fleet_ear import WHO, source, status
from ross_payload.ground.model.fleet import MOST_PAYLOADS
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import chunks, message_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.peers import Peers
from ross_protocols.mavlink.tunnel import Wrapper

# ------------------------------------------------------------------------------------------- who is there


def test_only_who_speaks_our_dialect_or_its_mirrors_is_a_payload(ground):
    ground.say(v.Heartbeat(v.Health.ACTIVE, 2), v.Named(0.0, "speed", 3.0), v.Text(v.Severity.INFO, "hello"))
    assert ground.fleet.payloads == {}
    ground.say(v.Named(0.0, "ross_k", 3.0), who=(2, 191))
    ground.say(message_of(Wrapper(3, 191).wrap(status(1.0))), who=(3, 191))
    assert [str(who) for who in ground.fleet.payloads] == ["2-191", "3-191"]
    assert [known.tunnelled for known in ground.fleet.payloads.values()] == [False, True]


def test_an_autopilot_tells_where_its_system_is(ground):
    ground.say(common.MAVLink_global_position_int_message(0, 474000000, 85000000, 0, 0, 0, 0, 0, 9000), who=(1, 1))
    assert math.degrees(ground.fleet.vehicles[1].position.latitude) == pytest.approx(47.4)
    assert ground.fleet.payloads == {}


def test_who_was_silent_for_long_makes_room_and_nobody_else_does(ground):
    for system in range(1, MOST_PAYLOADS + 1):
        ground.say(status(1.0), who=(system, 191))
    ground.say(status(1.0), who=(200, 191))
    assert ComponentId(200, 191) not in ground.fleet.payloads
    assert ground.fleet.hidden(1.0) == (1, [ComponentId(200, 191)])
    ground.at = 61.0
    for system in range(2, MOST_PAYLOADS + 1):
        ground.say(status(61.0), who=(system, 191))
    ground.say(status(61.0), who=(200, 191))
    assert ComponentId(200, 191) in ground.fleet.payloads
    assert WHO not in ground.fleet.payloads
    assert len(ground.fleet.payloads) == MOST_PAYLOADS
    assert ground.fleet.hidden(61.0) == (0, [])


def flood(ground, seconds, per_second, true=None):
    """Made-up ids, each heard once; a true payload speaks once a second among them."""
    for _ in range(seconds):
        ground.at += 1.0
        for number in range(round(ground.at) * per_second, round(ground.at + 1) * per_second):
            ground.say(status(ground.at), who=(2 + number % 190, 2 + number // 190 % 180))
        if true is not None:
            ground.say(status(ground.at), who=true)


def test_made_up_ids_do_not_hide_a_payload_that_begins_to_speak_among_them(ground):
    flood(ground, seconds=1, per_second=200)
    flood(ground, seconds=3, per_second=200, true=(1, 191))
    assert WHO in ground.fleet.payloads
    assert len(ground.fleet.payloads) == MOST_PAYLOADS
    assert ground.fleet.hidden(ground.at)[0] == 4 * 200 + 1 - MOST_PAYLOADS


def test_a_payload_that_was_heard_steadily_keeps_its_place_while_it_is_not_heard(ground):
    for _ in range(20):
        flood(ground, seconds=1, per_second=0, true=(1, 191))
    flood(ground, seconds=40, per_second=25)
    assert WHO in ground.fleet.payloads


def test_who_has_no_place_is_counted_until_it_is_silent_for_a_minute_and_the_steadiest_is_named_first(ground):
    for system in range(1, MOST_PAYLOADS + 1):
        for at in (1.0, 2.0, 3.0):
            ground.at = at
            ground.say(status(at), who=(system, 1 + 190))
    flood(ground, seconds=1, per_second=50)
    for at in (4.2, 5.0):
        ground.at = at
        ground.say(status(at), who=(200, 191))
    assert ground.fleet.hidden(5.0, most=1) == (51, [ComponentId(200, 191)])
    assert ground.fleet.hidden(64.5) == (1, [ComponentId(200, 191)])
    assert ground.fleet.hidden(66.0) == (0, [])


def test_who_is_watched_has_a_place_at_once_and_keeps_it(ground):
    for _ in range(10):
        ground.at += 1.0
        for system in range(1, MOST_PAYLOADS + 1):
            ground.say(status(ground.at), who=(system, 191))
    late = ComponentId(200, 191)
    ground.say(status(ground.at), who=(200, 191))
    assert late not in ground.fleet.payloads
    ground.fleet.pinned = frozenset({late})
    flood(ground, seconds=1, per_second=100, true=(200, 191))
    assert late in ground.fleet.payloads
    flood(ground, seconds=50, per_second=20)
    assert late in ground.fleet.payloads


# ------------------------------------------------------------------------------------------- starts and twins


def test_a_time_that_goes_back_is_a_new_start_and_what_was_known_is_forgotten(ground):
    ground.say(status(100.0), source(0, 1.0), v.Text(v.Severity.INFO, "before"))
    ground.at = 5.0
    ground.say(status(1.0))
    assert (ground.known.boots, ground.known.sources, ground.known.trails) == (2, (), ())
    assert [said.text for said in ground.known.texts] == ["before"], "what was said stays said"


def test_a_start_is_noticed_though_the_clock_is_that_of_the_world(ground):
    ground.say(replace(status(100.0), time_usec=10**15, time_unix=True))
    ground.say(replace(status(1.0), time_usec=10**15 + 10**7, time_unix=True))
    assert ground.known.boots == 2


def test_a_clock_that_is_set_is_no_new_start(ground):
    ground.say(status(100.0))
    ground.say(replace(status(100.1), time_usec=10**15, time_unix=True))
    ground.say(replace(status(100.2), time_usec=100_200_000))
    assert ground.known.boots == 1


def test_a_heartbeat_that_boots_and_the_time_after_it_are_one_start(ground):
    ground.say(v.Heartbeat(v.Health.ACTIVE, 2), status(100.0), v.Heartbeat(v.Health.ACTIVE, 2))
    ground.say(v.Heartbeat(v.Health.BOOT, 0), v.Heartbeat(v.Health.BOOT, 0), status(0.1))
    assert ground.known.boots == 2


def test_a_frame_that_comes_late_is_no_new_start(ground):
    ground.say(status(100.0), status(99.5), status(100.1))
    assert ground.known.boots == 1


def test_mission_time_that_begins_again_after_its_32_bits_is_no_new_start(ground):
    full = 2**32 / 1e3
    ground.say(
        status(full - 40, state=0), status(full - 30), status(full - 0.5), status(full + 0.5), status(full - 0.1)
    )
    ground.say(status(full + 60), status(full + 61, state=7))
    assert (ground.known.boots, ground.view["mission"]["time"]) == (1, 61.0)
    assert ground.view["mission"]["elapsed"] == pytest.approx(91.0)
    ground.say(replace(status(full + 90), mission_time=1.0))
    assert ground.known.boots == 2


def test_the_same_payload_over_a_slower_link_is_neither_a_twin_nor_a_new_start_nor_news(ground):
    for step in range(100):
        ground.at = step / 5
        ground.say(status(100 + ground.at), sender="udp")
        if ground.at > 2.5:
            ground.say(status(97.5 + ground.at, state=0), sender="satellite")
        assert (ground.known.status.mission_time, ground.known.status.state) == (100 + ground.at, 2)
    assert (ground.known.boots, ground.known.twin, ground.known.flaws) == (1, False, ())


@pytest.mark.parametrize("lag", [0.6, 2.0, 4.0])
@pytest.mark.parametrize("event", ["nothing", "clock set", "restarted"])
def test_on_a_slower_link_a_clock_that_is_set_is_no_new_start_and_a_new_start_is_one(ground, event, lag):
    arrivals = []
    for step in range(160):
        time = step / 4
        restarted = event == "restarted" and time >= 20
        told = status(1000 + time, mission_time=time - 23 if restarted else time + 50)
        if event == "clock set" and time >= 20:
            told = replace(told, time_unix=True, time_usec=told.time_usec + 10**15)
        beat = v.Heartbeat(v.Health.BOOT if restarted and time < 24 else v.Health.ACTIVE, 2)
        if not restarted or time >= 23:
            arrivals += [
                (time + late, way, said) for way, late in (("udp", 0.0), ("radio", lag)) for said in (told, beat)
            ]
    for at, way, said in sorted(arrivals, key=lambda arrival: arrival[0]):
        for packet in ground.decoder.feed(ground.frames(said, sender=way)[0]):
            ground.fleet.on_packet(packet, at, way=way)
    assert (ground.known.boots, ground.known.flaws) == (2 if event == "restarted" else 1, ())


@pytest.mark.parametrize("frozen", [5.0, 15.0, 40.0])
@pytest.mark.parametrize("event", ["nothing", "restarted"])
def test_who_stood_still_and_hears_what_waited_link_by_link_takes_nothing_for_a_new_start(ground, event, frozen):
    arrivals = []
    for step in range(400):
        time = step / 4
        restarted = event == "restarted" and time >= 80
        for way, late in (("udp", 0.0), ("radio", 0.3)):
            at = 30 + frozen + (late and 0.05) if 30 < time + late < 30 + frozen else time + late
            begin = -78 if restarted else 1000
            arrivals.append((at, way, status(begin + time, mission_time=begin + time - (0 if restarted else 50))))
    for at, way, said in sorted(arrivals, key=lambda arrival: arrival[0]):
        for packet in ground.decoder.feed(ground.frames(said, sender=way)[0]):
            ground.fleet.on_packet(packet, at, way=way)
    assert (ground.known.boots, ground.known.flaws) == (2 if event == "restarted" else 1, ())


@pytest.mark.parametrize("lag", [0.4, 2.0])
def test_a_payload_that_stood_still_has_not_restarted_where_one_of_two_links_is_slower(ground, lag):
    """Its clock has gone on at once; the audio catches up."""
    arrivals = []
    for step in range(100):
        time = step / 4 + 5.0 * (step >= 40)
        told = status(1000 + time, mission_time=time + 50 - (5.0 if 40 <= step < 43 else 0.0))
        arrivals += [(time, "udp", told), (time + lag, "radio", told)]
    for at, way, said in sorted(arrivals, key=lambda arrival: arrival[0]):
        for packet in ground.decoder.feed(ground.frames(said, sender=way)[0]):
            ground.fleet.on_packet(packet, at, way=way)
    assert (ground.known.boots, ground.known.flaws) == (1, ())


def test_a_frame_that_was_overtaken_by_the_end_of_a_mission_begins_no_other(ground):
    ground.say(status(100.0, state=0), status(101.0), status(160.0), status(160.9, state=7), status(160.8))
    ground.say(status(161.0, state=7))
    assert ground.view["mission"]["elapsed"] == pytest.approx(59.9)
    assert [each["state"] for each in ground.view["history"]][-2:] == ["explore_turn", "done"]


@pytest.mark.parametrize("apart", [20, 200, -200])
@pytest.mark.parametrize("began", [50, 70])
def test_two_payloads_of_one_id_on_two_links_are_noticed_and_do_not_restart_all_the_time(ground, apart, began):
    for step in range(100):
        for way, at, begin in (("udp", step / 4, 50), ("radio", step / 4 + 0.1, began)):
            told = status(
                1000 + at + apart * (way == "radio"), mission_time=1000 + at + apart * (way == "radio") - begin
            )
            for packet in ground.decoder.feed(ground.frames(told, sender=way)[0]):
                ground.fleet.on_packet(packet, at, way=way)
    assert (ground.known.twin, len(ground.known.flaws)) == (True, 1)
    assert ground.known.boots <= 3


def test_two_payloads_of_one_id_on_one_wire_are_noticed_and_named(ground):
    for step in range(40):
        ground.at = step / 10
        ground.say(status(100 + ground.at), sender=1)
        ground.say(status(500 + ground.at), sender=2)
    assert ground.known.twin
    reception = ground.view["health"]["reception"]
    assert reception["level"] == "act"
    assert "a different system_id, or a different component_id on the same vehicle" in reception["words"]
    assert ground.known.boots <= 3


def test_when_one_of_the_two_is_gone_it_is_a_twin_no_longer_and_its_starts_count_again(ground):
    test_two_payloads_of_one_id_on_one_wire_are_noticed_and_named(ground)
    for step in range(200):
        ground.at = 4 + step / 10
        ground.say(status(500 + ground.at), sender=2)
    boots = ground.known.boots
    assert not ground.known.twin
    ground.say(status(1.0), sender=2)
    assert ground.known.boots == boots + 1


# ------------------------------------------------------------------------------------------- losses


def test_frames_that_are_missing_are_counted(ground):
    frames = ground.frames(*(status(step / 10) for step in range(100)))
    ground.hear(frames[:10] + frames[13:50] + frames[51:])
    assert (ground.known.counts.frames, ground.known.counts.lost) == (96, 4)


def test_of_frames_that_overtake_each_other_and_come_twice_those_are_lost_that_never_come(ground):
    frames = dict(enumerate(ground.frames(*(status(step / 10) for step in range(400)))))
    del frames[20], frames[41], frames[300]
    arrivals = sorted(
        [(place + 11 * (place % 4), place) for place in frames] + [(place + 9, place) for place in frames]
    )
    peers = Peers()
    for _, place in arrivals:
        ground.hear([frames[place]])
        peers.meet(ground.decoder.feed(frames[place])[0], now=0.0)
    assert (ground.known.counts.lost, peers.lost) == (3, 3)


def test_a_payload_that_is_heard_on_two_links_loses_nothing(ground):
    for step in range(300):
        ground.say(status(step / 10), sender="udp")
        if step > 100:
            ground.say(status(step / 10 + 0.01), sender="radio")
    assert (ground.known.counts.lost, ground.known.boots) == (0, 1)


def test_doubled_frames_change_nothing(ground):
    frames = ground.frames(*(status(step / 10) for step in range(20)), v.Text(v.Severity.INFO, "once"))
    ground.hear([frame for frame in frames for _ in range(2)])
    assert (ground.known.counts.frames, ground.known.counts.lost) == (21, 0)
    assert len(ground.known.texts) == 1


# ------------------------------------------------------------------------------------------- texts

LONG = "RoSS: " + "abcdefghij" * 14


def texts(ground):
    return [said.text for said in ground.known.texts]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2, 0, 1, 2)])
def test_a_text_is_whole_once_in_whatever_order_its_chunks_come(ground, order):
    ground.say(status(0.0))
    frames = ground.frames(*chunks(v.Severity.WARNING, LONG, 9))
    ground.hear([frames[index] for index in order])
    ground.at = 3.0
    ground.say(status(3.0))
    assert texts(ground) == [LONG]


@pytest.mark.parametrize(
    ("lost", "shown"), [(0, " ... " + LONG[50:]), (1, LONG[:50] + " ... " + LONG[100:]), (2, LONG[:100] + " ...")]
)
def test_a_lost_chunk_leaves_a_gap_and_the_rest_is_shown_within_three_seconds(ground, lost, shown):
    ground.say(status(0.0))
    frames = ground.frames(*chunks(v.Severity.WARNING, LONG, 9))
    ground.hear(frames[:lost] + frames[lost + 1 :])
    assert texts(ground) == []
    ground.at = 2.5
    ground.say(status(2.5))
    assert texts(ground) == [shown]


def test_a_number_is_used_again_for_another_text_later(ground):
    ground.say(status(0.0))
    for at in (0.0, 60.0):
        ground.at = at
        ground.say(*chunks(v.Severity.WARNING, LONG, 9))
    assert texts(ground) == [LONG, LONG]


@pytest.mark.parametrize("heard", [(0, 1, 2), (0, 1), (0,)])
def test_a_payload_that_has_just_restarted_uses_numbers_again_for_other_texts(ground, heard):
    ground.say(status(100.0), v.Heartbeat(v.Health.ACTIVE, 2))
    frames = ground.frames(*chunks(v.Severity.WARNING, LONG, 9))
    ground.hear([frames[index] for index in heard])
    ground.at = 1.5
    other = LONG.replace("abc", "xyz")
    ground.say(v.Heartbeat(v.Health.BOOT, 0), status(0.1), *chunks(v.Severity.WARNING, other, 9))
    assert texts(ground) == ["".join(LONG[50 * i : 50 * i + 50] for i in heard) + " ..." * (len(heard) < 3), other]


def test_a_doubled_end_of_a_text_beyond_all_measure_begins_no_other(ground):
    ground.say(status(0.0))
    frames = ground.frames(*chunks(v.Severity.WARNING, "x" * 1060, 9))
    ground.hear([*frames, frames[-1]])
    ground.at = 2.5
    ground.say(status(2.5))
    assert len(texts(ground)) == 1


def test_no_flood_of_beginnings_fills_the_memory(ground):
    ground.say(status(0.0))
    for number in range(1, 1000):
        ground.at = number / 10
        ground.say(v.Text(v.Severity.INFO, "x" * 50, number, 255))
    assert len(ground.known.texts) == 200
    assert max(map(len, texts(ground))) < 1100
