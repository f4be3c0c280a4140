"""How the payload's computer is: read from files, told every five seconds, on request, and never in lock-step."""

import os
import threading
import time

import pytest

import waiting
from nobody import nobody
from ross_payload.config import Link
from ross_payload.telemetry.computer import ComputerReader
from ross_protocols.mavlink.computer import Computer, computer_of
from ross_protocols.mavlink.dialect import common, ross

NUMBER = common.MAVLINK_MSG_ID_ONBOARD_COMPUTER_STATUS
GROUND = Link(url="udpout:127.0.0.1:14550")
RADIO = Link(url="udpout:127.0.0.1:14551", max_bytes_s=960)
NARROW = Link(url="udpout:127.0.0.1:14552", max_bytes_s=350)
HALF_OF_9600_BAUD = Link(url="udpout:127.0.0.1:14552", max_bytes_s=480)
NAME = "ONBOARD_COMPUTER_STATUS"
REQUEST, SET_INTERVAL = ross.MAV_CMD_REQUEST_MESSAGE, ross.MAV_CMD_SET_MESSAGE_INTERVAL
STAT = "cpu  0 0 0 0 0 0 0\ncpu0 {busy} 0 0 {idle} 0 0 0\ncpu1 0 0 0 {idle} {busy} 0 0\nintr 5 6\n"


class Machine:
    """Files as Linux has them."""

    def __init__(self, folder):
        self.proc, self.thermal = folder / "proc", folder / "thermal"
        self.proc.mkdir()
        (self.proc / "uptime").write_text("350.52 1234.5\n")
        (self.proc / "meminfo").write_text("MemTotal:  4000 kB\nMemFree: 10 kB\nMemAvailable: 1000 kB\nHugePages: 0\n")
        self.count(busy=100, idle=100)
        for number, temp in enumerate(("41000", "67500", "-273000", "")):
            zone = self.thermal / f"thermal_zone{number}"
            zone.mkdir(parents=True)
            (zone / "temp").write_text(temp + "\n")
        self.read = ComputerReader(folder / "not" / "yet" / "made", self.proc, self.thermal)

    def count(self, busy, idle):
        (self.proc / "stat").write_text(STAT.format(busy=busy, idle=idle))


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path)


def test_a_core_that_worked_three_quarters_of_the_time_says_so_and_one_that_waited_for_disks_is_idle(machine):
    assert machine.read().loads == (), "the first look has nothing to compare with"
    machine.count(busy=175, idle=125)
    assert machine.read().loads == (0.75, 0.0)


def test_memory_heat_uptime_and_disk_are_read(machine):
    found = waiting.wait_for(lambda: each if (each := machine.read()).disk_total else None)
    assert (found.memory_used, found.memory_total) == (3000 * 1024, 4000 * 1024)
    assert found.temperature == 67.5, "the hottest zone that means anything"
    assert found.uptime == 350.52
    assert 0 < found.disk_used < found.disk_total, "of the nearest folder that is there"


def test_a_slow_disk_is_told_by_every_look_after_the_first(machine, monkeypatch):
    statvfs = os.statvfs

    def slow(folder):
        time.sleep(0.1)
        return statvfs(folder)

    monkeypatch.setattr(os, "statvfs", slow)
    told = []
    for _ in range(4):
        told.append(machine.read().disk_total is not None)
        time.sleep(0.5)
    assert told == [False, True, True, True]


def test_a_system_without_a_thread_left_leaves_the_disk_untold_and_the_pump_alive(machine, monkeypatch):
    """As in a container with a limit of processes: what the pump calls must not raise."""

    def refused(thread):
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refused)
        found = [machine.read() for _ in range(3)]
    assert {(each.disk_total, each.memory_total) for each in found} == {(None, 4000 * 1024)}
    waiting.wait_for(lambda: machine.read().disk_total)


def test_nobody_waits_for_a_disk_that_does_not_answer(machine, monkeypatch):
    """As a network share that is gone: the pump asks, which no stop could pass meanwhile."""
    answers, asked, statvfs = threading.Event(), [], os.statvfs

    def hung(folder):
        asked.append(folder)
        assert answers.wait(60)
        return statvfs(folder)

    monkeypatch.setattr(os, "statvfs", hung)
    found = [machine.read() for _ in range(100)]
    answers.set()
    assert {(each.disk_used, each.disk_total, each.memory_total) for each in found} == {(None, None, 4000 * 1024)}
    assert len(asked) == 1, "one thread waits"
    waiting.wait_for(lambda: machine.read().disk_total)


def test_what_cannot_be_read_is_not_known(tmp_path):
    found = ComputerReader(tmp_path, tmp_path / "proc", tmp_path / "thermal")()
    assert found == Computer(uptime=0.0, disk_used=found.disk_used, disk_total=found.disk_total)


def test_this_computer_can_be_read(tmp_path):
    found = ComputerReader(tmp_path)()
    assert found.memory_total > 2**20
    assert found.uptime > 0


def test_the_disk_is_read_beside_a_folder_that_may_not_be_entered(closed):
    with nobody():
        read = ComputerReader(closed / "inner")
        assert waiting.wait_for(lambda: read().disk_total)


# ------------------------------------------------------------------------------------------- told


def busy():
    return Computer(12.0, (0.5, 1.0), 61.0, 1 * 2.0**30, 4 * 2.0**30, 2 * 2.0**30, 8 * 2.0**30)


def told(sky):
    return [computer_of(message) for message in sky.ports[0].messages(NAME)]


def ask(sky, command, *numbers):
    padded = [*numbers, *[0] * (7 - len(numbers))]
    sky.ports[0].call(common.MAVLink_command_long_message(1, 191, command, 0, *padded))


def test_it_is_told_every_five_seconds_as_it_is(aloft):
    with aloft(GROUND, computer=busy) as sky:
        sky.live(21.0)
    assert len(told(sky)) == 5
    assert set(told(sky)) == {busy()}


def test_where_nobody_reads_it_nothing_is_told(aloft):
    with aloft(GROUND) as sky:
        sky.live(12.0)
    assert told(sky) == []


def test_it_comes_on_request_and_as_often_as_is_asked(aloft):
    with aloft(GROUND, computer=busy, give=lambda order: None) as sky:
        sky.live(1.0)
        ask(sky, REQUEST, NUMBER)
        sky.live(0.5)
        assert len(told(sky)) == 2
        ask(sky, SET_INTERVAL, NUMBER, 1e6)
        sky.live(10.0)
        assert 11 <= len(told(sky)) <= 14
        ask(sky, SET_INTERVAL, NUMBER, -1)
        sky.live(0.5)
        before = len(told(sky))
        sky.live(10.0)
        assert len(told(sky)) == before
    assert [message.result for message in sky.ports[0].messages("COMMAND_ACK")] == [0, 0, 0]


def test_on_a_slow_line_it_waits_behind_what_matters(aloft):
    """At 960 bytes/s statuses come at least once a second all the same."""
    with aloft(RADIO, computer=busy) as sky:
        sky.live(30.0)
    assert len(sky.ports[0].messages("ROSS_STATUS")) >= 28
    assert 2 <= len(told(sky)) <= 7


def test_where_it_never_finds_room_it_takes_none_from_others_and_is_not_promised(aloft):
    """At 480 bytes/s there is room for the usual rate of the status."""
    with aloft(HALF_OF_9600_BAUD, computer=busy, give=lambda order: None) as sky:
        sky.live(20.0)
        ask(sky, REQUEST, NUMBER)
        sky.live(1.0)
    assert told(sky) == []
    assert len(sky.ports[0].messages("ROSS_STATUS")) >= 60
    assert [message.result for message in sky.ports[0].messages("COMMAND_ACK")] == [1]


@pytest.mark.soak
def test_on_a_line_without_room_for_it_everything_else_still_comes(aloft):
    with aloft(NARROW, computer=busy) as sky:
        sky.live(30.0)
    assert told(sky) == []
    assert len(sky.ports[0].messages("ROSS_STATUS")) >= 25
    assert len(sky.ports[0].messages("ROSS_INFORMATION")) >= 4
