"""A whole payload, but for its sockets, among frames that are well formed and mean nothing, or come from strangers."""

import random
from contextlib import ExitStack, contextmanager

import pytest
from fastcrc.crc16 import mcrf4xx

from ross_payload.actuators.wires import open_wire
from ross_payload.audio.channel_map import ChannelMap
from ross_payload.audio.file_source import FileSource
from ross_payload.config import Config, Link, Telemetry
from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE
from ross_payload.events import StateChanged
from ross_payload.interfaces import Attitude
from ross_payload.mavlink import Router
from ross_payload.mount import mount_of
from ross_payload.orders import Shutdown
from ross_payload.service.payload import Parts, assembled
from ross_payload.sessions.session_store import SessionStore
from ross_payload.timebase import Timebase
from ross_payload.transport.ports import Counts
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import command_of
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import MESSAGES, common
from ross_protocols.mavlink.params import ListRequest, ReadRequest, SetRequest, request_of
from ross_sim.clock import SimClock
from ross_sim.sitl.recording import drained

OURS, OPERATOR = (1, 191), 200
URL = "udpin:127.0.0.1:14550"
EACH = 100  # frames in a poll
KNOWN = sorted(MESSAGES)


def framed(number, payload, sender, dice):
    """Return a frame with a good checksum."""
    extra = MESSAGES[number].crc_extra if number in MESSAGES else dice.randrange(256)
    head = bytes([len(payload), 0, dice.randrange(256), dice.randrange(256), *sender])
    body = head + number.to_bytes(3, "little") + payload
    return b"\xfd" + body + mcrf4xx(body + bytes([extra]), 0xFFFF).to_bytes(2, "little")


def senseless(dice):
    """A frame of any message with any contents and targets from anybody but us."""
    number = dice.choice(KNOWN) if dice.random() < 0.95 else dice.randrange(1 << 24)
    payload = dice.choice([dice.randbytes, bytes, lambda size: b"\xff" * size])(dice.randrange(1, 256))
    sender = dice.choice([0, 1, 1, 255, dice.randrange(256)]), dice.choice([0, 1, 154, 190, dice.randrange(256)])
    return framed(number, payload, sender, dice)


def meant_for_us(message):
    """Whether a message asks us to change something: by a command, or a parameter that we have."""
    request = command_of(message) or request_of(message)
    if (
        request is None
        or isinstance(request, (ListRequest, ReadRequest))
        or not request.target.includes(ComponentId(*OURS))
    ):
        return False
    return not isinstance(request, SetRequest) or request.name in TABLE


def harmless(dice):
    """Frames of `senseless` that ask us to change nothing."""
    decoder = Decoder()
    while True:
        frame = senseless(dice)
        known = int.from_bytes(frame[7:10], "little") in MESSAGES
        if not known or not any(meant_for_us(packet.message) for packet in decoder.feed(frame)):
            yield frame


def orders_of_strangers(dice):
    """Orders without a fault, from anybody but the one who may give them."""
    names, encoders = sorted(TABLE), {}
    while True:
        sender = dice.choice([system for system in (0, 1, 2, 199, 201, 254, 255) if system != OPERATOR]), 190
        say = encoders.setdefault(sender, Encoder(*sender)).encode
        target = dice.choice([0, 1]), dice.choice([0, 191])
        number = dice.choice([*range(54000, 54011), 410, 511, 512, 246])
        numbers = [float(dice.choice([0, 1, 2, 45, 54001])) for _ in range(7)]
        name, value = dice.choice(names).encode(), dice.choice([1.0, 2.0, 5.0])
        yield say(
            dice.choice(
                [
                    common.MAVLink_command_long_message(*target, number, 0, *numbers),
                    common.MAVLink_command_int_message(*target, 0, number, 0, 0, *numbers[:4], 1, 2, 3.0),
                    common.MAVLink_param_set_message(*target, name, value, common.MAV_PARAM_TYPE_REAL32),
                ]
            )
        )


class Storm:
    """The port of a link on which so many frames come; when they are over, ``done`` is called."""

    def __init__(self, frames, count):
        self.counts = Counts()
        self.done = lambda: None
        self.sent = 0
        self._frames, self._left = frames, count

    def send(self, frame):
        self.sent += 1

    def receive(self):
        if not self._left:
            self.done()
            return []
        self._left -= EACH
        return [next(self._frames) for _ in range(EACH)]

    def close(self):
        """Nothing to give back."""


class Witness:
    """An observer that keeps what the mission was told and said."""

    def __init__(self):
        self.orders, self.states, self.attitudes = [], [], set()

    def on_input(self, heard):
        self.orders += heard.orders
        self.attitudes.add(heard.attitude)

    def on_event(self, event, heard):
        if isinstance(event, StateChanged):
            self.states.append(event.state.name)


@contextmanager
def payload(folder, noise, storm, accept):
    """A payload in simulated time, with one link."""
    config, clock = Config(telemetry=Telemetry(system_id=OURS[0], component_id=OURS[1])), SimClock()
    with ExitStack() as stack:
        links = stack.enter_context(Router(clock, OURS[0], folder))
        links.attach(Link(url=URL, accept=accept), storm)
        timebase = Timebase(clock)
        timebase.attach(links.component(OURS[1]))
        parts = Parts(
            clock=clock,
            source=FileSource(noise, config.audio.rate_hz, ChannelMap.of(config.audio), clock),
            open_port=lambda url: open_wire(url, clock),
            links=links,
            mount=mount_of(config, clock, links, timebase),
            timebase=timebase,
            parameters=stack.enter_context(Parameters(config, folder / "params.toml")),
            store=SessionStore(folder / "recordings"),
            drained=drained(clock),
        )
        witness = Witness()
        runner = stack.enter_context(assembled(parts, (witness,)))
        storm.done = lambda: runner.order(Shutdown())
        yield parts, runner, witness


def endured(folder, noise, frames, count, accept=()):
    """Let frames come; nothing of the payload may be other than it was."""
    storm = Storm(frames, count)
    with payload(folder, noise, storm, accept) as (parts, runner, witness):
        before = parts.parameters.config
        runner.run()
        assert parts.parameters.config == before
        assert (parts.links.system_id, parts.timebase.unix) == (OURS[0], False)
        (status,) = parts.links.status()
    assert witness.states == ["IDLE"]
    assert {type(order) for order in witness.orders} <= {Shutdown}
    assert witness.attitudes == {Attitude(0.0, known=False)}
    assert not (folder / "params.toml").exists()
    assert not list(folder.glob("recordings/*"))
    assert status.received + status.unknown == count
    assert status.bad == 0
    assert len(status.peers) <= 64
    return status


def test_what_asks_for_nothing_changes_nothing(tmp_path, noise):
    endured(tmp_path, noise, harmless(random.Random(7)), 4000)  # noqa: S311


def test_orders_of_strangers_change_nothing(tmp_path, noise):
    endured(tmp_path, noise, orders_of_strangers(random.Random(8)), 4000, accept=(OPERATOR,))  # noqa: S311


def test_anything_from_strangers_changes_nothing(tmp_path, noise):
    frames = (frame for frame in iter(lambda: senseless(dice), None) if frame[5] != OPERATOR)
    dice = random.Random(9)  # noqa: S311
    endured(tmp_path, noise, frames, 4000, accept=(OPERATOR,))


def test_an_order_of_who_may_give_it_changes_something(tmp_path, noise):
    """So that the tests above can fail."""
    dice = random.Random(8)  # noqa: S311
    strangers = orders_of_strangers(dice)
    trusted = (framed(int.from_bytes(f[7:10], "little"), f[10:-2], (OPERATOR, 190), dice) for f in strangers)
    storm = Storm(trusted, 1000)
    with payload(tmp_path, noise, storm, (OPERATOR,)) as (parts, runner, witness):
        before = parts.parameters.config
        runner.run()
        assert parts.parameters.config != before
    assert len(witness.orders) > 1


@pytest.mark.soak
def test_a_million_frames_change_nothing(tmp_path, noise):
    endured(tmp_path, noise, harmless(random.Random(10)), 1_000_000)  # noqa: S311
