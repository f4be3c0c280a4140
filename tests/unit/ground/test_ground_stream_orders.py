"""Orders to stream and to enrol: from words and JSON to commands, and which of them replaces which."""

import math

import pytest

from emulated_scene import full
from hand_station import PAYLOAD
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.client.order_json import order_of
from ross_payload.ground.client.stream_orders import Enrol, StopStream, Stream
from ross_payload.ground.mavproxy.shell import Shell
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import command_of

HERE = ("127.0.0.1", 5004)


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


@pytest.mark.parametrize("which", [{"stream": -1}, {"port": 5004}, {"address": "", "port": 5004}], ids=str)
def test_what_names_no_stream_does_not_end_all_of_them(which):
    with pytest.raises(ValueError, match="expected"):
        StopStream(**which)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("stream", "expected ross stream WHOM ADDRESS:PORT"),
        ("stream target", "expected ross stream WHOM ADDRESS:PORT"),
        ("stream somebody 127.0.0.1:5004", "expected ross stream WHOM ADDRESS:PORT"),
        ("stream target 239.0.0.1:5004", "address: expected that of one computer, got 239.0.0.1"),
        ("stream target 127.0.0.1:5004/mp3", "codec: expected opus or L16, got 'mp3'"),
        ("stream source x 127.0.0.1:5004", "expected a number, got 'x'"),
        ("stream 300 mixture", "stream: expected 0 to 254, got 300"),
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
