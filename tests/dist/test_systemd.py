"""systemd understands the unit, and the unit fits the program."""

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from ross_payload import clock
from ross_payload.actuators.wires import gpio
from ross_payload.plugins import available
from ross_payload.service.live import AGAIN

UNIT = Path(__file__).parents[2] / "docs" / "examples" / "ross.service"


def analyse(*arguments):
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd-analyze is missing: apt-get install systemd")
    return subprocess.run(["systemd-analyze", *arguments], capture_output=True, text=True, check=False)


@pytest.fixture
def unit(tmp_path):
    """The unit with a program that exists here in place of /opt/ross/bin/ross."""
    path = tmp_path / "ross.service"
    there = shutil.which("true")
    path.write_text(re.sub(r"(?m)^(ExecStart(?:Pre)?)=\S+", rf"\1={there}", UNIT.read_text()))
    return path


@pytest.fixture
def service():
    parser = configparser.ConfigParser(strict=False, interpolation=None)
    parser.optionxform = str
    parser.read(UNIT)
    return parser["Service"]


def test_systemd_finds_no_fault_in_the_unit(unit):
    verified = analyse("verify", "--man=no", unit)
    assert verified.returncode == 0, verified.stderr
    assert not verified.stderr


def test_systemd_would_find_a_fault(unit):
    unit.write_text(unit.read_text().replace("WatchdogSec=", "WatchDogSec="))
    assert "WatchDogSec" in analyse("verify", "--man=no", unit).stderr


def test_the_unit_is_hardened(unit):
    judged = analyse("security", "--offline=true", "--threshold=30", unit)
    assert judged.returncode == 0, judged.stdout.splitlines()[-1]


def test_a_wrong_configuration_does_not_restart_and_a_crash_does(service):
    assert service["Restart"] == "on-failure"
    assert service["RestartPreventExitStatus"] == "2"
    assert service["SuccessExitStatus"].split() == ["130", str(AGAIN)]


def test_a_wrong_configuration_that_is_found_while_waiting_does_not_restart_either(service):
    """RestartPreventExitStatus does not apply to ExecStartPre (systemd.service(5)): its failure must not count."""
    assert service["ExecStartPre"].startswith("-")


def test_a_restart_that_was_asked_for_is_no_failure_and_happens(service):
    assert service["RestartForceExitStatus"] == str(AGAIN)


def test_the_program_of_the_unit_is_a_command(service):
    program, command, _ = service["ExecStart"].split()
    assert Path(program).name == "ross"
    assert command in available("ross_payload.commands")


def test_the_watchdog_asks_through_notify(service):
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) >= 10


def test_the_pump_and_the_edges_may_have_real_time_priority(service):
    """Without it moves by pulses are lost on a busy computer."""
    assert int(service["LimitRTPRIO"]) >= max(clock.URGENCY, gpio.URGENCY)


def test_the_payload_may_ask_whether_the_network_keeps_the_time(service):
    """@system-service lacks what `clock.synchronised_time` calls: as a service it trusted no NTP."""
    assert {"adjtimex", "clock_adjtime", "clock_adjtime64"} <= set(service["SystemCallFilter"].split())
    assert service["CapabilityBoundingSet"] == ""


@pytest.mark.parametrize("setting", ["PrivateDevices", "PrivateNetwork", "MemoryDenyWriteExecute", "RestrictRealtime"])
def test_what_would_cut_off_sound_wires_or_links_is_not_set(service, setting):
    assert setting not in service
