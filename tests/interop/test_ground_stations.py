"""The program of the guide for ground stations reads what an ArduPilot hands on, and what comes directly."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from examples import in_soak
from ports import free_port
from ross_payload.clock import SystemClock
from ross_payload.config import Config, Link
from ross_payload.events import Estimate, SourceEstimate, SourcesEstimated
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.mavlink import Router
from ross_payload.pointing import Pointing
from ross_payload.telemetry.component import Telemetry

pytestmark = pytest.mark.process
PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "ground-stations.md"
HOP = Input(AudioBlock(np.zeros((2, 160), np.float32), 0, 0.0), 0.0, Pointing(), settled=True, attitude=Attitude(0.0))
SOURCES = tuple(SourceEstimate(np.radians(azimuth), 0.02, 0.9, resolved=True) for azimuth in (-80.0, 40.0))


@pytest.mark.parametrize("role", ["autopilot", *in_soak("ground")])
def test_the_program_of_the_guide_shows_the_sources(role: str) -> None:
    found = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    port, clock = free_port(), SystemClock()
    with subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", found.group(1), f"udpin:127.0.0.1:{port}"],
        env=os.environ | {"MAVLINK20": "1"}, stdout=subprocess.PIPE, text=True,
    ) as program:  # fmt: skip
        watchdog = time.monotonic() + 60
        with (
            Router.open([Link(url=f"udpout:127.0.0.1:{port}", role=role)], clock) as links,
            Telemetry(Config(), clock, links) as telemetry,
        ):
            cancel = clock.every(0.01, links.poll)
            telemetry.on_event(SourcesEstimated(0.0, Estimate(SOURCES), 12, final=True), HOP)
            lines: set[str] = set()
            while len(lines) < 2 and time.monotonic() < watchdog:
                lines.add(program.stdout.readline().strip())
            cancel()
        program.terminate()
    assert lines == {"0 80", "1 -40"}, "clockwise"
