"""Streams for scripts: ordered, returned as the payload announces them, told of, and described for players."""

import asyncio
import sys
from contextlib import asynccontextmanager
from dataclasses import replace

import pytest

import ross_payload.ground
from client_bench import Served
from fleet_ear import RTP
from hand_station import PAYLOAD, HandStation
from manual import block, executed
from ross_payload.ground import Payload, RefusedByPayload, TaskFailed
from ross_payload.ground.client import events as e
from ross_protocols.mavlink import stream_command
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import Result, command_of
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.stream_values import Selection
from scripted_station import with_payload

HERE = ("127.0.0.1", 5004)
SDP = "v=0\r\no=- 1 1 IN IP4 10.0.0.1\r\ns=RoSS stream 0\r\n" + "a=long\r\n" * 200


class Answering(HandStation):
    """A station whose payload accepts streams, or answers otherwise, and announces them."""

    def __init__(self, result=Result.ACCEPTED, text=""):
        super().__init__()
        self.result, self.text, self.asked, self.streams = result, text, [], {}
        self.say(v.Status(1_000_000, 1.0, 0, True))

    def send(self, message, who=None):
        super().send(message, who)
        if message.get_type() == "COMMAND_LONG" and message.command == ross.MAV_CMD_ROSS_STREAM:
            asked = stream_command.command_of(command_of(message).numbers)
            self.asked.append(asked)
            asyncio.get_running_loop().call_soon(self.answer, asked)

    def answer(self, asked):
        if self.text:
            self.say(v.Text(v.Severity.WARNING, self.text))
        us = self.system_id, self.component_id
        self.say(common.MAVLink_command_ack_message(ross.MAV_CMD_ROSS_STREAM, self.result, 0, 0, *us))
        if self.result is Result.ACCEPTED:
            on = asked.selection is not Selection.NONE
            number = asked.number if asked.number is not None else max(asked.port - HERE[1], 0)
            selection = Selection.TARGET if asked.selection is None else asked.selection
            told = replace(RTP, number=number, on=on, selection=selection, gain=asked.gain or 0.0)
            to = {"address": asked.address or HERE[0], "port": asked.port or HERE[1]}
            self.streams[number] = replace(told, **to)
            asyncio.get_running_loop().call_later(0.05, self.announce)

    def announce(self):
        self.say(*(replace(stream, count=max(self.streams) + 1) for stream in self.streams.values()))


def test_a_stream_is_ordered_and_returned_as_announced():
    station = Answering()
    stream = with_payload(station, lambda payload: payload.stream("source", 2, to=HERE, codec="opus"))
    (asked,) = station.asked
    assert (asked.selection, asked.source, asked.address, asked.port, asked.codec) == (
        Selection.SOURCE,
        2,
        *HERE,
        "opus",
    )
    assert (stream.number, stream.what, stream.source, stream.address, stream.port) == (0, "source", 2, *HERE)
    assert (stream.on, stream.azimuth_deg, stream.delay_s) == (True, pytest.approx(90.0), 0.12)


def test_what_is_returned_is_the_stream_after_the_change():
    station = Answering()

    async def work(payload):
        await payload.stream("target", to=HERE)
        return await payload.stream("mixture", number=0, gain_db=-6.5)

    stream = with_payload(station, work)
    assert (stream.what, stream.gain_db, stream.number) == ("mixture", -6.5, 0)


def test_streams_that_are_ordered_at_once_are_asked_for_one_by_one():
    station = Answering()

    async def work(payload):
        await asyncio.gather(*(payload.stream("mixture", to=("127.0.0.1", 5004 + index)) for index in range(2)))

    with_payload(station, work)
    asked = [asked.port for asked in station.asked]
    assert asked == sorted(asked), "the second one when the first has been answered; again until that is sure"
    assert set(asked) == {5004, 5005}


def test_what_happens_to_streams_is_an_event_and_levels_are_none():
    station = Answering()

    async def work(payload):
        happened, events = [], payload.events()
        await payload.stream("target", to=HERE)
        station.say(replace(payload.state.streams[0], level=-60.0, delay=0.3))
        await payload.stop_stream(0)
        await payload.until(lambda: payload.streams and not payload.streams[0].on)
        async for event in events:
            if isinstance(event, e.StreamChanged):
                happened.append(event.stream.on)
                if not event.stream.on:
                    return happened
        return happened

    assert with_payload(station, work) == [True, False]
    assert station.asked[-1].number == 0


@pytest.mark.parametrize(("result", "kind"), [(Result.DENIED, RefusedByPayload), (Result.FAILED, TaskFailed)])
def test_a_stream_that_is_refused_raises_the_payloads_words(result, kind):
    station = Answering(result, "RoSS: stream refused: no such codec")

    async def work(payload):
        with pytest.raises(kind, match="no such codec") as caught:
            await payload.stream("target", to=HERE)
        return caught.value

    assert with_payload(station, work).request == "stream target to 127.0.0.1:5004"


@pytest.mark.parametrize(
    "ask",
    [
        lambda payload: payload.stream("target"),
        lambda payload: payload.stream("target", to=("239.0.0.1", 5004)),
        lambda payload: payload.stream("everything", to=HERE),
        lambda payload: payload.stream("target", to=HERE, codec="mp3"),
        lambda payload: payload.enrol(1, consent=False),
        lambda payload: payload.enrol(consent=True),
    ],
)
def test_what_cannot_be_meant_is_not_sent(ask):
    station = Answering()

    async def work(payload):
        with pytest.raises(ValueError, match="expected"):
            await ask(payload)

    with_payload(station, work)
    assert station.asked == []


class Filing(HandStation):
    """A station whose payload has a real file server, in simulated time."""

    def __init__(self, payload):
        super().__init__()
        self.payload, self.encoder, self.decoder = payload, Encoder(self.system_id, 190), Decoder()
        self.say(v.Status(1_000_000, 1.0, 0, True))

    def send(self, message, who=None):
        super().send(message, who)
        self.payload.ground.air.call(self.encoder.encode(message))
        asyncio.get_running_loop().call_soon(self.pump)

    def pump(self):
        for _ in range(100):
            self.payload.step()
        for data in self.payload.ground.air.listen():
            for packet in self.decoder.feed(data):
                for call in list(self._calls):
                    call(packet, self.now())


def test_a_session_description_is_read_from_the_payload(sky):
    station = Filing(Served(sky(), {"stream-0.sdp": SDP.encode()}))
    assert with_payload(station, lambda payload: payload.session_description(0)) == SDP


class Describing(Answering, Filing):
    """A station whose payload streams, and has the descriptions of its streams."""

    def __init__(self, payload):
        Filing.__init__(self, payload)
        self.result, self.text, self.asked, self.streams = Result.ACCEPTED, "", [], {}

    def send(self, message, who=None):
        handler = Filing if message.get_type() == "FILE_TRANSFER_PROTOCOL" else Answering
        handler.send(self, message, who)


def test_the_script_of_the_guide_streams_describes_and_ends(sky, monkeypatch, capsys):
    station = Describing(Served(sky(), {"stream-0.sdp": SDP.encode()}))

    @asynccontextmanager
    async def connect(url):
        async with Payload(station, PAYLOAD) as payload:
            yield payload

    monkeypatch.setattr(ross_payload.ground, "connect", connect)
    monkeypatch.setattr(sys, "argv", ["guide", "udpin:127.0.0.1:14550", *map(str, HERE)])
    executed(block("docs/how-to/script-the-ground.md", "python", "session_description").text)
    said = capsys.readouterr().out
    assert said.startswith("stream 0 goes to 127.0.0.1 5004\n")
    assert "s=RoSS stream 0" in said
    assert list(dict.fromkeys(asked.selection for asked in station.asked)) == [Selection.MIXTURE, Selection.NONE]


def test_a_stream_without_a_description_is_refused(sky):
    station = Filing(Served(sky()))

    async def work(payload):
        with pytest.raises(RefusedByPayload, match=r"stream-3\.sdp: there is no such file"):
            await payload.session_description(3)

    with_payload(station, work)
