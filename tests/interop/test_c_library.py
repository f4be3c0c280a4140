"""The C library that mavgen makes of our dialect, as a ground station would use it, reads and writes our frames."""

import contextlib
import io
import shutil
import subprocess
from argparse import Namespace
from pathlib import Path

import pytest
from pymavlink.generator import mavgen

from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.values import Alignment, CandidateState, Rule, Separation, Source, Status
from ross_protocols.mavlink.values import Phase as SeparationPhase

pytestmark = pytest.mark.process

XML = Path(__file__).resolve().parents[2] / "protocols" / "mavlink" / "ross.xml"

READER = r"""
#include <stdio.h>
#include "ross/mavlink.h"
int main(void) {
    mavlink_message_t message;
    mavlink_status_t status;
    for (int byte; (byte = getchar()) != EOF;) {
        if (!mavlink_parse_char(MAVLINK_COMM_0, (uint8_t)byte, &message, &status)) continue;
        if (message.msgid == MAVLINK_MSG_ID_ROSS_STATUS) {
            mavlink_ross_status_t s;
            mavlink_msg_ross_status_decode(&message, &s);
            printf("status %d/%d %d %.4f %.4f %d %d %d\n", message.sysid, message.compid, s.state, s.heading, s.joint,
                   s.k, s.target, s.actuator_flags);
        }
        if (message.msgid == MAVLINK_MSG_ID_ROSS_SOURCE) {
            mavlink_ross_source_t s;
            mavlink_msg_ross_source_decode(&message, &s);
            printf("source %d/%d %.4f %.4f %d %d\n", s.source, s.count, s.azimuth, s.azimuth_sigma, s.frame, s.flags);
        }
        if (message.msgid == MAVLINK_MSG_ID_ROSS_ALIGNMENT) {
            mavlink_ross_alignment_t a;
            mavlink_msg_ross_alignment_decode(&message, &a);
            printf("alignment %d %.1f %u %d %d\n", a.candidate, a.isolation, a.aliased, a.rule, a.state);
        }
        if (message.msgid == MAVLINK_MSG_ID_ROSS_SEPARATION) {
            mavlink_ross_separation_t s;
            mavlink_msg_ross_separation_decode(&message, &s);
            printf("separation %d %u %.16s %d\n", s.group, s.members, s.method, s.phase);
        }
    }
    return 0;
}
"""

WRITER = r"""
#include <stdio.h>
#include "ross/mavlink.h"
int main(void) {
    mavlink_message_t message;
    uint8_t buffer[MAVLINK_MAX_PACKET_LEN];
    mavlink_msg_ross_source_pack(7, 42, &message, 123456, -0.5f, 1.25f, 0.125f, 0.25f, 0.75f, 0.5f, 2.0f, 9, 1, 3,
                                 ROSS_FRAME_EARTH, ROSS_SOURCE_FLAGS_TARGET | ROSS_SOURCE_FLAGS_TRACKED, -0.25f, 1.5f);
    fwrite(buffer, 1, mavlink_msg_to_send_buffer(buffer, &message), stdout);
    return 0;
}
"""


def generated(folder: Path, xml: Path) -> Path:
    options = Namespace(output=str(folder), language="C", wire_protocol="2.0", validate=False, strict_units=False)
    with contextlib.redirect_stdout(io.StringIO()):
        assert mavgen.mavgen(options, [str(xml)])
    return folder


@pytest.fixture(scope="module")
def headers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return generated(tmp_path_factory.mktemp("c"), XML)


@pytest.fixture(scope="module")
def older_headers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library of a ground station that was built before ROSS_SOURCE had extensions."""
    text = XML.read_text(encoding="utf-8")
    begin = text.index('<message id="54002"')
    cut, end = text.index("<extensions/>", begin), text.index("</message>", begin)
    folder = tmp_path_factory.mktemp("older")
    (folder / "ross.xml").write_text(text[:cut] + text[end:], encoding="utf-8")
    return generated(folder, folder / "ross.xml")


def run(headers: Path, program: str, given: bytes = b"") -> bytes:
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("needs a C compiler (cc, gcc or clang)")
    source, binary = headers / "program.c", headers / "program"
    source.write_text(program)
    subprocess.run([compiler, "-I", headers, "-w", "-o", binary, source], check=True)
    return subprocess.run([binary], input=given, capture_output=True, check=True, timeout=30).stdout


def test_a_ground_station_in_c_reads_what_we_send(headers: Path) -> None:
    encoder = Encoder(1, 191)
    stream = b"".join(
        encoder.encode(value)
        for value in (
            Status(0, 0.0, 5, earth=True, heading=0.25, joint=-7.5, k=3, actuator_present=True, fault=True),
            Source(0, 1, 2, 3, 0.5, 0.0625, 0.9, 0.3, earth=False, resolved=True, final=True),
            Alignment(0, 1, 1, 3, 0, 0.1, 0.1, 212.5e-6, (1, 2), Rule.ARGMAX, CandidateState.TURNING, earth=True),
            Separation(0, 1, 1, 2, SeparationPhase.RUN, (0, 2), "local Gaussian 16", earth=True),
        )
    )
    assert run(headers, READER, b"noise" + stream).decode().splitlines() == [
        "status 1/191 5 -0.2500 7.5000 3 255 9",
        "source 2/3 -0.5000 0.0625 2 5",
        "alignment 1 212.5 6 2 1",
        "separation 1 5 local Gaussian 1 2",
    ]


def test_a_ground_station_of_an_older_dialect_reads_a_source_that_is_tracked(older_headers: Path) -> None:
    source = Source(
        0, 1, 2, 3, 0.5, 0.0625, 0.9, 0.3, earth=False, resolved=True, final=True, tracked=True, rate=0.25, age=1.5
    )
    told = run(older_headers, READER, Encoder(1, 191).encode(source)).decode().splitlines()
    assert told == ["source 2/3 -0.5000 0.0625 2 13"]


def test_we_read_what_a_program_in_c_sends(headers: Path) -> None:
    (packet,) = Decoder().feed(run(headers, WRITER))
    assert (packet.system_id, packet.component_id) == (7, 42)
    assert packet.value == Source(
        time_usec=123456, estimate=9, source=1, count=3, azimuth=0.5, mirror=-1.25, sigma=0.125, elevation=0.25,
        confidence=0.75, weight=0.5, score=2.0, earth=True, resolved=False, target=True, tracked=True,
        rate=0.25, age=1.5,
    )  # fmt: skip
