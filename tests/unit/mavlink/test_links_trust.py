"""The hub: whose word counts, whose system id is ours, and our own voice from outside."""

from typing import Any

import pytest

from links_bench import ATTITUDE, BEAT, GROUND, PILOT, VEHICLE, Bench, command
from ross_payload.config import Link
from ross_payload.mavlink.router import MOST_SENT, SentFrames
from ross_protocols.mavlink.codec import Encoder
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.values import Severity, Text

LONELY = common.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)  # no autopilot


# ---------------------------------------------------------------------------------------------------- whose word counts


def test_only_accepted_systems_may_order_and_the_others_are_heard() -> None:
    bench = Bench(Link(url="udpin::1", accept=(255, 254)))
    bench.say("udpin::1", command(1, 191), system=255, component=190)
    bench.say("udpin::1", command(1, 191), system=7, component=190)
    bench.say("udpin::1", ATTITUDE, system=7)
    assert [(heard.packet.system_id, heard.may_order) for heard in bench.heard] == [(255, True), (7, False), (7, False)]


def test_the_system_id_is_taken_from_the_autopilot() -> None:
    bench = Bench(GROUND, PILOT, system_id=0)
    bench.say(PILOT.url, VEHICLE, system=9)
    assert bench.links.system_id == 9
    bench.payload.send(BEAT)
    assert [packet.system_id for packet in bench.wires[GROUND.url].packets()] == [9]


@pytest.mark.parametrize(
    ("url", "component", "message"),
    [
        pytest.param(GROUND.url, 1, VEHICLE, id="on a ground link"),
        pytest.param(PILOT.url, 190, VEHICLE, id="not component 1"),
        pytest.param(PILOT.url, 1, LONELY, id="no autopilot"),
        pytest.param(PILOT.url, 1, ATTITUDE, id="no heartbeat"),
    ],
)
def test_the_system_id_is_taken_from_nobody_else(url: str, component: int, message: Any) -> None:
    bench = Bench(GROUND, PILOT, system_id=0)
    bench.say(url, message, system=9, component=component)
    assert bench.links.system_id == 0


def test_the_system_id_is_taken_once() -> None:
    bench = Bench(PILOT, system_id=0)
    bench.say(PILOT.url, VEHICLE, system=9)
    bench.say(PILOT.url, VEHICLE, system=8)
    assert bench.links.system_id == 9


def test_a_configured_system_id_stays() -> None:
    bench = Bench(PILOT, system_id=3)
    bench.say(PILOT.url, VEHICLE, system=9)
    assert bench.links.system_id == 3


def test_until_the_vehicle_is_known_only_heartbeats_go_out_and_only_to_the_autopilot() -> None:
    bench = Bench(GROUND, PILOT, system_id=0)
    bench.payload.send(BEAT)
    bench.payload.send(Text(Severity.INFO, "hello"))
    assert bench.wires[GROUND.url].sent == []
    assert [packet.name for packet in bench.wires[PILOT.url].packets()] == ["HEARTBEAT"]


# ---------------------------------------------------------------------------------------------------- echoes and twins


def test_our_own_voice_is_not_heard_when_it_comes_back_on_any_link() -> None:
    bench = Bench(GROUND, PILOT)
    bench.links.component(154)
    for _ in range(20):
        bench.payload.send(ATTITUDE)
        bench.links.component(154).send(BEAT)
    bench.links.poll()
    bench.heard.clear()
    for frame in [*bench.wires[GROUND.url].sent, *bench.wires[PILOT.url].sent]:
        bench.hear(PILOT.url, frame)
    assert bench.heard == []
    assert bench.links.twin is None
    assert [status.twins for status in bench.links.status()] == [0, 0]


def test_a_frame_that_is_sent_again_is_known_for_as_long_as_a_new_one() -> None:
    sent, encoder = SentFrames(), Encoder(1, 191)
    attitudes = (common.MAVLink_attitude_message(time, 0.1, 0.2, 0.3, 0, 0, 0) for time in range(2 * MOST_SENT))
    beat, *others = (bytes(encoder.encode(attitude)) for attitude in attitudes)
    for frame in (beat, others[0], beat, *others[1:MOST_SENT]):
        sent.note(frame)
    assert beat in sent
    assert others[0] not in sent


def test_a_loop_of_two_links_comes_to_rest() -> None:
    """What goes out on one comes in on the other."""
    bench = Bench(GROUND, PILOT)
    bench.payload.subscribe(lambda heard: bench.payload.send(heard.packet.message))
    bench.payload.send(ATTITUDE)
    for _ in range(10):
        bench.wires[GROUND.url].coming, bench.wires[PILOT.url].coming = (
            list(bench.wires[PILOT.url].sent),
            list(bench.wires[GROUND.url].sent),
        )
        bench.links.poll()
    assert [len(wire.sent) for wire in bench.wires.values()] == [1, 1]


def test_somebody_else_with_our_ids_is_noticed_and_not_obeyed() -> None:
    bench = Bench(GROUND)
    bench.payload.send(BEAT)
    bench.say(GROUND.url, BEAT, system=1, component=191, sequence=77)
    assert bench.heard == []
    assert bench.links.twin == 191
    assert bench.links.status()[0].twins == 1


def test_a_twin_that_has_left_is_forgotten() -> None:
    bench = Bench(GROUND)
    bench.say(GROUND.url, BEAT, system=1, component=191, sequence=77)
    bench.clock.time += 11.0
    assert bench.links.twin is None


def test_our_component_id_in_another_system_is_no_twin() -> None:
    bench = Bench(GROUND)
    bench.say(GROUND.url, BEAT, system=2, component=191)
    assert bench.links.twin is None
    assert bench.names() == ["HEARTBEAT"]
