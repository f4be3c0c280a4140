"""How our module uses what MAVProxy gives it; a stand-in plays MAVProxy, which is another process's business."""

import time
from types import SimpleNamespace

import pytest

from emulated_scene import full
from ross_payload.ground.mavproxy.mavproxy_ross import Hooks
from ross_protocols.mavlink.codec import Decoder, Encoder


class Link:
    """A master: what it sends is kept; on some, a system was heard at a time."""

    def __init__(self, **beats):
        self.sent = []
        self.mav = SimpleNamespace(send=self.sent.append)
        self.sysid_state = {
            int(system.removeprefix("system")): SimpleNamespace(messages={"HEARTBEAT": SimpleNamespace(_timestamp=at)})
            for system, at in beats.items()
        }


class StandIn:
    """MAVProxy's own module class."""

    def __init__(self, mpstate, name, description, public, multi_vehicle):
        assert multi_vehicle, "else only one vehicle's messages come"
        self.commands = {}

    def add_command(self, name, callback, description, completions):
        self.commands[name] = callback


class Module(Hooks, StandIn):
    pass


class Console:
    def __init__(self):
        self.shown = []

    def set_status(self, name, text, row, fg):
        self.shown.append((text, fg))


@pytest.fixture
def make():
    def build(*links):
        settings = SimpleNamespace(source_system=255, source_component=230)
        state = SimpleNamespace(settings=settings, mav_master=list(links), console=Console())
        module = Module(state)
        encoder, decoder = Encoder(1, 191), Decoder()
        for value in full(30.0, 3, 1):
            for packet in decoder.feed(encoder.encode(value)):
                module.mavlink_packet(packet.message)
        return module, state

    return build


def test_an_order_goes_only_where_the_payload_was_heard_last(make):
    elsewhere, before, latest = Link(system9=30.0), Link(system1=10.0), Link(system1=20.0)
    module, _ = make(elsewhere, before, latest)
    module.commands["ross"](["stop"])
    assert [len(link.sent) for link in (elsewhere, before, latest)] == [0, 0, 1]
    assert latest.sent[0].command == 54004


def test_where_nobody_knows_it_goes_everywhere(make):
    one, other = Link(), Link()
    module, _ = make(one, other)
    module.commands["ross"](["stop"])
    assert len(one.sent) == len(other.sent) == 1


def test_the_status_bar_is_written_when_it_changes(make):
    module, state = make(Link())
    for _ in range(3):
        module.idle_task()
        time.sleep(0.11)
    assert state.console.shown == [("RoSS 1-191 run K 3", "green")]


def test_bad_data_passes_by(make):
    module, _ = make(Link())
    module.mavlink_packet(SimpleNamespace(get_type=lambda: "BAD_DATA"))
