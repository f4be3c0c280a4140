"""Programs that we did not write drive the simulated grbl on a pseudo terminal; a program of ours dies in mid-move.

The simplest way to stream that grbl documents, send a line and wait for its answer, is written down here with pyserial
alone. The package grbl-streamer (GPL), which counts the characters in grbl's buffer, runs in a process of its own.
"""

import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

from device_bench import device, ross
from waiting import wait_for

serial = pytest.importorskip("serial", reason="needs pyserial: pip install pyserial")

MPOS = re.compile(rb"<(\w+)[^|]*\|MPos:(-?[\d.]+),")
SQUARE = ("G21", "G90", "G1 X30 F9000", "X30 Y10", "X0 Y10", "X0 Y0", "G0 X-15")
STEP = 0.1125  # [deg]
PATIENCE = 60.0  # a pseudo terminal may be late, see device_bench [s]
TURN = """
import sys
from ross_payload.actuators.grbl.driver import backend
from ross_payload.actuators.grbl.options import Options
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.interfaces import Services

clock, told = SystemClock(), False
with backend.open(Options(port=sys.argv[1]), Services(clock, lambda url: open_wire(url, clock))) as driver:
    while True:
        driver.poll(clock.now())
        if driver.state().homed and not told:
            driver.command(1.0, 0.5)
            told = True
        if driver.state().fault:
            sys.exit(driver.state().fault)
        if driver.state().angle > 0.2:
            print("turning", flush=True)
        clock.sleep(0.005)
"""


@pytest.fixture
def path(tmp_path):
    with ross(tmp_path, "device", "grbl", "--json") as process:
        yield process.told["wire"].removeprefix("serial:").removesuffix(":115200")


@pytest.fixture
def port(path):
    with serial.Serial(path, 115200, timeout=PATIENCE) as port:
        tell(port, "$I")  # its banner has gone by then
        yield port


def answer(port):
    """Read lines up to the answer; a banner may stand before it."""
    lines = []
    while True:
        line = port.readline()
        assert line.endswith(b"\n"), lines
        if line.startswith(b"Grbl") or not line.strip():
            continue
        lines.append(line.strip())
        if lines[-1] == b"ok" or lines[-1].startswith(b"error:"):
            return lines


def tell(port, line):
    port.write(line.encode() + b"\n")
    return answer(port)


def where(port):
    """Ask until there is a report: state and machine position of X [deg]."""
    port.write(b"?")
    while True:
        found = MPOS.match(port.readline())
        if found:
            return found[1].decode(), float(found[2])


def until_idle(port):
    def idle():
        state, place = where(port)
        return (place,) if state == "Idle" else None

    return wait_for(idle)[0]


@pytest.mark.soak
def test_send_and_wait_as_grbl_s_simple_streaming_does(port):
    port.write(b"\x18")
    assert port.readline() == b"\r\n"
    assert port.readline() == b"Grbl 1.1h ['$' for help]\r\n"
    for line in SQUARE:
        assert tell(port, line) == [b"ok"], line
    assert until_idle(port) == pytest.approx(-15.0, abs=STEP)


def test_a_jog_is_cancelled_and_ends_where_it_came_to_rest(port):
    assert tell(port, "$J=G91X180F450") == [b"ok"]  # 24 s, however late this process is
    wait_for(lambda: where(port)[1] > 10.0)
    port.write(b"\x85")
    assert 10.0 < until_idle(port) < 170.0


def test_the_settings_are_listed_as_documented(port):
    *lines, last = tell(port, "$$")
    assert last == b"ok"
    assert all(re.fullmatch(rb"\$\d+=\d+(\.\d{3})?", line) for line in lines)
    assert {b"$1=255", b"$100=8.889", b"$110=13500.000", b"$120=112.500"} <= set(lines)


@pytest.mark.soak
def test_the_package_grbl_streamer_streams_a_job(path, port):
    port.close()
    job = "\n".join([*SQUARE, *(f"G1 X{n % 7} F9000" for n in range(10)), "G0 X-15"])
    program = [sys.executable, Path(__file__).with_name("streamer_process.py"), path, "-15"]
    streamed = subprocess.run(program, input=job, capture_output=True, text=True, timeout=120, check=False)
    assert streamed.returncode == 0, streamed.stderr


def test_when_our_process_is_killed_grbl_finishes_its_jog(tmp_path):
    with device(tmp_path, "grbl") as process:
        with subprocess.Popen([sys.executable, "-c", TURN, process.told["wire"]], stdout=subprocess.PIPE) as ours:
            try:
                assert ours.stdout.readline() == b"turning\n"
            finally:
                ours.kill()
        wait_for(lambda: process.ask("status")["angle_deg"] == pytest.approx(math.degrees(1.0), abs=STEP))
