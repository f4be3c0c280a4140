"""What QGroundControl does with parameters, as its source has it, both ways, and the actions that it offers."""

import json
from pathlib import Path

import pytest

from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.config.parameter_table import TABLE
from ross_payload.mavlink.command_parser import READERS, Record, asked
from ross_payload.mavlink.component_info import files
from ross_payload.mavlink.ftp_server import FtpServer
from ross_payload.mavlink.param_server import GREETINGS, ParamServer
from ross_payload.orders import Stop
from ross_protocols.mavlink.commands import Command
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross
from ross_protocols.mavlink.ftp import Opcode, Packet, message_of, packet_of

GCS, COPTER = 6, 2  # MAV_TYPE
ACTIONS = Path(__file__).parents[3] / "docs" / "examples" / "qgroundcontrol-actions.json"
KINDS = {"label": str, "description": str, "mavCmd": int, "compId": int} | {
    f"param{n}": (int, float) for n in range(1, 8)
}


class QGroundControl:
    """A ground station beside a payload that answers about parameters and files.

    It loads the parameters of the autopilot (component 1) as one file, and asks everybody for a list only when that
    fails; of any other component it asks for what is missing as soon as it has heard one value of it.
    """

    def __init__(self, sky):
        self.sky, self.ground = sky, sky.ground
        self.parameters = Parameters(Config(), None)
        component = sky.links.component(191)
        self.servers = (
            ParamServer(component, self.parameters, lambda *change: None, lambda *text: None),
            FtpServer(component, files()),
        )
        self.found, self.values, self.answers = {}, 0, []
        self.beating = True
        self._ticks = 0

    def live(self, seconds, fetch=True):
        """Let time pass: a heartbeat a second, and four times a second a question for what is still missing."""
        for _ in range(round(seconds * 100)):
            if self.beating and self._ticks % 100 == 0:
                self.ground.send(ross.MAVLink_heartbeat_message(GCS, 8, 0, 0, 4, 3))
            if fetch and self.found and self._ticks % 25 == 0:
                self._ask_for_the_missing()
            self._ticks += 1
            for message in self.sky.wait(0.01, *self.servers):
                self._take(message)

    def load_as_a_file(self):
        """Ask the autopilot for its parameters as a file; tell whether anybody answers."""
        name = b"@PARAM/param.pck?withdefaults=1"
        self.ground.send(message_of(Packet(1, Opcode.OPEN_RO, size=len(name), data=name), ComponentId(1, 1)))
        self.live(1.0)
        return [answer for answer in self.answers if answer.opcode == Opcode.ACK]

    def _ask_for_the_missing(self):
        for index in [index for index in range(len(TABLE)) if index not in self.found.values()][:10]:
            self.ground.send(ross.MAVLink_param_request_read_message(1, 191, b"", index))

    def _take(self, message):
        if message.get_type() == "PARAM_VALUE":
            assert message.param_count == len(TABLE)
            self.values += 1
            self.found[message.param_id] = message.param_index
        answer = packet_of(message)
        if answer is not None:
            self.answers.append(answer)


@pytest.fixture
def station(sky):
    return QGroundControl(sky())


def test_it_fetches_our_parameters_after_the_one_value_that_is_told_unasked(station):
    station.live(5.0)
    assert set(station.found) == set(TABLE)


def test_its_list_is_answered_when_the_autopilot_has_no_file_of_parameters(station):
    station.beating = False
    assert not station.load_as_a_file()
    assert station.found == {}, "nobody has asked us, and no station has appeared"
    station.ground.send(ross.MAVLink_param_request_list_message(1, 0))
    station.live(1.0, fetch=False)
    assert set(station.found) == set(TABLE)


def test_a_station_that_asks_for_nothing_is_told_three_values_and_no_more(station):
    station.live(60.0, fetch=False)
    assert station.values == GREETINGS


def test_a_station_that_has_asked_is_told_nothing_more_unasked(station):
    station.live(4.0)
    told = station.values
    station.live(30.0)
    assert station.values == told


def test_a_station_that_has_restarted_is_told_again(station):
    station.live(5.0)
    station.beating, station.values, station.found = False, 0, {}
    station.live(6.0)
    assert station.values == 0
    station.beating = True
    station.live(5.0)
    assert set(station.found) == set(TABLE)


def test_heartbeats_of_others_bring_no_values(station):
    station.beating = False
    for _ in range(10):
        station.ground.send(ross.MAVLink_heartbeat_message(COPTER, 3, 0, 0, 4, 3))
        station.live(0.5)
    assert station.values == 0


def test_a_flood_of_stations_is_told_little(station):
    station.beating = False
    voice = station.ground.mavlink
    for number in range(200):
        voice.srcSystem, voice.srcComponent = 100 + number % 100, 1 + number // 100
        station.ground.send(ross.MAVLink_heartbeat_message(GCS, 8, 0, 0, 4, 3))
        station.live(0.05, fetch=False)
    assert 8 <= station.values <= 20  # in 10 s


def test_its_actions_are_orders_to_us():
    """What QGroundControl requires of such a file, and what we make of each action."""
    told = json.loads(ACTIONS.read_text(encoding="utf-8"))
    assert (told["version"], told["fileType"]) == (1, "MavlinkActions")
    orders = []
    for action in told["actions"]:
        assert {"label", "description", "mavCmd", "compId"} <= set(action) <= set(KINDS)
        assert all(isinstance(value, KINDS[name]) for name, value in action.items())
        assert action["compId"] == Config().telemetry.component_id
        numbers = tuple(float(action.get(f"param{n}", 0)) for n in range(1, 8))
        orders.append(asked(Command(action["mavCmd"], numbers, ComponentId(1, 191), long=True)))
    assert isinstance(orders[0], Stop), "the stop comes first"
    assert len({action["label"] for action in told["actions"]}) == len(orders)
    everything = {action["mavCmd"] for action in told["actions"]}
    with_numbers = {ross.MAV_CMD_ROSS_INFORM, ross.MAV_CMD_ROSS_TURN, ross.MAV_CMD_ROSS_ENROL}  # that one must type
    assert everything == set(READERS) - with_numbers
    assert {order.on for order in orders if isinstance(order, Record)} == {True, False}
