"""MAVSDK, a client that we did not write, beside a payload in another process and no autopilot."""

import json
import math
import subprocess
import sys
from types import SimpleNamespace

import pytest

from ross_payload.config import Config
from ross_payload.config.parameter_table import TABLE, value_of
from waiting import wait_for

mavsdk = pytest.importorskip("mavsdk", minversion="4", reason="needs the Python package mavsdk, 4 or later")
direct = pytest.importorskip("mavsdk.plugins.mavlink_direct.mavlink_direct")
param = pytest.importorskip("mavsdk.plugins.param.param")
telemetry = pytest.importorskip("mavsdk.plugins.telemetry.telemetry")
metadata = pytest.importorskip("mavsdk.plugins.component_metadata.component_metadata")

EXPLORE, STOP, REARM, NOTHING = 54000, 54004, 54009, 99
ACCEPTED, TEMPORARILY_REJECTED, UNSUPPORTED, IN_PROGRESS, CANCELLED = 0, 1, 3, 5, 6


class Client:
    """A MAVSDK ground station that has found a system."""

    def __init__(self, sdk):
        self.systems = sdk.get_systems
        (self.system,) = wait_for(lambda: [system for system in sdk.get_systems() if system.component_ids()])
        self.direct = direct.MavlinkDirect(self.system)
        self.param = param.Param(self.system)
        self.telemetry = telemetry.Telemetry(self.system)
        self.texts, self.heard = [], []
        self.telemetry.subscribe_status_text(lambda said, user: self.texts.append(said.text))
        self.direct.subscribe_message("", lambda message, user: self.heard.append(message))
        try:
            self.param.select_component(191, param.ProtocolVersion.V1)
        except param.ParamError as error:  # it stores the component, and fails all the same
            assert error.result == param.ParamResult.UNKNOWN

    def of(self, name):
        """The fields of a message, each time that it was heard."""
        return [SimpleNamespace(**json.loads(one.fields_json)) for one in self.heard if one.message_name == name]

    def order(self, number, *values):
        return json.loads(self.direct.send_command(command(number, *values)).fields_json)["result"]


def command(number, *values):
    numbers = [*values, *[0] * (7 - len(values))]
    fields = {"target_system": 1, "target_component": 191, "command": number, "confirmation": 0}
    fields |= {f"param{index}": value for index, value in enumerate(numbers, 1)}
    return direct.MavlinkMessage("COMMAND_LONG", 0, 0, 1, 191, json.dumps(fields))


@pytest.fixture(scope="module")
def payload(ross_run, free_port, tmp_path_factory):
    port = free_port()
    with ross_run(tmp_path_factory.mktemp("mavsdk"), f'url = "udpout:127.0.0.1:{port}"') as payload:
        payload.port = port
        yield payload


@pytest.fixture(scope="module")
def client(payload, request, tmp_path_factory):
    patch = pytest.MonkeyPatch()
    patch.setenv("HOME", str(tmp_path_factory.mktemp("home")))  # it caches metadata there
    kind = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    with mavsdk.Mavsdk(kind) as sdk:
        assert sdk.add_any_connection(f"udpin://127.0.0.1:{payload.port}") == mavsdk.ConnectionResult.SUCCESS
        client = Client(sdk)
        for name in ("standard", "ross"):  # standard.xml may be loaded too, but MAVSDK knows what is in it
            xml = request.config.rootpath / "protocols" / "mavlink" / f"{name}.xml"
            client.direct.load_custom_xml(xml.read_text(encoding="utf-8"))
        yield client
    patch.undo()


def test_it_finds_the_component_without_an_autopilot(client):
    assert (client.system.get_system_id(), client.system.component_ids()) == (1, [191])
    wait_for(client.system.is_connected)


def test_it_reads_all_parameters(client):
    told = client.param.get_all_params()
    defaults = {name: value_of(Config(), name) for name in TABLE}
    assert {one.name: one.value for one in told.float_params} == pytest.approx(defaults)
    assert not told.int_params


def test_it_reads_one_parameter(client):
    assert client.param.get_param_float("EXP_STEP") == 15.0


def test_what_it_writes_is_in_force_and_kept(client, payload):
    client.param.set_param_float("EXP_UNIT", 2.5)
    assert client.param.get_param_float("EXP_UNIT") == 2.5
    wait_for(lambda: [one for one in client.of("ROSS_INFORMATION") if one.orientation_time == 2.5])
    wait_for(lambda: payload.kept() == {"EXP_UNIT": 2.5})
    client.param.set_param_float("EXP_UNIT", 3.0)


def test_what_cannot_be_written_is_not_and_the_operator_reads_why(client, payload):
    with pytest.raises(param.ParamError) as refused:
        client.param.set_param_float("EXP_STEP", 999.0)
    assert refused.value.result == param.ParamResult.VALUE_OUT_OF_RANGE
    assert client.param.get_param_float("EXP_STEP") == 15.0
    wait_for(lambda: [text for text in client.texts if "EXP_STEP: expected a number" in text])
    assert "EXP_STEP" not in payload.kept()


def test_what_there_is_not_need_not_be_asked_for_again(client):
    with pytest.raises(param.ParamError) as refused:
        client.param.get_param_float("NOBODY")
    assert refused.value.result == param.ParamResult.DOES_NOT_EXIST


def test_it_fetches_what_the_parameters_mean(client):
    files, told = metadata.ComponentMetadata(client.system), {}
    files.subscribe_metadata_available(lambda update, user: told.setdefault(update.type, update.json_metadata))
    files.request_component(191)
    known = json.loads(wait_for(lambda: told.get(metadata.MetadataType.PARAMETER)))["parameters"]
    assert {one["name"] for one in known} == set(TABLE)
    (unit,) = [one for one in known if one["name"] == "EXP_UNIT"]
    assert (unit["min"], unit["max"], unit["units"]) == (0.5, 60, "s")


def test_it_reads_our_status_from_our_xml(client):
    status = wait_for(lambda: client.of("ROSS_STATUS"))[-1]
    assert (status.message_id, status.frame, status.rotation_max) == (54001, 2, 12)
    assert status.heading == pytest.approx(0.0, abs=1e-6)
    assert status.mount_yaw is None or math.isnan(status.mount_yaw)
    assert status.actuator_flags & 0b1011 == 0b0011  # present, settled, no fault
    assert {one.component_id for one in client.heard} == {191}


def test_it_reads_texts_and_arrays_of_our_messages(client):
    information = wait_for(lambda: client.of("ROSS_INFORMATION"))[-1]
    assert information.actuator == "tb6600"
    assert information.spacing == pytest.approx(0.05)
    assert wait_for(lambda: client.of("ROSS_AUDIO"))[-1].level == pytest.approx([-40.0, -40.0], abs=0.5)


def test_a_stop_cancels_the_task_and_the_state_says_why_nothing_moves(client):
    ends = []
    client.direct.send_command_async(
        command(EXPLORE), lambda result, ack, user: ends.append(json.loads(ack.fields_json))
    )
    wait_for(lambda: [ack for ack in client.of("COMMAND_ACK") if (ack.command, ack.result) == (EXPLORE, IN_PROGRESS)])
    assert not ends
    assert client.order(STOP) == ACCEPTED
    wait_for(lambda: ends)
    assert ends[0]["result"] == CANCELLED
    assert client.order(EXPLORE) == TEMPORARILY_REJECTED
    wait_for(lambda: [text for text in client.texts if text == "RoSS: explore refused: stopped: re-arm first"])
    wait_for(lambda: client.of("ROSS_STATUS")[-1].state == 8)
    assert client.order(REARM) == ACCEPTED
    wait_for(lambda: client.of("ROSS_STATUS")[-1].state == 0)


def test_a_command_that_nobody_knows_is_unsupported(client):
    assert client.order(NOTHING) == UNSUPPORTED


@pytest.mark.soak
def test_the_program_of_the_guide_sets_turns_and_reads(ross_run, free_port, guide, request, tmp_path):
    url = f"127.0.0.1:{free_port()}"
    xml = request.config.rootpath / "protocols" / "mavlink" / "ross.xml"
    with ross_run(tmp_path, f'url = "udpout:{url}"'):
        command = [sys.executable, "-c", guide("MavlinkDirect"), f"udpin://{url}", xml]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=100)
    assert done.stdout.splitlines()[-3:] == ["EXP_UNIT 2.5", "result 0", "heading 0.52"]
