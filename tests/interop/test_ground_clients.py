"""Clients on real sockets beside ``ross run`` in another process: pymavlink's FTP, and those of the ground side."""

import asyncio
import subprocess
import sys

import pytest
from pymavlink import mavftp

from ross_payload.config import Config
from ross_payload.ground.clients.orders import Orders, Rearm, Stop, Turn
from ross_payload.ground.clients.settings import Settings
from ross_payload.ground.picture.known import Who
from ross_payload.ground.station import Station
from ross_payload.parameters import TABLE, value_of
from ross_payload.telemetry.metadata import files

WHO = Who(1, 191)


@pytest.fixture(scope="module")
def payload(ross_run, free_port, ground_stations, tmp_path_factory):
    """A payload that speaks to mavutil and to us."""
    other, port = ground_stations(system_id=252), free_port()
    links = (f'url = "udpout:127.0.0.1:{other.port}"', f'url = "udpout:127.0.0.1:{port}"')
    with ross_run(tmp_path_factory.mktemp("clients"), *links) as payload:
        payload.other, payload.port = other, port
        yield payload


class Clients:
    """Our ground station, with everything that it asks for."""

    def __init__(self, station):
        self.station = station
        self.orders = Orders(station.send, station.system_id, station.component_id)
        self.settings = Settings(station.send, WHO, station.system_id, station.component_id)
        station.subscribe(self.hear)

    def hear(self, packet, at):
        for client in (self.orders, self.settings):
            client.heard(packet, at)

    async def until(self, found, seconds=60.0):
        """Let time pass until something is so."""
        for _ in range(round(seconds / 0.05)):
            for client in (self.orders, self.settings):
                client.tick(self.station.now())
            if found():
                return
            await asyncio.sleep(0.05)
        raise AssertionError(f"waited {seconds:g} s in vain")

    async def order(self, order):
        """Order something; return how it ended."""
        self.orders.order(WHO, order)
        await self.until(lambda: self.orders.doing[-1].state not in ("sent", "acknowledged", "in_progress"))
        return self.orders.doing[-1]


def with_clients(payload, work):
    """Run something asynchronous with clients that hear the payload."""

    async def run():
        async with Station([f"udpin:127.0.0.1:{payload.port}"]) as station:
            clients = Clients(station)
            await clients.until(lambda: WHO in station.fleet.payloads)
            return await work(clients)

    return asyncio.run(run())


def test_pymavlinks_ftp_reads_every_file_over_udp(payload, tmp_path):
    payload.other.wait("HEARTBEAT")
    client = mavftp.MAVFTP(payload.other.link, 1, 191)
    for name, content in files().items():
        assert client.cmd_get([name, str(tmp_path / name)]).error_code == 0
        client.process_ftp_reply("OpenFileRO", timeout=30)
        assert (tmp_path / name).read_bytes() == content


def test_our_clients_read_every_parameter_with_its_meaning(payload):
    async def work(clients):
        await clients.until(
            lambda: clients.settings.complete and all(r["description"] for r in clients.settings.rows())
        )
        return clients.settings

    settings = with_clients(payload, work)
    assert settings.values == pytest.approx({name: value_of(Config(), name) for name in TABLE})
    assert {row["name"]: row["max"] for row in settings.rows()} == {name: row.upper for name, row in TABLE.items()}
    assert settings.notes() == []


def test_what_our_clients_set_and_order_is_done_or_refused_in_the_payloads_words(payload):
    async def work(clients):
        await clients.until(lambda: clients.settings.complete)
        clients.settings.set("EXP_STEP", 999)
        turned = await clients.order(Turn(10))
        stopped = await clients.order(Stop())
        again = await clients.order(Turn(-10))
        await clients.until(lambda: clients.orders.doing[-1].reason == "stopped: re-arm first")
        armed = await clients.order(Rearm())
        return [each.state for each in (turned, stopped, again, armed)], clients.settings.rows()

    states, rows = with_clients(payload, work)
    assert states == ["done", "done", "refused", "done"]
    (step,) = [row for row in rows if row["name"] == "EXP_STEP"]
    assert (step["state"], "got 999" in step["reason"]) == ("refused", True)


def test_the_payload_tells_how_its_computer_is(payload):
    async def work(clients):
        await clients.until(lambda: clients.station.fleet.payloads[WHO].computer is not None)
        return clients.station.fleet.payloads[WHO].computer

    computer = with_clients(payload, work)
    assert 0 < computer.memory_used < computer.memory_total
    assert 0 < computer.disk_used <= computer.disk_total
    assert computer.uptime > 0


def test_the_script_of_the_guide_turns_the_array(payload, request):
    guide = (request.config.rootpath / "docs" / "how-to" / "script-the-ground.md").read_text(encoding="utf-8")
    script = guide.split("```python\n")[1].split("```")[0]
    command = [sys.executable, "-c", script, f"udpin:127.0.0.1:{payload.port}"]
    said = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    assert "1-191 listens for 3.0 s at one orientation" in said
    assert "turn to 10 deg done" in said
    assert "heading 10" in said
