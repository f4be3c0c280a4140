"""Clients on real sockets beside ``ross run`` in another process: pymavlink's FTP, and those of the ground side."""

import subprocess
import sys

import pytest
from pymavlink import mavftp

from ross_payload.config import Config
from ross_payload.config.parameter_table import TABLE, value_of
from ross_payload.ground import RefusedByPayload, connect
from ross_payload.mavlink.component_info import files


@pytest.fixture(scope="module")
def payload(ross_run, free_port, ground_stations, tmp_path_factory):
    """A payload that speaks to mavutil and to us."""
    other, port = ground_stations(system_id=252), free_port()
    links = (f'url = "udpout:127.0.0.1:{other.port}"', f'url = "udpout:127.0.0.1:{port}"')
    with ross_run(tmp_path_factory.mktemp("clients"), *links) as payload:
        payload.other, payload.port = other, port
        yield payload


async def with_client(payload, work):
    """Run something asynchronous with a client of the payload."""
    async with connect(f"udpin:127.0.0.1:{payload.port}", payload="1-191") as client:
        return await work(client)


def test_pymavlinks_ftp_reads_every_file_over_udp(payload, tmp_path):
    payload.other.wait("HEARTBEAT")
    client = mavftp.MAVFTP(payload.other.link, 1, 191)
    for name, content in files().items():
        assert client.cmd_get([name, str(tmp_path / name)]).error_code == 0
        client.process_ftp_reply("OpenFileRO", timeout=30)
        assert (tmp_path / name).read_bytes() == content


async def test_our_client_reads_every_parameter_with_its_meaning(payload):
    parameters = await with_client(payload, lambda client: client.parameters.list())
    assert {each.name: each.value for each in parameters} == pytest.approx(
        {name: value_of(Config(), name) for name in TABLE}
    )
    assert {each.name: each.max for each in parameters} == {name: row.upper for name, row in TABLE.items()}
    assert all(each.description for each in parameters)


async def test_what_our_client_sets_and_asks_for_is_done_or_refused_in_the_payloads_words(payload):
    async def work(client):
        with pytest.raises(RefusedByPayload, match="got 999") as refusal:
            await client.parameters.set("EXP_STEP", 999)
        assert refusal.value.request == "EXP_STEP = 999"
        await client.turn(10)
        await client.stop()
        with pytest.raises(RefusedByPayload) as refusal:
            await client.turn(-10)
        assert refusal.value.reason == "stopped: re-arm first"
        await client.rearm()

    await with_client(payload, work)


async def test_the_payload_tells_how_its_computer_is(payload):
    computer = await with_client(payload, lambda client: client.until(lambda: client.state.computer))
    assert 0 < computer.memory_used < computer.memory_total
    assert 0 < computer.disk_used <= computer.disk_total
    assert computer.uptime > 0


def test_the_script_of_the_guide_turns_the_array(payload, request):
    guide = (request.config.rootpath / "docs" / "how-to" / "script-the-ground.md").read_text(encoding="utf-8")
    script = guide.split("```python\n")[1].split("```")[0]
    command = [sys.executable, "-c", script, f"udpin:127.0.0.1:{payload.port}"]
    said = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    assert "1-191 listens for 3.0 s at one orientation" in said
    assert "heading 10" in said
