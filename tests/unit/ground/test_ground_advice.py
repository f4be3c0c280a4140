"""What a ground station says when nothing, or too little, is heard: each cause has words of its own and a remedy."""

from dataclasses import replace

import pytest

from clocks import LeapingClock
from ports import free_port
from ross_payload.ground.links.diagnostics import advice
from ross_payload.ground.links.link import LinkState
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.station import Station
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.values import Named
from station_bench import BEAT, Far, status
from waiting import wait_for_async

URL = "udpin:127.0.0.1:14550"
SILENT = LinkState(
    url=URL, up=True, error="", frames=0, bytes=0, lost=0, bad=0, skipped=0, refused=0, signed=0, strangers=0, peers=0,
    senders=(), last=None, frames_s=0.0, bytes_s=0.0, loss=0.0,
)  # fmt: skip
PAYLOAD = PayloadState(ComponentId(1, 191), first=0.0, last=30.0)
TALKING = replace(SILENT, frames=100, bytes=4000, last=30.0, frames_s=10.0, bytes_s=400.0)


def says(link: LinkState, *payloads: PayloadState, now: float = 30.0, key: bool = False) -> str:
    return advice([link], payloads, now=now, began=0.0, key=key)


@pytest.mark.parametrize(
    ("url", "remedy"),
    [
        (URL, 'url = "udpout:HOST:14550" where HOST is this computer; for payloads on other computers listen on'),
        ("udpin:0.0.0.0:14550", "where HOST is this computer; check with tcpdump -ni any udp port 14550"),
        ("udpout:10.0.0.7:14550", 'the [[links]] of the payload need url = "udpin:0.0.0.0:14550"'),
        ("udpin:[::1]:14550", "for payloads on other computers listen on udpin:[::]:14550"),
        ("udpout:[fd00::7]:14550", 'the [[links]] of the payload need url = "udpin:[::]:14550"'),
        ("tcp:10.0.0.7:5760", "connected, but the other side sends nothing: is it the right port?"),
        ("tcpin:127.0.0.1:5760", 'url = "tcp:HOST:5760" where HOST is this computer; for payloads on other'),
        ("serial:/dev/ttyUSB0:57600", "check the wires (RX to TX) and the baud rate; serial:/dev/ttyUSB0:auto tries"),
    ],
)  # fmt: skip
def test_a_silent_port_names_what_the_payload_needs_for_it(url: str, remedy: str) -> None:
    words = says(replace(SILENT, url=url))
    assert words.startswith(f"nothing received on {url} for 30 s: ")
    assert remedy in words


@pytest.mark.parametrize(
    ("link", "words"),
    [
        (replace(SILENT, url="tcp:10.0.0.7:5760", error="Connection refused", up=False),
         "tcp:10.0.0.7:5760: Connection refused: check that the other side is on, and the host and port 5760"),
        (replace(SILENT, url="serial:/dev/ttyUSB0:57600", error="Permission denied", up=False),
         "join the group dialout"),
        (replace(SILENT, url="serial:/dev/ttyUSB0:57600", bytes_s=5000.0), "the baud rate may differ, try serial:"),
        (replace(SILENT, bytes_s=800.0), "receiving 800 bytes/s, but no MAVLink: another program is sending"),
        (replace(SILENT, bytes_s=800.0, refused=40, signed=40), "both sides need the same key, and clocks that agree"),
        (replace(TALKING, senders=(ComponentId(1, 1), ComponentId(1, 154))),
         'receiving 1-1 (an autopilot), 1-154, but no payload: is it on? behind ArduPilot, set role = "autopilot"'),
        (replace(TALKING, senders=(ComponentId(1, 191),)), "receiving 1-191, but no payload: is it on?"),
        (replace(TALKING, senders=(ComponentId(1, 191),), bad=7), "7 frames have a wrong checksum: does it use"),
    ],
)  # fmt: skip
def test_every_cause_has_its_words(link: LinkState, words: str) -> None:
    assert words in says(link)
    assert "\n" not in says(link)


def test_at_first_it_only_says_where_it_listens() -> None:
    assert says(SILENT, now=3.0) == f"waiting for telemetry on {URL}"


def test_all_is_well_needs_no_words() -> None:
    assert says(TALKING, PAYLOAD) == ""
    assert says(TALKING, PAYLOAD, now=3.0) == ""
    assert says(replace(TALKING, signed=100), PAYLOAD, key=True) == ""


def test_what_was_heard_before_is_not_looked_for_in_its_configuration() -> None:
    gone = replace(TALKING, frames_s=0.0, bytes_s=0.0)
    words = says(gone, PAYLOAD, now=45.0)
    assert words == f"nothing received on {URL} for 15 s: check that the payload is on and the network is up"


def test_mirrors_alone_mean_that_an_autopilot_drops_the_rest() -> None:
    poor = replace(PAYLOAD, mirrors=(("ross_k", 3.0),))
    assert says(TALKING, poor).startswith("only summary values arrive from 1-191: behind ArduPilot")
    assert says(TALKING, replace(poor, first=25.0)) == "", "the rest may still come"


def test_who_signs_is_told_to_who_does_not() -> None:
    words = "the payload signs its messages, and accepts commands only from stations with its key (--mavlink-key)"
    assert says(replace(TALKING, signed=3), PAYLOAD) == f"{URL}: {words}"


async def test_a_station_tells_from_silence_to_noise_to_an_autopilot_to_mirrors_to_a_payload() -> None:
    port, clock = free_port(), LeapingClock()
    async with Station([f"udpin:127.0.0.1:{port}"], now=clock.now) as station:
        with Far(port) as payload, Far(port, component=1) as autopilot:
            clock.ahead += 6.0
            assert "nothing received on" in station.advice()
            payload.throw(b"hello" * 100)
            await wait_for_async(lambda: "no MAVLink" in station.advice())
            autopilot.say(BEAT)
            await wait_for_async(lambda: "1-1 (an autopilot)" in station.advice())
            payload.say(Named(1.0, "ross_k", 2.0))
            await wait_for_async(lambda: station.fleet.payloads)
            clock.ahead += 11.0
            payload.say(Named(12.0, "ross_k", 2.0))
            await wait_for_async(lambda: "only summary values" in station.advice())
            payload.say(status(12.0))
            await wait_for_async(lambda: station.advice() == "")
