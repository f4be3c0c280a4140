"""Live listening in the monitor: who is heard where, and the keys that have a voice sent."""

import math
from dataclasses import replace

import pytest
from click.testing import CliRunner

from emulated_scene import full
from fleet_ear import FILE, RTP, Ground
from ross_payload.ground.client.command_protocol import CommandProtocol
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
from ross_protocols.mavlink.commands import command_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_values import Selection


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
