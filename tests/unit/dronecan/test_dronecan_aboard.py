"""The whole payload on a bus in this process: parameters, restart, clashes, bad input."""

import math
import sys

import pytest

from dronecan_bench import URL, Peer, payload, play
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.config.parameter_table import TABLE
from ross_payload.errors import ConfigError, LinkError, PluginError
from ross_payload.orders import Cancel, Home, Set, TurnTo
from ross_payload.service.dronecan_node import check_one_id
from ross_protocols.dronecan.messages import ArrayCommand, NodeStatus, Received
from ross_protocols.dronecan.node_messages import Decoder
from ross_protocols.dronecan.params import GetSetRequest, GetSetResponse, Opcode, OpcodeRequest, OpcodeResponse
from ross_protocols.dronecan.services import NodeInfo, NodeInfoRequest, RestartRequest, RestartResponse


def test_every_parameter_is_read_by_index_and_by_name(wire, peer, tmp_path):
    def script(bench):
        for index, (name, row) in enumerate(TABLE.items()):
            by_index = yield from peer.ask(GetSetRequest(index=index))
            assert by_index == (yield from peer.ask(GetSetRequest(name)))
            assert (by_index.name, by_index.value) == (name, bench.parameters.value(name))
            assert (row.upper == 1 and row.whole) or (by_index.minimum, by_index.maximum) == (row.lower, row.upper)
        assert (yield from peer.ask(GetSetRequest(index=len(TABLE)))) == GetSetResponse()
        assert (yield from peer.ask(GetSetRequest("NO_SUCH", value=1.0))) == GetSetResponse()

    play(script, wire.open, tmp_path)


def test_what_is_set_is_in_force_and_reaches_the_mission(wire, peer, tmp_path):
    def script(bench):
        answer = yield from peer.ask(GetSetRequest("EXP_UNIT", value=2.5))
        assert (answer.value, answer.default, bench.parameters.value("EXP_UNIT")) == (2.5, 3.0, 2.5)
        answer = yield from peer.ask(GetSetRequest("EXP_PIPELINED", value=True))
        assert answer.value is True
        answer = yield from peer.ask(GetSetRequest("EXP_MIN_ROT", value=3.0))  # a real number for an integer
        assert answer.value == 3
        yield from peer.wait(0.1)

    orders = play(script, wire.open, tmp_path).orders
    assert orders[:3] == [Set("EXP_UNIT", 2.5), Set("EXP_PIPELINED", 1.0), Set("EXP_MIN_ROT", 3.0)]
    assert "EXP_UNIT = { value = 2.5" in (tmp_path / "params.toml").read_text()


@pytest.mark.parametrize("value", [1000.0, -1, math.nan, math.inf, 2.5])
def test_a_value_that_is_not_allowed_changes_nothing(wire, peer, tmp_path, value):
    def script(bench):
        answer = yield from peer.ask(GetSetRequest("EXP_MAX_ROT", value=value))
        assert answer.value == 12

    play(script, wire.open, tmp_path)


def test_erase_sets_back_what_was_set_and_save_says_that_it_is_kept(wire, peer, tmp_path):
    def script(bench):
        for name, value in (("EXP_MIN_ROT", 1), ("EXP_MAX_ROT", 2), ("EXP_UNIT", 1.0)):
            assert (yield from peer.ask(GetSetRequest(name, value=value))).value == value
        assert (yield from peer.ask(OpcodeRequest(Opcode.SAVE))) == OpcodeResponse(True)
        assert (yield from peer.ask(OpcodeRequest(Opcode.ERASE))) == OpcodeResponse(True)
        for name in TABLE:
            assert bench.parameters.value(name) == bench.parameters.configured(name)
        assert (yield from peer.ask(OpcodeRequest(7))) == OpcodeResponse(False)

    play(script, wire.open, tmp_path)


def test_nothing_is_set_where_the_configuration_forbids_it(wire, peer, tmp_path):
    def script(bench):
        assert (yield from peer.ask(GetSetRequest("EXP_UNIT", value=2.5))).value == 3.0
        assert (yield from peer.ask(OpcodeRequest(Opcode.ERASE))) == OpcodeResponse(False)

    play(script, wire.open, tmp_path, dronecan={"port": URL, "may_set": False})


def test_a_restart_is_an_orderly_end_where_it_is_allowed(wire, peer, tmp_path):
    def script(bench):
        yield from peer.wait(0.2)
        assert (yield from peer.ask(RestartRequest(magic=1))) == RestartResponse(False)
        assert bench.restarts == []
        assert (yield from peer.ask(RestartRequest())) == RestartResponse(True)
        yield from peer.wait(10.0)
        raise AssertionError("the payload goes on")

    bench = play(script, wire.open, tmp_path, dronecan={"port": URL, "may_restart": True})
    assert bench.restarts == ["asked"]


def test_a_restart_is_refused_without_leave_and_while_a_task_runs(wire, peer, tmp_path):
    def refused(bench):
        yield from peer.wait(0.2)
        assert (yield from peer.ask(RestartRequest())) == RestartResponse(False)

    def turning(bench):
        bench.runner.order(TurnTo(math.pi / 2))
        yield from peer.wait(0.3)
        assert (yield from peer.ask(RestartRequest())) == RestartResponse(False)
        bench.runner.order(Cancel())
        yield from peer.wait(0.5)
        assert (yield from peer.ask(RestartRequest())) == RestartResponse(True)

    play(refused, wire.open, tmp_path)
    play(turning, wire.open, tmp_path, dronecan={"port": URL, "may_restart": True})


def test_it_tells_who_it_is_for_ever(wire, peer, tmp_path):
    told = []

    def script(bench):
        told.append((yield from peer.ask(NodeInfoRequest())))

    for _ in range(2):
        play(script, wire.open, tmp_path)
    assert told[0].name == "org.ross.payload"
    assert told[0].unique_id == told[1].unique_id
    assert isinstance(told[0], NodeInfo)


def test_two_payloads_of_one_id_name_the_other_and_are_silent(wire, peer, tmp_path, caplog):
    def script(bench):
        twin = Peer(wire, 121)
        twin.say(twin.voice.broadcast(NodeStatus(1)))
        yield from peer.wait(0.1)
        peer.all.clear()
        yield from peer.wait(3.0)
        assert peer.all == []

    play(script, wire.open, tmp_path)
    assert "another node on the bus has our node id 121: not transmitting until it leaves" in caplog.text


def test_an_operator_on_mavlink_hears_of_a_clash_once(wire, peer, tmp_path):
    def script(bench):
        twin = Peer(wire, 121)
        for _ in range(5):
            twin.say(twin.voice.broadcast(NodeStatus(1)))
            yield from peer.wait(1.0)

    texts = play(script, wire.open, tmp_path).texts
    assert [text for text in texts if "CAN: " in text] == [
        "RoSS: CAN: another node on the bus has our node id 121: not transmitting until it leaves"
    ]


def test_a_bus_that_goes_and_comes_back_does_not_end_the_mission(wire, peer, tmp_path, caplog):
    def script(bench):
        yield from peer.wait(0.5)
        wire.down = True
        yield from (None for _ in range(200))
        wire.down = False
        yield from peer.wait(20.0)

    caplog.set_level("INFO")
    play(script, wire.open, tmp_path)
    assert "DroneCAN: the bus is down" in caplog.text
    assert "DroneCAN: resolved: " in caplog.text


def test_driver_and_node_on_one_bus_are_one_node(tmp_path):
    servo = {"kind": "dronecan_servo", "options": {"port": URL}}
    heard = {}

    def script(bench):
        plug, ear = bench.far_end.crowd.bus.plug(), Decoder(0)
        bench.runner.order(TurnTo(0.5))
        for hop in range(300):
            for frame in plug.receive():
                said = ear.feed(frame)
                if isinstance(said, Received):
                    heard.setdefault((said.node, type(said.message)), []).append(hop)
            yield
        assert bench.heard.fault == ""
        assert bench.far_end.angle() == pytest.approx(0.5, abs=0.02)

    play(script, None, tmp_path, actuator=servo, dronecan={"port": URL, "node_id": 122})
    assert {node for node, _ in heard} == {50, 122}
    assert len(heard[122, NodeStatus]) in (2, 3)
    assert len(heard[122, ArrayCommand]) > 100


def test_a_canopen_drive_may_be_on_the_same_wires(tmp_path):
    heard = []

    def script(bench):
        plug, ear = bench.far_end.crowd.bus.plug(), Decoder(0)
        bench.runner.order(Home())
        yield from (None for _ in range(200))
        bench.runner.order(TurnTo(0.5))
        yield from (None for _ in range(300))
        heard.extend(said.message for frame in plug.receive() if isinstance(said := ear.feed(frame), Received))
        assert bench.heard.fault == ""
        assert bench.far_end.angle() == pytest.approx(0.5, abs=0.02)

    drive = {"kind": "canopen_drive", "options": {"port": URL}}
    play(script, None, tmp_path, actuator=drive, dronecan={"port": URL})
    assert sum(isinstance(message, NodeStatus) for message in heard) in (4, 5)


# ------------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"port": "tcp:x"}, "port"),
        ({"node_id": 126}, "node_id"),
        ({"node_id": 103}, "which autopilots take for cameras"),
        ({"node_id": 0, "allocator": True}, "expected an id of its own"),
        ({"status_hz": 0}, "status_hz"),
        ({"baud": 1}, "unknown key"),
    ],
)
def test_a_table_that_makes_no_sense_is_refused(table, words, tmp_path):
    from ross_payload.config import load

    lines = [
        f"{key} = {str(value).lower() if isinstance(value, bool) else repr(value)}" for key, value in table.items()
    ]
    (tmp_path / "x.toml").write_text("\n".join(["[dronecan]", *lines]))
    with pytest.raises(ConfigError, match=words):
        load(tmp_path / "x.toml")


def test_a_bus_that_cannot_be_joined_is_said_at_the_start(wire, tmp_path):
    wire.down = True
    with pytest.raises(LinkError, match="no bus"), payload({}, wire.open, tmp_path):
        pass


def test_one_payload_with_two_node_ids_on_one_bus_is_refused(tmp_path):
    from ross_payload.service.dronecan_node import node_on_bus

    options = {"port": URL, "own_node_id": 120}
    config = Config.model_validate(
        {"actuator": {"kind": "dronecan_servo", "options": options}, "dronecan": {"port": URL}}
    )
    with pytest.raises(
        ConfigError,
        match=r"own_node_id: expected 121, the node_id of \[dronecan\] on the same bus, or nothing, got 120",
    ):
        node_on_bus(config, None, None, None, None).__enter__()


def test_a_servo_with_the_id_of_the_payload_is_refused():
    servo = {"kind": "dronecan_servo", "options": {"port": URL, "node_id": 120}}
    config = Config.model_validate({"actuator": servo, "dronecan": {"port": URL, "node_id": 120}})
    with pytest.raises(ConfigError, match=r"node_id: expected the servo's own, got 120, which is that of \[dronecan\]"):
        check_one_id(config)
    check_one_id(config.model_copy(update={"dronecan": config.dronecan.model_copy(update={"node_id": 121})}))


@pytest.mark.parametrize("url", ["can:no_such_interface:x", "can:socketcan", "can:tcp:nowhere"])
def test_a_url_that_leads_to_no_bus_is_one_line(url, tmp_path):
    with (
        pytest.raises(ConfigError, match=url.rpartition(":")[2]),
        payload({"dronecan": {"port": url}}, joined, tmp_path),
    ):
        pass


def test_a_missing_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "can", None)
    monkeypatch.delitem(sys.modules, "ross_payload.actuators.wires.can", raising=False)
    with pytest.raises(PluginError, match=r"pip install 'python-can>="), payload({}, joined, tmp_path):
        pass


def joined(url):
    """Open a bus as the payload does."""
    return open_wire(url, SystemClock())
