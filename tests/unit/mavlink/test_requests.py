"""Messages on request: once, more often, less often, and never."""

import math
from types import SimpleNamespace

import pytest
from pymavlink.dialects.v20 import common

from ross_payload import __version__
from ross_payload.mavlink.component_info import version_number
from ross_payload.mavlink.message_requests import MessageRequests
from ross_payload.mavlink.mission_commands import MissionCommands
from ross_protocols.mavlink.dialect import ross

STATUS, SOURCE, HEARTBEAT, VERSION, PROTOCOL = 54001, 54002, 0, 148, 300
MESSAGE_INTERVAL = 244
REQUEST, SET, GET = 512, 511, 510
ACCEPTED, TEMPORARILY_REJECTED, DENIED = 0, 1, 2
URL = "udpout:127.0.0.1:14550"


class Streams:
    """Two streams per link, one of which has something to tell."""

    def __init__(self):
        self.usual = {STATUS: 0.25, HEARTBEAT: 1.0, SOURCE: 5.0}
        self.asked, self.requested = {}, []

    def request(self, link, message_id):
        self.requested.append((link, message_id))
        return message_id != SOURCE

    def period(self, link, message_id):
        return self.asked.get((link, message_id), self.usual.get(message_id))

    def set_period(self, link, message_id, period):
        self.asked.pop((link, message_id), None)
        if period is not None:
            self.asked[link, message_id] = period
        return message_id in self.usual


@pytest.fixture
def payload(sky):
    made = sky()
    component, streams, texts = made.links.component(191), Streams(), []
    server = MissionCommands(
        component,
        lambda order: None,
        lambda on: "",
        lambda _, text: texts.append(text),
        MessageRequests(component, streams),
    )

    def ask(number, *numbers, **how):
        """Command something; return the results and the other messages that come back."""
        made.ground.long(number, *numbers, **how)
        heard = made.wait(0.05, server)
        results = [message.result for message in heard if message.get_type() == "COMMAND_ACK"]
        return results, [message for message in heard if message.get_type() != "COMMAND_ACK"]

    return SimpleNamespace(ask=ask, streams=streams, texts=texts, clock=made.clock)


def test_a_message_is_requested_from_the_stream_of_the_link_that_asks(payload):
    assert payload.ask(REQUEST, STATUS) == ([ACCEPTED], [])
    assert payload.streams.requested == [(URL, STATUS)]


def test_a_message_with_nothing_to_tell_is_rejected_for_now(payload):
    assert payload.ask(REQUEST, SOURCE)[0] == [TEMPORARILY_REJECTED]


@pytest.mark.parametrize("message_id", [30, 54019, -1, 0.5, 2**24, math.nan, math.inf])
def test_a_message_that_we_do_not_send_is_denied_but_not_to_all(payload, message_id):
    assert payload.ask(REQUEST, message_id) == ([DENIED], [])
    assert payload.ask(REQUEST, message_id, target=(0, 0)) == ([], [])


@pytest.mark.parametrize("command", [(REQUEST, VERSION), (520, 1)])
def test_our_version_is_told_on_request(payload, command):
    results, (version,) = payload.ask(*command)
    assert results == [ACCEPTED]
    assert version.get_type() == "AUTOPILOT_VERSION"
    assert version.flight_sw_version == version_number(__version__)
    assert version.capabilities & common.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    assert version.capabilities & common.MAV_PROTOCOL_CAPABILITY_COMMAND_INT


@pytest.mark.parametrize("command", [(REQUEST, PROTOCOL), (519, 1)])
def test_the_version_of_the_protocol_is_told_on_request(payload, command):
    results, (version,) = payload.ask(*command)
    assert results == [ACCEPTED]
    assert version.get_type() == "PROTOCOL_VERSION"
    assert version.version == 200
    assert version.min_version <= 200 <= version.max_version


def test_who_we_are_is_told_in_words_on_request(payload):
    results, (basic,) = payload.ask(REQUEST, 396)
    assert results == [ACCEPTED]
    assert basic.get_type() == "COMPONENT_INFORMATION_BASIC"
    assert (basic.vendor_name, basic.software_version) == ("RoSS", __version__)
    assert basic.capabilities & common.MAV_PROTOCOL_CAPABILITY_FTP


def test_an_interval_is_set_told_and_set_back(payload):
    assert payload.ask(SET, STATUS, 100_000)[0] == [ACCEPTED]
    assert payload.streams.period(URL, STATUS) == 0.1
    _, (told,) = payload.ask(GET, STATUS)
    assert (told.message_id, told.interval_us) == (STATUS, 100_000)
    assert payload.ask(SET, STATUS, 0)[0] == [ACCEPTED]
    assert payload.streams.period(URL, STATUS) == 0.25


def test_an_interval_is_told_as_a_message_on_request_too(payload):
    """MAVLink has REQUEST_MESSAGE in the place of GET_MESSAGE_INTERVAL by now."""
    results, (told,) = payload.ask(REQUEST, MESSAGE_INTERVAL, STATUS)
    assert (results, told.message_id, told.interval_us) == ([ACCEPTED], STATUS, 250_000)
    assert payload.ask(REQUEST, MESSAGE_INTERVAL, math.nan) == ([DENIED], [])


def test_a_stream_is_silenced_and_says_so(payload):
    assert payload.ask(SET, STATUS, -1)[0] == [ACCEPTED]
    _, (told,) = payload.ask(GET, STATUS)
    assert told.interval_us == -1


def test_the_interval_of_what_is_not_there_is_zero(payload):
    _, (told,) = payload.ask(GET, 30)
    assert (told.message_id, told.interval_us) == (30, 0)


@pytest.mark.parametrize(
    "numbers", [(STATUS, math.nan), (STATUS, 1), (STATUS, -2), (STATUS, 1e30), (30, 100_000), (HEARTBEAT, -1)]
)
def test_intervals_that_cannot_be_are_denied(payload, numbers):
    before = dict(payload.streams.asked)
    assert payload.ask(SET, *numbers)[0] == [DENIED]
    assert payload.streams.asked == before


def test_a_flood_of_requests_is_answered_by_a_trickle(payload):
    told = 0
    for _ in range(300):  # 15 s of simulated time at 20 requests a second
        told += len(payload.ask(REQUEST, VERSION)[1])
    assert 100 < told < 200


def test_the_dialect_knows_what_standard_clients_send():
    assert ross.MAVLink_command_cancel_message(1, 191, 54000).get_type() == "COMMAND_CANCEL"
