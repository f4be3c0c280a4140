"""`ross doctor` as a command, and the computer it runs on."""

import json

import pytest

from command_line import called
from doctor_bench import FAST, config, machine
from ross_payload.clock import SystemClock
from ross_payload.doctor import computer_checks
from ross_payload.doctor.examination import examine
from ross_payload.doctor.findings import ok
from ross_payload.doctor.machine import Machine, output_of

# -------------------------------------------------------------------------------------------- machine


def test_a_program_that_is_not_there_or_fails_says_nothing():
    assert output_of(("no-such-program-here",)) is None
    assert output_of(("false",)) is None
    assert output_of(("echo", "yes")) == "yes"


def test_this_computer_is_seen_as_it_is():
    here = Machine()
    assert here.text("/proc/self/comm")
    assert here.text("/no/such/file") == ""
    assert here.bits in (32, 64)
    assert here.names("/dev", "nul[l]", "null") == ["/dev/null"]


# -------------------------------------------------------------------------------------------- the command


@pytest.fixture
def doctor(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path / "state"))
    path = tmp_path / "ross.toml"

    def call(text, *options):
        path.write_text(QUICK + text)
        return called(monkeypatch, capsys, "doctor", path, *options)

    return call


QUICK = """
[audio]
source = "tcp:127.0.0.1:9"
[explore]
unit_s = 0.5
min_rotations = 1
[exploit]
separator = "duet"
run_s = 1
"""


def test_every_check_is_one_line_and_one_for_what_to_do(doctor):
    code, out, _ = doctor("[actuator]\nkind = 'ideal'\n")
    assert code == 2  # nobody sends audio there
    assert "fail  microphones  tcp:127.0.0.1:9" in out
    lines = [line for line in out.splitlines() if not line.lstrip().startswith("->")]
    assert all(line.split()[0] in ("ok", "warn", "fail") for line in lines)
    assert "-> choose another actuator.kind" in out


def test_what_must_be_mended_is_exit_code_2(doctor):
    code, out, _ = doctor("[actuator]\nkind = 'hamster'\n", "--json")
    report = json.loads(out)
    assert code == 2
    assert report["verdict"] == "fail"
    assert any("hamster" in check["found"] and check["verdict"] == "fail" for check in report["checks"])


def test_a_configuration_that_is_wrong_gets_one_line(doctor):
    code, out, err = doctor("[guard]\nlower_deg = 'left'\n")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1


def test_a_check_that_breaks_hurts_no_other(tmp_path):
    def surprised(config, machine):
        yield ok("surprised", "so far")
        raise KeyError("this")

    found = list(examine(config(**FAST), machine(tmp_path), SystemClock(), (surprised, computer_checks.python)))
    assert [each.check for each in found[:3]] == ["surprised", "surprised", "python"]
    assert "KeyError('this')" in found[1].found
