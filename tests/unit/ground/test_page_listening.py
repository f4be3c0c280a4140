"""Live listening through the page's server: what is ordered, received and given on, and when it ends."""

import asyncio
import contextlib
import json
import sys
import time
from contextlib import asynccontextmanager

import aiohttp
import numpy as np
import pytest

from ground_page import browser, page
from ports import free_port
from ross_payload.audio.sinks import info_of
from ross_payload.ground.audio.rtp_port import RtpPort
from ross_payload.ground.audio.sound_queue import HEAD, MOST_FRAMES, Listener, frame_of
from ross_payload.ground.audio.voice_relay import STOP_PERIOD_S, VoiceRelay
from ross_payload.ground.errors import GroundError
from ross_payload.ground.station import Station, local_address
from ross_payload.ground.web import listening_sockets
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_values import Selection
from served_ground import Ground
from voice_payload import MEASURED_RATE, RATE, VoicePayload
from voice_sender import opened, talking
from waiting import wait_for_async

PAYLOAD = ComponentId(1, 191)
PATIENCE_S = 30.0


class Ear:
    """A browser that listens."""

    def __init__(self, socket):
        self._socket = socket
        self.told, self.samples, self.ages, self.indices = [], np.zeros(0), [], []
        self.code = None

    async def choose(self, **choice):
        await self._socket.send_str(json.dumps({"type": "choose", **choice}))

    async def say(self, text):
        await self._socket.send_str(text)

    async def close(self):
        await self._socket.close()

    async def until(self, claim):
        """Take what comes until a claim about it holds."""
        async with asyncio.timeout(PATIENCE_S):
            while not claim():
                message = await self._socket.receive()
                if message.type is aiohttp.WSMsgType.BINARY:
                    index, age = HEAD.unpack_from(message.data)
                    self.indices.append(index)
                    self.ages.append(age)
                    self.samples = np.append(self.samples, np.frombuffer(message.data, "<i2", offset=HEAD.size) / 32768)
                elif message.type is aiohttp.WSMsgType.TEXT:
                    self.told.append(json.loads(message.data))
                else:
                    self.code = self._socket.close_code
                    return

    def tone(self):
        """The strongest frequency of the last 0.25 s [Hz]; 0: there is none."""
        last = self.samples[-RATE // 4 :]
        if len(last) < RATE // 4 or np.abs(last).max() < 0.2:
            return 0.0
        return float(np.argmax(np.abs(np.fft.rfft(last * np.hanning(len(last)))))) * RATE / len(last)

    async def hears(self, hertz):
        await self.until(lambda: abs(self.tone() - hertz) < 20)


@asynccontextmanager
async def heard(**options):
    """A payload, a station that hears it, and the page."""
    port = free_port()
    with VoicePayload(port, **options) as payload:
        async with Station([f"udpin:127.0.0.1:{port}"]) as station, page(station) as served:
            await wait_for_async(lambda: PAYLOAD in station.fleet.payloads)
            await wait_for_async(lambda: station.fleet.payloads[PAYLOAD].audio)
            yield payload, station, served
        await wait_for_async(lambda: not payload.stream.on)  # whatever happened: it ends with the page


@asynccontextmanager
async def ear(url, who="1-191"):
    async with (
        aiohttp.ClientSession() as client,
        client.ws_connect(f"{url.split('?')[0]}listen?id={who}", autoping=True) as socket,
    ):
        yield Ear(socket)


async def test_nobody_hears_anything_before_somebody_asks():
    async with heard() as (payload, station, served), ear(served.url) as one:
        frames = station.links()[0].frames
        await wait_for_async(lambda: station.links()[0].frames > frames + 40)
        assert not payload.orders
        await one.choose(what="target")
        await one.hears(1000.0)
        assert [each.selection for each in payload.orders][:1] == [Selection.TARGET]
        assert payload.orders[0].address == "127.0.0.1"


async def test_what_is_heard_is_chosen_while_it_is_heard():
    async with heard() as (payload, _, served), ear(served.url) as one:
        await one.choose(what="mixture")
        await one.hears(500.0)
        await one.choose(what="source", source=2)
        await one.hears(2000.0)
        assert {(each.address, each.port) for each in payload.orders} == {(payload.stream.address, payload.stream.port)}
        await one.until(lambda: one.told[-1].get("whom") == "source 2")
        assert one.told[-1]["rate"] == RATE != MEASURED_RATE


async def test_a_browser_that_never_stops_choosing_holds_up_nobody_else(monkeypatch):
    """What it says waits in the process: as long as there was more of it, stops of others were not passed on."""
    turns, during = 0, []

    async def others():
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    async with heard() as (_, _, served), ear(served.url) as one:
        await one.choose(what="mixture")
        await one.hears(500.0)
        monkeypatch.setattr(VoiceRelay, "choose", lambda relay, choice: during.append(turns))
        busy = asyncio.create_task(others())
        for _ in range(200):
            await one.choose(what="target")
        await wait_for_async(lambda: len(during) == 200)
        busy.cancel()
        assert len(set(during)) == 200


async def test_frames_tell_their_place_and_their_age():
    async with heard() as (_, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.until(lambda: any(np.isfinite(one.ages)))
        assert all(20 <= age < 5000 for age in one.ages if np.isfinite(age))
        steps = np.diff(one.indices)
        assert np.all(steps % (RATE // 100) == 0)
        assert np.all(steps > 0)


async def test_two_listeners_share_one_stream_which_ends_with_the_last():
    async with heard() as (payload, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.hears(1000.0)
        async with ear(served.url) as other:
            await other.choose(what="mixture")
            await other.hears(500.0)
            await one.hears(500.0)
            await one.until(lambda: one.told[-1].get("listeners") == 2)
        await one.until(lambda: one.told[-1].get("listeners") == 1)
        await one.hears(500.0)
        assert payload.stream.on
        assert len({each.port for each in payload.orders}) == 1
        await one.close()
        await wait_for_async(lambda: not payload.stream.on)


async def test_lost_packets_are_counted(capfd):
    async with heard(lose=10) as (_, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.until(lambda: one.told and one.told[-1].get("lost", 0) >= 3)
        assert one.told[-1]["received"] > one.told[-1]["lost"]
    lines = [line for line in capfd.readouterr().err.splitlines() if "listens to" in line]
    assert len(lines) == 2, lines
    assert "1-191: target" in lines[0]
    assert "packets were lost" in lines[1]


async def test_a_refusal_is_told_in_words():
    async with heard(refuse=True) as (_, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.until(lambda: one.told and one.told[-1].get("state") == "refused")
        assert "invalid parameters" in one.told[-1]["why"]


@pytest.mark.parametrize(
    ("who", "choice", "why"),
    [
        ("9-191", {"what": "target"}, "expected a payload that was received, got 9-191"),
        ("nobody", {"what": "target"}, "nobody"),
        ("1-191", {}, "what: expected mixture"),
        ("1-191", {"what": "everything"}, "what: expected one of"),
        ("1-191", {"what": "source", "source": 1.5}, "source: expected a whole number"),
        ("1-191", {"what": "azimuth"}, "azimuth: expected -360 to 360"),
    ],
)
async def test_what_cannot_be_listened_to_is_refused_in_one_line(who, choice, why):
    async with heard() as (payload, _, served), ear(served.url, who) as one:
        await one.choose(**choice)
        await one.until(lambda: one.code is not None)
        assert why in one.told[-1]["why"]
        assert one.code == aiohttp.WSCloseCode.POLICY_VIOLATION
        assert not payload.orders


@pytest.mark.parametrize("text", ["[" * 2000, "\x00", '{"type": 1e999'])
async def test_what_is_no_message_is_refused_in_one_line(text, capsys):
    async with heard() as (_, _, served), ear(served.url) as one:
        await one.say(text)
        await one.until(lambda: one.code is not None)
        assert one.told[-1]["type"] == "refused"
        assert one.code == aiohttp.WSCloseCode.POLICY_VIOLATION
    assert "Traceback" not in capsys.readouterr().err


async def test_without_the_extra_it_is_told_how_to_install_it(monkeypatch):
    async with heard() as (payload, _, served), ear(served.url) as one:
        monkeypatch.delitem(sys.modules, "ross_payload.transport.rtp.receiver", raising=False)
        monkeypatch.setitem(sys.modules, "aiortc.rtp", None)
        await one.choose(what="target")
        await one.until(lambda: one.code is not None)
        assert one.told[-1]["why"].startswith("listening needs aiortc: ")
        assert "install" in one.told[-1]["why"]
        assert not payload.orders


async def test_there_is_room_for_so_many_listeners_and_no_more(monkeypatch):
    monkeypatch.setattr(listening_sockets, "MAX_LISTENERS", 1)
    async with heard() as (_, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.hears(1000.0)
        async with ear(served.url) as other:
            await other.until(lambda: other.code is not None)
            assert "no more are served" in other.told[-1]["why"]
        await one.hears(1000.0)


async def test_the_stream_ends_with_the_page():
    async with heard() as (payload, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.hears(1000.0)
        await one.until(lambda: one.told[-1].get("whom") == "target")
        assert payload.stream.on


async def test_a_stream_that_goes_on_unheard_is_stopped_again():
    async with heard() as (payload, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.hears(1000.0)
        await one.close()
        await wait_for_async(lambda: not payload.stream.on)
        payload.resume()  # as if the order had never come
        await wait_for_async(lambda: not payload.stream.on)


async def test_a_stream_that_the_payload_has_given_up_is_ordered_again_for_who_listens():
    async with heard() as (payload, _, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.hears(1000.0)
        payload.give_up()  # as after a link that was down
        await one.until(
            lambda: (one.told[-1].get("state"), one.told[-1].get("why")) == ("waiting", "no listener for 25 s")
        )
        before = len(one.samples)
        await one.until(lambda: len(one.samples) > before + RATE)
        await one.hears(1000.0)
        assert payload.stream.on
        assert len({each.port for each in payload.orders}) == 1
        await one.until(lambda: one.told[-1].get("state") == "playing")


async def test_an_end_that_comes_late_ends_no_stream_that_was_begun_since():
    async with heard() as (payload, _, served):
        async with ear(served.url) as one:
            await one.choose(what="target")
            await one.hears(1000.0)
        await wait_for_async(lambda: not payload.stream.on)
        end = next(each for each in payload.orders if each.selection is Selection.NONE)
        async with ear(served.url) as one:
            await one.choose(what="target")
            await one.hears(1000.0)
            assert (end.number, end.address) == (None, "127.0.0.1")
            assert end.port != payload.stream.port, "said once more, it would mean nobody"


async def test_a_stream_that_somebody_ended_is_not_ordered_again():
    async with heard() as (payload, station, served), ear(served.url) as one:
        await one.choose(what="target")
        await one.hears(1000.0)
        payload.stop()
        await one.until(lambda: one.told[-1].get("state") == "ended")
        orders, now = len(payload.orders), station.now()
        await one.until(lambda: station.now() > now + 2 * STOP_PERIOD_S)
        assert len(payload.orders) == orders


async def test_the_payload_streams_to_the_address_that_is_named():
    with contextlib.closing(Started("--audio-address", "127.0.0.2")) as ground, VoicePayload(ground.port) as payload:
        async with browser(ground.url) as one:
            await one.next("fleet", lambda message: message["payloads"])
        async with ear(ground.url) as one:
            await one.choose(what="target")
            await one.hears(1000.0)
            assert payload.orders[0].address == payload.stream.address == "127.0.0.2"
        await wait_for_async(lambda: not payload.stream.on)


class Started(Ground):
    """A process that ends with a block."""

    close = Ground.end


async def test_the_sink_of_a_payload_and_a_port_at_a_named_address_hear_each_other(tmp_path):
    port = await RtpPort(RATE, time.monotonic, time.time).open("127.0.0.2")
    with opened(port.place[1], tmp_path, address="127.0.0.2") as sink, talking(sink):
        await wait_for_async(lambda: info_of(sink).packets_lost is not None)
        assert port.receiver.reception(time.monotonic()).received > 0
    port.close()


async def test_another_origin_gets_nothing():
    async with heard() as (_, _, served), aiohttp.ClientSession() as client:
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await client.ws_connect(f"{served.url}listen?id=1-191", headers={"Origin": "http://evil.example"})
        assert refused.value.status == 403


async def test_without_the_token_nobody_listens():
    port = free_port()
    async with (
        Station([f"udpin:127.0.0.1:{port}"]) as station,
        page(station, token="t" * 20) as served,
        aiohttp.ClientSession() as client,
    ):
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await client.ws_connect(f"{served.url}listen?id=1-191")
        assert refused.value.status == 401


async def test_a_slow_listener_loses_the_oldest_and_holds_nobody_up():
    listener = Listener("somebody")
    for index in range(MOST_FRAMES + 7):
        listener.hear(frame_of(np.zeros(4, np.float32), index, None))
    _, frames = listener.due()
    assert listener.dropped == 7
    assert [HEAD.unpack_from(frame)[0] for frame in frames] == list(range(7, MOST_FRAMES + 7))


async def test_nobody_knows_the_way_to_who_was_not_heard():
    async with Station([f"udpin:127.0.0.1:{free_port()}"]) as station:
        with pytest.raises(GroundError, match="9-191 was not heard"):
            station.address_towards(ComponentId(9, 191))


def test_a_serial_line_has_no_address():
    with pytest.raises(GroundError, match=r"has no network address: give .* --audio-address"):
        local_address("", "1-191 is heard on serial:/dev/ttyUSB0:57600")
