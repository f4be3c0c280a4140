"""A small program in C, built with the generated headers, and our codec understand each other."""

import math
import re
import shutil
import subprocess
import sys

import pytest

from alignments import ALIGNMENT
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import command_of
from ross_protocols.mavlink.values import Alignment, Health, Heartbeat, Status

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def headers(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("generated")
    subprocess.run([sys.executable, request.config.rootpath / "protocols" / "generate.py", folder], check=True)
    return folder / "mavlink-c"


@pytest.fixture(scope="module")
def compiled(headers, tmp_path_factory):
    """Compile C; the path of the program."""
    if shutil.which("gcc") is None:
        pytest.skip("needs the Debian package gcc")

    def build(source):
        program = tmp_path_factory.mktemp("program") / "program"
        warnings = ["-std=gnu99", "-Wall", "-Werror", "-Wno-address-of-packed-member"]
        subprocess.run(["gcc", *warnings, "-isystem", headers, source, "-o", program, "-lm"], check=True)
        return program

    return build


@pytest.fixture(scope="module")
def program(compiled, request):
    return compiled(request.config.rootpath / "tests" / "interop" / "read_ross.c")


def run(program, data):
    return subprocess.run([program], input=data, capture_output=True, check=True, timeout=60)


def test_c_reads_what_we_write(program):
    encoder = Encoder(7, 191)
    status = Status(time_usec=1, mission_time=2.0, earth=True, state=6, heading=-math.pi / 2, k=3)
    frames = [encoder.encode(value) for value in (Heartbeat(Health.ACTIVE, 6), status, ALIGNMENT)]
    told = run(program, b"".join(frames)).stderr.decode().splitlines()
    assert told == ["7-191 state 6 heading 1.5708 k 3", "candidate 1 rule 1 gain 3.5"]


def test_a_frame_of_an_older_dialect_reads_as_zero_in_what_was_added(program):
    """An extension that is not sent: the frame ends before it."""
    [frame] = [Encoder(7, 191).encode(ALIGNMENT)]
    without = Encoder(7, 191).encode(
        Alignment(**{n: getattr(ALIGNMENT, n) for n in ALIGNMENT.__slots__ if n != "gain"})
    )
    assert len(without) < len(frame)
    assert run(program, without).stderr.decode().splitlines() == ["candidate 1 rule 1 gain 0.0"]


def test_we_read_what_c_writes(program):
    [packet] = Decoder().feed(run(program, b"").stdout)
    command = command_of(packet.message)
    assert (packet.system_id, packet.component_id) == (255, 190)
    assert (command.number, command.numbers[0], command.target.component) == (54003, 30.0, 191)


def test_a_damaged_frame_is_dropped(program):
    frame = bytearray(Encoder(7, 191).encode(ALIGNMENT))
    frame[20] ^= 1
    assert run(program, bytes(frame)).stderr == b""


def test_the_program_of_the_guide_compiles_and_runs(compiled, request, tmp_path):
    page = (request.config.rootpath / "docs" / "how-to" / "wireshark.md").read_text(encoding="utf-8")
    [source] = re.findall(r"```c\n(.*?)```", page, re.DOTALL)
    path = tmp_path / "guide.c"
    path.write_text(source)
    status = Status(time_usec=1, mission_time=2.0, earth=True, state=6, heading=-math.pi / 2, k=3)
    assert run(compiled(path), Encoder(7, 191).encode(status)).stdout == b"90 deg, 3 sources\n"
