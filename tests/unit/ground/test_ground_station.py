"""A ground station: who it is, which way it speaks, what it counts, and when two payloads share one id."""

import contextlib
import math
import time
from collections.abc import Iterator
from typing import Any

import pytest

from clocks import LeapingClock
from ports import free_port
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.command_types import Turn
from ross_payload.ground.links.link import MAX_PEERS
from ross_payload.ground.links.routing import MAX_ANSWERS, MAX_SENDERS, MAX_TIMES, Route, RoutingTable
from ross_payload.ground.model.fleet import MOST_PAYLOADS
from ross_payload.ground.station import Station
from ross_protocols.mavlink.codec import Decoder, Encoder, Packet
from ross_protocols.mavlink.commands import Result, acknowledgement, long_message
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.signing import timestamp_of
from ross_protocols.mavlink.tunnel import Wrapper
from ross_protocols.mavlink.values import Audio, Severity, Text
from station_bench import AUDIO, BEAT, Far, status
from waiting import wait_for_async

WHO = ComponentId(1, 191)
TURN, STOP = ross.MAV_CMD_ROSS_LISTEN, ross.MAV_CMD_ROSS_STOP


def order(number: int, confirmation: int = 0) -> Any:
    return long_message(number, [0.0] * 7, ComponentId(1, 191), confirmation)


@pytest.fixture
def ports() -> tuple[int, int]:
    return free_port(), free_port()


@pytest.fixture
def two(ports: tuple[int, int]) -> Iterator[tuple[Far, Far]]:
    """One payload on two links."""
    with Far(ports[0]) as one, Far(ports[1]) as other:
        yield one, other


def urls(ports: tuple[int, int]) -> list[str]:
    return [f"udpin:127.0.0.1:{port}" for port in ports]


def orders(far: Far) -> list[int]:
    return [packet.message.command for packet in far.listen() if packet.name == "COMMAND_LONG"]


# ---------------------------------------------------------------------------------------------------- who it is


async def test_it_beats_once_a_second_as_a_ground_station(two: tuple[Far, Far], ports: tuple[int, int]) -> None:
    def heard() -> list[Packet]:
        return [packet for packet in two[0].listen() if packet.name == "HEARTBEAT"]

    began = time.monotonic()
    async with Station(urls(ports)):
        two[0].say(AUDIO)
        await wait_for_async(lambda: len(heard()) >= 3)
    beats = heard()
    assert time.monotonic() - began > len(beats) - 1.5
    assert {(beat.system_id, beat.component_id) for beat in beats} == {(254, 190)}
    assert beats[0].message.type == common.MAV_TYPE_GCS
    assert beats[0].message.autopilot == common.MAV_AUTOPILOT_INVALID
    assert [beat.sequence for beat in beats] == list(range(len(beats)))


async def test_its_ids_can_be_chosen(two: tuple[Far, Far], ports: tuple[int, int]) -> None:
    async with Station(urls(ports), system_id=253, component_id=191):
        two[0].say(AUDIO)
        await wait_for_async(two[0].names)
    assert (two[0].heard[0].system_id, two[0].heard[0].component_id) == (253, 191)


# ---------------------------------------------------------------------------------------------------- what it hears


async def test_subscribers_get_every_packet_as_it_came_until_they_have_enough(
    two: tuple[Far, Far], ports: tuple[int, int]
) -> None:
    heard: list[tuple[Packet, float]] = []
    async with Station(urls(ports)) as station:
        end = station.subscribe(lambda packet, at: heard.append((packet, at)))
        before = station.now()
        two[0].say(Wrapper(1, 191).wrap(AUDIO))
        await wait_for_async(lambda: heard)
        assert heard[0][0].name == "TUNNEL"
        assert before <= heard[0][1] <= station.now()
        assert station.fleet.payloads[WHO].tunnelled
        end()
        two[0].say(AUDIO)
        await wait_for_async(lambda: station.links()[0].frames == 2)
        assert len(heard) == 1


@pytest.mark.soak
async def test_links_count_what_goes_through_them(two: tuple[Far, Far], ports: tuple[int, int]) -> None:
    clock = LeapingClock()
    async with Station(urls(ports), now=clock.now) as station:
        frames = [two[0].encoder.encode(AUDIO) for _ in range(40)]
        for frame in frames[:10] + frames[20:]:
            two[0].throw(frame)
        damaged = bytearray(frames[0])
        damaged[-1] ^= 1
        two[0].throw(bytes(damaged))
        await wait_for_async(lambda: station.links()[0].bad)
        link, silent = station.links()
        assert (link.frames, link.lost, link.last is None) == (30, 10, False)
        assert link.bytes == sum(map(len, frames)) - sum(map(len, frames[10:20])) + len(damaged)
        assert link.loss == pytest.approx(0.25)
        assert link.frames_s > 5
        assert (silent.frames, silent.last, silent.frames_s, silent.loss) == (0, None, 0.0, 0.0)
        clock.ahead += 30.0
        await wait_for_async(lambda: station.links()[0].frames_s == station.links()[0].loss == 0.0)  # both of late


async def test_random_ids_cannot_fill_the_memory(ports: tuple[int, int]) -> None:
    async with Station(urls(ports), key=bytes(32)) as signed, Station([]) as silent:
        assert silent.links() == []
        link = signed._links[0]
        for number in range(2000):
            who = 1 + number % 255, 1 + number // 255 % 255
            frame = Encoder(*who, bytes(32)).encode(AUDIO, timestamp_of(time.time()))
            link._arrived(("192.0.2.1", number), frame, signed.now())
        (ours, _) = signed.links()
        assert ours.peers <= MAX_PEERS
        assert len(signed._routes._traces) <= MAX_SENDERS
        assert len(signed.fleet.payloads) <= MOST_PAYLOADS


# ---------------------------------------------------------------------------------------------------- which way


async def test_a_message_goes_where_its_receiver_was_heard_and_nobody_counts_a_loss(
    two: tuple[Far, Far], ports: tuple[int, int]
) -> None:
    with Far(ports[0], system=2) as neighbour:
        async with Station(urls(ports)) as station:
            two[0].say(AUDIO)
            neighbour.say(AUDIO)
            two[1].encoder = Encoder(3, 191)
            two[1].say(AUDIO)
            await wait_for_async(lambda: len(station.fleet.payloads) == 3)
            for _ in range(5):
                station.send(order(TURN), WHO)
            await wait_for_async(lambda: len(orders(two[0])) == 5)
            await wait_for_async(lambda: neighbour.names() and two[1].names())
        assert orders(two[1]) == orders(neighbour) == []
        for far in (*two, neighbour):
            sequences = [packet.sequence for packet in far.listen()]
            assert sequences == list(range(len(sequences)))


async def test_a_message_for_somebody_unheard_goes_everywhere(two: tuple[Far, Far], ports: tuple[int, int]) -> None:
    async with Station(urls(ports)) as station:
        for far in two:
            far.say(BEAT)
        await wait_for_async(lambda: all(link.frames for link in station.links()))
        station.send(order(TURN), ComponentId(9, 191))
        await wait_for_async(lambda: orders(two[0]) and orders(two[1]))


async def test_an_order_takes_one_way_and_a_stop_or_a_second_attempt_takes_all(
    two: tuple[Far, Far], ports: tuple[int, int]
) -> None:
    async with Station(urls(ports)) as station:
        for number, far in enumerate(two):
            far.say(AUDIO)
            await wait_for_async(lambda number=number: station.links()[number].frames)
        station.send(order(TURN), WHO)
        station.send(common.MAVLink_param_request_list_message(1, 191), WHO)
        station.send(order(STOP), WHO)
        station.send(order(TURN, confirmation=1), WHO)
        await wait_for_async(lambda: len(orders(two[0])) == 3 and len(orders(two[1])) == 2)
        assert orders(two[0]) == [TURN, STOP, TURN]
        assert orders(two[1]) == [STOP, TURN]
        assert "PARAM_REQUEST_LIST" not in two[1].names()


async def test_when_a_way_falls_silent_the_other_one_is_taken(two: tuple[Far, Far], ports: tuple[int, int]) -> None:
    clock = LeapingClock()
    async with Station(urls(ports), now=clock.now) as station:
        for number, far in enumerate(two):
            far.say(AUDIO)
            await wait_for_async(lambda number=number: station.links()[number].frames)
        clock.ahead += 5.0
        two[1].say(AUDIO)
        await wait_for_async(lambda: station.links()[1].frames == 2)
        station.send(order(TURN), WHO)
        await wait_for_async(lambda: orders(two[1]) == [TURN])
        assert orders(two[0]) == []


# ---------------------------------------------------------------------------------------------------- copies

SAID = Text(Severity.INFO, "RoSS: mission over: heading reached")


async def test_what_a_payload_says_on_two_links_is_said_once_however_late_one_of_them_is(
    two: tuple[Far, Far], ports: tuple[int, int]
) -> None:
    clock, quick, slow = LeapingClock(), *two
    async with Station(urls(ports), now=clock.now) as station:
        heard: list[Packet] = []
        station.subscribe(lambda packet, at: heard.append(packet))

        async def say(far: Far, *said: Any) -> None:
            frames = sum(link.frames for link in station.links())
            far.say(*said)
            await wait_for_async(lambda: sum(link.frames for link in station.links()) == frames + len(said))

        def texts() -> int:
            return len(station.fleet.payloads[WHO].texts)

        await say(quick, AUDIO, SAID)
        await say(slow, AUDIO)
        clock.ahead += 2.5
        await say(quick, AUDIO)
        await say(slow, SAID)
        assert texts() == 1
        await say(quick, SAID, SAID)
        assert texts() == 3, "on one link it is said as often as it comes"
        clock.ahead += 2.5
        await say(slow, SAID, SAID, SAID)
        assert texts() == 4, "the quick one has lost one"
        assert [packet.name for packet in heard].count("STATUSTEXT") == 4
        clock.ahead += 5.0
        await say(slow, SAID)
        assert texts() == 5, "the quick one is silent"


def test_no_flood_of_texts_fills_the_memory_of_what_was_said() -> None:
    table, encoder, decoder, route = RoutingTable(), Encoder(1, 191), Decoder(), Route(0, "here")
    for number in range(3 * MAX_ANSWERS):
        for text in (Text(Severity.INFO, f"RoSS: {number}"), SAID):
            (packet,) = decoder.feed(encoder.encode(text))
            table.note(WHO, route, packet, now=5.0)
            assert not table.is_copy(WHO, route, packet, now=5.0)
    (trace,) = table._traces[WHO].values()
    assert sum(map(len, trace.answers.values())) < MAX_ANSWERS + MAX_TIMES


async def test_an_answer_to_an_order_before_that_comes_late_on_another_link_is_none_to_this_one(
    two: tuple[Far, Far], ports: tuple[int, int]
) -> None:
    clock, quick, slow = LeapingClock(), *two
    async with Station(urls(ports), now=clock.now) as station:
        orders = CommandProtocol(station.send, station.system_id, station.component_id)
        station.subscribe(orders.on_packet)

        async def answer(far: Far, *results: Result) -> str:
            """Answer a turn, and tell what has become of it."""
            frames = sum(link.frames for link in station.links())
            us = ComponentId(station.system_id, station.component_id)
            far.say(*(acknowledgement(ross.MAV_CMD_ROSS_TURN, result, target=us) for result in results))
            await wait_for_async(lambda: sum(link.frames for link in station.links()) == frames + len(results))
            orders.tick(clock.now())
            return orders.doing[-1].state

        quick.say(AUDIO)
        slow.say(AUDIO)
        await wait_for_async(lambda: sum(link.frames for link in station.links()) == 2)
        orders.tick(clock.now())
        orders.order(WHO, Turn(20.0))
        assert await answer(quick, Result.IN_PROGRESS) == "acknowledged"
        clock.ahead += 1.0
        assert await answer(quick, Result.ACCEPTED) == "done"
        orders.order(WHO, Turn(-20.0))
        clock.ahead += 0.95
        assert await answer(slow, Result.IN_PROGRESS) == "sent"
        clock.ahead += 1.0
        assert await answer(slow, Result.ACCEPTED) == "sent"
        assert await answer(quick, Result.TEMPORARILY_REJECTED) == "refused"


# ---------------------------------------------------------------------------------------------------- twins


class Life:
    """A payload that says statuses on some ways, as often as told."""

    def __init__(self, station: Station, clock: LeapingClock) -> None:
        self.station, self.clock = station, clock
        self.said = 0

    async def say(self, *pairs: tuple[Far, float]) -> None:
        """Say one status each, with this time of the sender, half a second after the last one."""
        self.clock.ahead += 0.5
        for far, seconds in pairs:
            far.say(status(seconds))
            self.said += 1
        await wait_for_async(lambda: sum(link.frames for link in self.station.links()) == self.said)


@contextlib.asynccontextmanager
async def life(port: int) -> Any:
    clock = LeapingClock()
    async with Station([f"udpin:127.0.0.1:{port}"], now=clock.now) as station:
        yield Life(station, clock)


async def test_two_payloads_of_one_id_are_noticed_though_their_clocks_agree(ports: tuple[int, int]) -> None:
    with Far(ports[0]) as one, Far(ports[0]) as twin:
        async with life(ports[0]) as going:
            for number in range(8):
                await going.say((one, 100 + number / 2), (twin, 100.013 + number / 2))
            known = going.station.fleet.payloads[WHO]
            assert known.twin
            assert len(known.flaws) == 1
            assert known.flaws[0].startswith("two payloads use the id 1-191: give one ")
            for number in range(40):
                await going.say((one, 104 + number / 2))
            assert not going.station.fleet.payloads[WHO].twin, "the other one has got another id"


async def test_one_payload_on_two_ways_is_no_twin(ports: tuple[int, int]) -> None:
    with Far(ports[0]) as direct, Far(ports[0]) as routed:
        async with life(ports[0]) as going:
            for number in range(20):
                await going.say(*[(far, 100 + number / 2) for far in (direct, routed)[: 1 + number % 2]])
            assert not going.station.fleet.payloads[WHO].twin


async def test_a_payload_whose_two_ways_have_rates_and_delays_of_their_own_is_no_twin(ports: tuple[int, int]) -> None:
    with Far(ports[0]) as quick, Far(ports[0]) as slow:
        async with life(ports[0]) as going:
            for number in range(36):
                now = 100 + number / 2
                await going.say((quick, now), *([(slow, now - 5.2)] if number >= 12 else []))
                if number % 2 == 0:
                    quick.say(Audio(round(now * 1e6)))
                    going.said += 1
                if number % 3 == 0 and number >= 12:
                    slow.say(Audio(math.floor(now - 5.2) * 1_000_000))
                    going.said += 1
            known = going.station.fleet.payloads[WHO]
            assert (known.twin, known.boots, known.flaws) == (False, 1, ())
            assert known.status is not None
            assert known.status.mission_time == now


async def test_a_payload_that_restarts_from_another_port_is_no_twin(ports: tuple[int, int]) -> None:
    with Far(ports[0]) as before, Far(ports[0]) as after:
        async with life(ports[0]) as going:
            for number in range(10):
                await going.say((before, 100 + number / 2))
            for number in range(10):
                await going.say((after, 105 + number / 2))
            assert not going.station.fleet.payloads[WHO].twin
