"""Live listening on the ground: what is known of streams, how they are shown, and how they are ordered."""

import asyncio
import math
from dataclasses import replace

import pytest
from click.testing import CliRunner

from client_bench import Served
from emulated_scene import full
from fleet_ear import Ground
from hand_station import PAYLOAD, HandStation
from ross_payload.ground import Payload, RefusedByPayload, TaskFailed
from ross_payload.ground.client import events as e
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.client.stream_orders import Enrol, StopStream, Stream
from ross_payload.ground.mavproxy.shell import Shell
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.view import view
from ross_payload.ground.terminal import blocks
from ross_payload.ground.terminal.blocks import safe_view
from ross_payload.ground.terminal.change_log import ChangeLog
from ross_payload.ground.terminal.command import command as monitor
from ross_payload.ground.terminal.controller import Controller
from ross_payload.ground.terminal.screen import ScreenState, compose
from ross_protocols.mavlink import stream_command
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import Result, command_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport
from ross_protocols.mavlink.tunnel import Wrapper

RTP = StreamReport(
    1_000_000, 0, 2, "rtp", Selection.SOURCE, True, 48000, on=True, source=2, azimuth=-math.pi / 2, group=1,
    codec=Codec.OPUS, address="192.168.1.20", port=5004, gain=-6.0, level=-23.0, delay=0.12, separated=True,
)  # fmt: skip
FILE = StreamReport(
    1_000_000, 1, 2, "file", Selection.TARGET, True, 16000, on=True, codec=Codec.FLAC, address="target.flac",
    records=True,
)  # fmt: skip
HERE = ("127.0.0.1", 5004)


# ------------------------------------------------------------------------------------------- what is known


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


# ------------------------------------------------------------------------------------------- terminal


@pytest.mark.parametrize(
    ("rate", "age", "end"),
    [(-5.0, None, "+5 deg/s"), (5.0, 2.4, "-5 deg/s  silent 2 s"), (None, 12.0, "silent 12 s"), (0.1, 0.5, "-")],
)
def test_the_monitor_shows_how_a_tracked_source_moves(rate, age, end):
    ground = Ground()
    ground.say(v.Source(1, 1, 0, 1, 0.5, 0.02, 0.9, 0.5, True, True, tracked=True, age=age,
                        rate=None if rate is None else math.radians(rate)))  # fmt: skip
    _, row = blocks.sources(safe_view(ground.known), chosen=None)
    assert row.plain.endswith(end)


def screen(*said, size=(100, 40)):
    ground = Ground()
    ground.say(*full(30.0, 3, 1), *said)
    shown = ScreenState(view=safe_view(ground.known), now=1.0)
    return "\n".join(line.plain for line in compose(shown, *size))


def test_the_monitor_shows_each_stream_with_its_address():
    drawn = screen(RTP, FILE, size=(180, 40))
    assert "stream 0     source 2 to 192.168.1.20:5004 (rtp, opus, 48000 Hz): on, -23 dB, 120 ms" in drawn
    assert "target to target.flac" in drawn


def test_the_first_line_says_that_somebody_listens_or_records():
    head = screen(v.Status(40_000_000, 40.0, 6, True, streaming=True, recording=True)).splitlines()[0]
    assert "LISTENED TO" in head
    assert "RECORDING" in head
    assert "LISTENED TO" not in screen().splitlines()[0]


def test_a_log_has_a_line_when_a_stream_changes_and_none_for_levels():
    fleet, encoder, decoder, log = Fleet(), Encoder(1, 191), Decoder(), ChangeLog()

    def words(*said):
        for value in said:
            for packet in decoder.feed(encoder.encode(value)):
                fleet.on_packet(packet, at=1.0)
        return log.words(view(fleet.payloads[ComponentId(1, 191)]))

    words(*full(30.0, 3, 1))
    one = replace(RTP, count=1)
    assert words(one) == ["stream 0: source 2 to 192.168.1.20:5004, on"]
    assert words(replace(one, level=-40.0, delay=0.2, lost=100, azimuth=0.0)) == []
    assert words(replace(one, on=False)) == ["stream 0: source 2 to 192.168.1.20:5004, off"]


class Keys:
    """A monitor that was given an address to listen at."""

    def __init__(self, hear_at=("10.0.0.2", 5004, "opus")):
        self.fleet, self.sent = Fleet(), []
        orders = CommandProtocol(lambda message, who: self.sent.append(command_of(message)), 255, 190)
        self.controller = Controller(self.fleet, orders, hear_at=hear_at)
        for value in full(30.0, 3, 1):
            for packet in Decoder().feed(Encoder(1, 191).encode(value)):
                self.fleet.on_packet(packet, 0.0)

    def press(self, *keys):
        for key in keys:
            self.controller.press(key)
        return [stream_command.command_of(command.numbers) for command in self.sent]


@pytest.mark.parametrize(
    ("keys", "selection", "source"),
    [("h", Selection.TARGET, 0), (("right", "right", "h"), Selection.SOURCE, 1), ("m", Selection.MIXTURE, 0)],
)
def test_keys_have_the_target_a_source_or_the_mixture_sent_to_the_user(keys, selection, source):
    (command,) = Keys().press(*keys)
    assert (command.number, command.selection, command.source) == (None, selection, source)
    assert (command.address, command.port, command.codec) == ("10.0.0.2", 5004, "opus")


def test_a_key_ends_all_streams_also_without_an_address():
    (command,) = Keys(hear_at=None).press("x")
    assert (command.number, command.selection) == (None, Selection.NONE)


def test_without_an_address_the_user_is_told_what_to_do():
    keys = Keys(hear_at=None)
    assert keys.press("h", "m") == []
    assert keys.controller.note == "start with --hear-at ADDRESS:PORT to say where you listen"


@pytest.mark.parametrize("place", ["5004", "10.0.0.2", "10.0.0.2:", "10.0.0.2:0", "10.0.0.2:99999", "host:5004",
                                   "239.0.0.1:5004", "10.0.0.2:5004/mp3", "10.0.0.2:5004/pcm", ":5004"])  # fmt: skip
def test_a_place_that_cannot_be_meant_is_refused(place):
    with pytest.raises(ValueError, match="expected"):
        stream_command.place_of(place)


def test_the_command_refuses_such_a_place_in_one_line():
    done = CliRunner().invoke(monitor, ["--hear-at", "239.0.0.1:5004"])
    assert done.exit_code == 2
    assert done.output.splitlines()[-1] == ("Error: --hear-at: address: expected that of one computer, got 239.0.0.1")


# ------------------------------------------------------------------------------------------- words and JSON


@pytest.mark.parametrize(
    ("line", "order", "words"),
    [
        ("stream target 127.0.0.1:5004", Stream(what="target", address=HERE[0], port=HERE[1], codec="opus"),
         "stream target to 127.0.0.1:5004"),
        ("stream source 2 127.0.0.1:5004/l16",
         Stream(what="source", source=2, address=HERE[0], port=HERE[1], codec="l16"),
         "stream source 2 to 127.0.0.1:5004"),
        ("stream azimuth -90 127.0.0.1:5004",
         Stream(what="azimuth", azimuth=-90.0, address=HERE[0], port=HERE[1], codec="opus"),
         "stream azimuth -90 deg to 127.0.0.1:5004"),
        ("stream 1 mixture", Stream(stream=1, what="mixture"), "stream 1 mixture"),
        ("stream 1 source 0", Stream(stream=1, what="source"), "stream 1 source 0"),
        ("stream 1 -6", Stream(stream=1, gain=-6.0, muted=False), "stream 1 at -6 dB"),
        ("stream 1 mute", Stream(stream=1, muted=True), "stream 1 muted"),
        ("stream off 1", StopStream(1), "stop stream 1"),
        ("stream off", StopStream(), "stop all streams"),
        ("stream off 127.0.0.1:5004", StopStream(None, *HERE), "stop the stream to 127.0.0.1:5004"),
        ("enrol source 1 consent", Enrol(1, consent=True), "enrol source 1"),
        ("enrol azimuth 90 consent 3 20", Enrol(None, 90.0, 20.0, True, 3), "enrol at 90 deg as talker-3"),
    ],
)  # fmt: skip
def test_words_on_a_command_line_become_their_order(line, order, words):
    sent, said = [], []
    orders = CommandProtocol(lambda message, who: sent.append(command_of(message)), 255, 230)
    shell = Shell(orders, said.append)
    for value in full(30.0, 3, 1):
        for packet in Decoder().feed(Encoder(1, 191).encode(value)):
            shell.on_packet(packet, 0.0)
    shell.execute(line.split())
    assert said == [f"RoSS 1-191 {words}: sent"]
    (command,) = sent
    expected = (*order.numbers, *[0.0] * 7)[:7]
    assert command.number == order.number
    assert [math.isnan(a) or a for a in command.numbers] == [math.isnan(b) or b for b in expected]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("stream", "expected ross stream WHOM ADDRESS:PORT"),
        ("stream target", "expected ross stream WHOM ADDRESS:PORT"),
        ("stream somebody 127.0.0.1:5004", "expected ross stream WHOM ADDRESS:PORT"),
        ("stream target 239.0.0.1:5004", "address: expected that of one computer, got 239.0.0.1"),
        ("stream target 127.0.0.1:5004/mp3", "codec: expected opus or L16, got 'mp3'"),
        ("stream source x 127.0.0.1:5004", "expected a number, got 'x'"),
        ("stream 300 mixture", "stream: expected 0 to 254, got 300.0"),
        ("stream 1 99", "gain: expected -100 to 40, got 99.0"),
        ("enrol source 1", "expected ross enrol WHOM consent"),
        ("enrol source 1 consent 1 2 3", "expected ross enrol WHOM consent"),
        ("enrol source 1 consent 1 999", "seconds: expected 0 to 300, got 999.0"),
    ],
)
def test_a_mistake_is_one_line_and_orders_nothing(line, words):
    sent, said = [], []
    shell = Shell(CommandProtocol(lambda message, who: sent.append(message), 255, 230), said.append)
    for value in full(30.0, 3, 1):
        for packet in Decoder().feed(Encoder(1, 191).encode(value)):
            shell.on_packet(packet, 0.0)
    shell.execute(line.split())
    assert sent == []
    (text,) = said
    assert text.startswith("ross: ")
    assert words in text


@pytest.mark.parametrize(
    "mapping",
    [
        {"kind": "stream"},
        {"kind": "stream", "what": "target"},
        {"kind": "stream", "what": "all", "stream": 0},
        {"kind": "stream", "what": "target", "address": "127.0.0.1"},
        {"kind": "stream", "what": "target", "address": "127.0.0.1", "port": "5004"},
        {"kind": "stream", "what": "target", "address": "127.0.0.1", "port": 70000},
        {"kind": "stream", "what": "target", "address": ["127.0.0.1"], "port": 5004},
        {"kind": "stream", "what": "target", "address": "255.255.255.255", "port": 5004},
        {"kind": "stream", "what": "source", "address": "127.0.0.1", "port": 5004},
        {"kind": "stream", "stream": 0, "muted": 1},
        {"kind": "stream", "stream": 0, "port": 5004},
        {"kind": "stream", "stream": 0, "gain": math.nan},
        {"kind": "stop_stream", "stream": 0.5},
        {"kind": "stop_stream", "address": "127.0.0.1"},
        {"kind": "stop_stream", "port": 5004},
        {"kind": "stop_stream", "stream": 0, "address": "127.0.0.1", "port": 5004},
        {"kind": "enrol", "source": 1},
        {"kind": "enrol", "source": 1, "consent": 1},
        {"kind": "enrol", "consent": True},
        {"kind": "enrol", "source": 1, "azimuth": 2, "consent": True},
    ],
)
def test_an_order_that_cannot_be_meant_is_refused(mapping):
    with pytest.raises(ValueError, match="expected"):
        order_of(mapping)


# ------------------------------------------------------------------------------------------- client


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


def with_payload(station, work):
    async def claim():
        async with Payload(station, PAYLOAD) as payload:
            return await work(payload)

    return asyncio.run(asyncio.wait_for(claim(), 60))


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


# ------------------------------------------------------------------------------------------- session descriptions

SDP = "v=0\r\no=- 1 1 IN IP4 10.0.0.1\r\ns=RoSS stream 0\r\n" + "a=long\r\n" * 200


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


def test_a_stream_without_a_description_is_refused(sky):
    station = Filing(Served(sky()))

    async def work(payload):
        with pytest.raises(RefusedByPayload, match=r"stream-3\.sdp: there is no such file"):
            await payload.session_description(3)

    with_payload(station, work)


@pytest.mark.parametrize(
    "latest",
    [Stream(what="mixture", address=HERE[0], port=HERE[1]), StopStream(3), StopStream(), StopStream(None, *HERE)],
)
def test_an_order_to_stream_is_not_said_again_after_one_that_replaces_it(latest):
    sent = []
    orders = CommandProtocol(lambda message, who: sent.append(tuple(message.to_dict().values())), 254, 190)
    first = orders.order(PAYLOAD, Stream(what="target", address=HERE[0], port=HERE[1]))
    said = sent[0]
    orders.order(PAYLOAD, latest)
    for second in range(1, 30):
        orders.tick(second / 2)
    repeated = [each for each in sent[1:] if each[:8] == said[:8]]
    assert len(sent) > 2, "the latest is said again"
    assert not repeated
    assert next(each.state for each in orders.doing if each.number == first) == "cancelled"


def test_orders_about_other_streams_do_not_replace_each_other():
    here, there = Stream(what="target", address=HERE[0], port=1), Stream(what="target", address=HERE[0], port=2)
    assert not here.replaces(there)
    assert here.replaces(Stream(what="mixture", address=HERE[0], port=1))
    assert not StopStream(1).replaces(Stream(stream=2, muted=True))
    assert not StopStream(None, HERE[0], 2).replaces(here)
