"""What an autopilot does not pass on is not lost: behind a router the loss is unknown, and said to be.

The router is the simulated ArduPilot: messages of ids that it does not know go nowhere, what has a target goes only
where that was heard.
"""

import json

import pytest
from click.testing import CliRunner

from fleet_ear import status
from flight_logs import UNIX, record
from ross_payload.ground.flights.command import command
from ross_payload.ground.flights.frame_stats import tallies
from ross_payload.ground.flights.playback import Playback
from ross_payload.ground.mavproxy.shell import Shell
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.health import condition
from ross_payload.ground.model.view import view
from ross_payload.ground.terminal import blocks
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.peers import Peers
from ross_protocols.mavlink.tunnel import Wrapper
from ross_sim.autopilot.mavlink_routing import RoutingTable

PAYLOAD, AUTOPILOT, STATION, OTHER = (1, 191), (1, 1), (255, 190), (254, 190)
WHO = ComponentId(*PAYLOAD)
STATION_BEAT = common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
AUTOPILOT_BEAT = common.MAVLink_heartbeat_message(2, 3, 81, 0, 4, 3)
ACK = common.MAVLink_command_ack_message(54000, 0, 0, 0, *OTHER)  # concerns nobody but the other station
EVERYBODY = (PAYLOAD, AUTOPILOT, STATION, OTHER)


class Air:
    """An autopilot with a payload and two ground stations on links of their own; ``heard`` is what one station hears.

    With ``mine`` as in a log: what the station says itself is in it, too.
    """

    def __init__(self, *, autopilot=True, mine=False):
        self._voices = {who: Encoder(*who) for who in EVERYBODY}
        self._ears = {who: Decoder() for who in EVERYBODY}
        self._router, self._autopilot, self._mine = RoutingTable(1), autopilot, mine
        self.heard, self.frames = [], []
        self.say(STATION, STATION_BEAT)
        self.say(OTHER, STATION_BEAT)

    def say(self, who, message, lost=False):
        frame = self._voices[who].encode(message)
        for packet in self._ears[who].feed(frame):
            if not self._autopilot:
                reached = who == PAYLOAD
            elif who == AUTOPILOT:
                reached = True
            else:
                reached = str(STATION) in self._router.way(str(who), packet).links
            if (reached and not lost) or (self._mine and who == STATION):
                self.heard.append(packet)
                self.frames.append(frame)

    def live(self, steps=200, drop=lambda step: False):
        tunnel = Wrapper(*PAYLOAD)
        for step in range(steps):
            self.say(PAYLOAD, status(step / 10) if not self._autopilot else tunnel.wrap(status(step / 10)), drop(step))
            self.say(PAYLOAD, v.Audio(time_usec=step))  # an autopilot knows no such message
            if step % 5 == 0:
                self.say(AUTOPILOT, AUTOPILOT_BEAT)
                self.say(STATION, STATION_BEAT)
                self.say(PAYLOAD, ACK)
                self.say(PAYLOAD, v.Named(step / 10, "ross_k", 3.0))
        return self

    def fleet(self, way=None):
        fleet = Fleet()
        for step, packet in enumerate(self.heard):
            fleet.on_packet(packet, step / 20, way)
        return fleet


def log(folder, air):
    path = folder / "flight.tlog"
    path.write_bytes(b"".join(record(UNIX + 50_000 * step, frame) for step, frame in enumerate(air.frames)))
    return path


@pytest.mark.parametrize("way", [None, (0, "10.0.0.1")])
def test_frames_that_an_autopilot_keeps_to_itself_are_not_lost(way):
    known = Air().live().fleet(way).payloads[WHO]
    assert known.counts.missing > 200, "the autopilot passes on everything"
    assert known.counts.lost is None
    reception = condition(known)["reception"]
    assert (reception["level"], reception["lost"]) == ("good", None)
    assert reception["words"] == "loss unknown: its frames come through a router"
    assert "loss unknown" in "\n".join(line.plain for line in blocks.health(view(known)))


def test_frames_that_a_direct_link_loses_are_lost():
    known = Air(autopilot=False).live(drop=lambda step: step % 4 == 1).fleet((0, "10.0.0.1")).payloads[WHO]
    assert known.counts.lost == 50
    assert condition(known)["reception"]["level"] == "watch"


def test_a_direct_link_is_judged_by_itself_beside_one_to_the_autopilot():
    fleet, step = Fleet(), 0
    for packet in Air().live(20).heard:
        if packet.component_id == 1:
            fleet.on_packet(packet, 0.0, (1, "radio"))
    for packet in Air(autopilot=False).live(100, drop=lambda step: step % 4 == 1).heard:
        fleet.on_packet(packet, step, (0, "cable"))
    assert fleet.payloads[WHO].counts.lost == 25


def test_mavproxy_tells_no_loss_behind_an_autopilot():
    said = []
    shell = Shell(NoCommands(), said.append)
    for step, packet in enumerate(Air().live().heard):
        shell.on_packet(packet, step / 20)
    shell.execute(["status"])
    assert "loss unknown: its frames come through a router" in "\n".join(said)
    assert "of its frames were lost" not in "\n".join(said)


class NoCommands:
    """Orders that nobody gives."""

    doing = ()

    def on_packet(self, packet, now):
        """Hear."""

    def on_state(self, state):
        """Meet."""

    def tick(self, now):
        """Let time go on."""


@pytest.mark.parametrize("mine", [False, True], ids=["heard", "heard and said"])
def test_a_log_behind_an_autopilot_tells_no_loss(tmp_path, opened, mine):
    path = log(tmp_path, Air(mine=mine).live())
    counted = tallies(opened(path.read_bytes()))
    assert counted[WHO].lost is None
    told = CliRunner().invoke(command, [str(path)], env={"COLUMNS": "200"}).output
    assert "loss unknown: they came through a router" in told
    told = json.loads(CliRunner().invoke(command, [str(path), "--json"]).output)
    assert told["payloads"][0]["lost"] is None


@pytest.mark.parametrize(("other", "lost"), [(AUTOPILOT, None), (STATION, 50)], ids=["behind an autopilot", "direct"])
def test_a_log_that_is_played_tells_the_same_loss_also_of_an_autopilot_that_does_not_know_where_it_is(
    opened, other, lost
):
    voice, payload = Encoder(*other), Encoder(*PAYLOAD)
    beats = [voice.encode(AUTOPILOT_BEAT if other == AUTOPILOT else STATION_BEAT) for _ in range(10)]
    frames = [payload.encode(status(step / 20)) for step in range(200)]
    kept = [frame for step, frame in enumerate(frames) if step % 4 != 1]
    flight = opened(b"".join(record(UNIX + 50_000 * step, frame) for step, frame in enumerate([*beats, *kept])))
    playback = Playback(flight)
    playback.seek(flight.duration)
    assert playback.fleet.payloads[WHO].counts.lost == tallies(flight)[WHO].lost == lost


def test_a_log_of_a_direct_link_tells_its_loss_though_the_station_is_in_it(tmp_path, opened):
    air = Air(autopilot=False, mine=True).live(drop=lambda step: step % 4 == 1)
    assert ComponentId(*STATION) in tallies(opened(log(tmp_path, air).read_bytes()))
    assert tallies(opened(log(tmp_path, air).read_bytes()))[WHO].lost == 50


def test_a_link_of_the_payload_to_an_autopilot_tells_no_loss_of_what_it_routes():
    peers, direct = Peers(), Peers()
    for packet in Air().live().heard:
        peers.meet(packet, 0.0)
    for packet in Air(autopilot=False).live(drop=lambda step: step % 4 == 1).heard:
        direct.meet(packet, 0.0)
    assert (peers.lost, direct.lost) == (None, 50)


def test_an_unknown_loss_of_a_link_crosses_the_wire_as_unknown():
    link = v.LinkReport(0, 0, 1, "udpin:0.0.0.0:14550", up=True, autopilot=True, received=100, lost=None)
    (packet,) = Decoder().feed(Encoder(*PAYLOAD).encode(link))
    assert packet.value.lost is None
    fleet = Fleet()
    fleet.on_packet(packet, 0.0)
    (told,) = condition(fleet.payloads[WHO])["links"]
    assert (told["level"], told["lost"]) == ("good", None)
    assert told["words"] == "loss unknown: messages reach the payload through a router"
