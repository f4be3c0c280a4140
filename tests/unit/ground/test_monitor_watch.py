"""Keys of the monitor, and whom they are for."""

import pytest

from emulated_scene import full
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.terminal.controller import Controller
from ross_payload.ground.terminal.keyboard import keys
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import command_of
from ross_protocols.mavlink.component_id import ComponentId

STOP, EXPLORE, LISTEN, CANCEL, REARM = 54004, 54000, 54001, 54005, 54009
STOPS = [("s", STOP), ("S", STOP), ("\x13", STOP)]  # Shift, caps lock and Ctrl take nothing from a stop
KEYS = [*STOPS, ("e", EXPLORE), ("v", LISTEN), ("c", CANCEL), ("r", REARM)]


class Bench:
    """Payloads that were heard, and a watch whose orders are kept."""

    def __init__(self, *systems, wanted=None):
        self.fleet, self.sent = Fleet(), []
        orders = CommandProtocol(lambda message, who: self.sent.append((who, command_of(message))), 255, 190)
        self.watch = Controller(self.fleet, orders, wanted)
        for system in systems:
            self.hear(system)

    def hear(self, system, at=0.0, sources=3):
        encoder, decoder = Encoder(system, 191), Decoder()
        for value in full(30.0, sources, system):
            for packet in decoder.feed(encoder.encode(value)):
                self.fleet.on_packet(packet, at)

    def press(self, *pressed):
        for key in pressed:
            self.watch.press(key)
        return self

    @property
    def orders(self):
        return [(who.system, command.number) for who, command in self.sent]


@pytest.mark.parametrize(("key", "number"), KEYS)
def test_keys_order(key, number):
    assert Bench(1).press(key).orders == [(1, number)]


def test_arrows_choose_a_source_and_l_listens_to_it():
    bench = Bench(1).press("right", "right", "l")
    assert bench.watch.chosen == 1
    assert bench.sent[0][1].numbers[:2] == (1.0, 1.0)


@pytest.mark.parametrize(("pressed", "chosen"), [(["left"], 2), (["right"] * 4, 0), (["right", "left", "left"], 1)])
def test_arrows_go_round(pressed, chosen):
    assert Bench(1).press(*pressed).watch.chosen == chosen


def test_l_without_a_source_says_what_to_do_and_orders_nothing():
    bench = Bench(1).press("l")
    assert bench.orders == []
    assert "arrow keys" in bench.watch.note


def test_a_source_that_is_gone_is_not_listened_to():
    bench = Bench(1).press("left")
    bench.fleet.payloads.clear()
    bench.hear(1, sources=2)
    assert bench.watch.chosen is None


def test_digits_choose_a_payload_and_orders_go_there():
    bench = Bench(4, 2).press("2", "s")
    assert bench.orders == [(4, STOP)]
    assert [(name, this) for name, this, _ in bench.watch.others] == [("2-191", False), ("4-191", True)]


def test_a_payload_that_is_not_there_is_not_chosen():
    bench = Bench(2).press("3", "s")
    assert bench.orders == [(2, STOP)]
    assert "no payload 3" in Bench(2).press("3").watch.note


def test_the_first_that_is_heard_is_looked_at_unless_another_is_wanted():
    assert Bench(4, 2).watch.payload.who == ComponentId(4, 191)
    assert Bench(4, 2, wanted=ComponentId(2, 191)).watch.payload.who == ComponentId(2, 191)
    assert Bench(4, wanted=ComponentId(2, 191)).watch.payload is None


def test_without_a_payload_nothing_is_ordered_and_that_is_said():
    bench = Bench().press("s")
    assert bench.orders == []
    assert "no payload to command" in bench.watch.note


def test_who_is_wanted_may_hear_a_stop_though_nobody_hears_it():
    bench = Bench(4, wanted=ComponentId(2, 191)).press("e", "s")
    assert bench.orders == [(2, STOP)]


def test_a_note_goes_after_a_moment():
    bench = Bench().press("s")
    bench.watch.tick(10.0)
    assert bench.watch.note == ""


def test_who_is_silent_is_called_so():
    bench = Bench(1)
    bench.watch.tick(2.0)
    assert bench.watch.others[0][2] == "run"
    bench.watch.tick(4.0)
    assert bench.watch.others[0][2] == "no telemetry"


@pytest.mark.parametrize("key", ["q", "\x03", "\x04"])
def test_it_can_be_left(key):
    assert not Bench(1).press(key).watch.going


@pytest.mark.parametrize("key", ["y", "E", "0", " ", "\x1b", "\xff"])
def test_other_keys_do_nothing(key):
    bench = Bench(1).press(key)
    assert bench.orders == []
    assert bench.watch.going


@pytest.mark.parametrize(
    ("data", "pressed"),
    [
        (b"se", ["s", "e"]),
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ["up", "down", "right", "left"]),
        (b"\x1bOC", ["right"]),
        (b"\x1b[1;5Cq", ["right", "q"]),
        (b"\x1b[15~s", ["s"]),
        (b"\x1b", []),
        (b"\x1bs", ["s"]),
        (b"\x1b[", ["["]),
        (b"", []),
    ],
)
def test_what_a_terminal_sends_is_read(data, pressed):
    assert list(keys(data)) == pressed


def test_letters_of_every_script_are_no_keys_and_take_none_away():
    letters = "".join(map(chr, range(0xA0, 0x800)))
    bench = Bench(1).press(*keys(f"{letters}s".encode()))
    assert bench.orders == [(1, STOP)]
