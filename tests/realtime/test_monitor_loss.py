"""How soon ``ross monitor`` tells that a payload is heard no more."""

import time

import pytest

from monitor_bench import speaking, terminal
from ports import free_port

pytestmark = pytest.mark.alone  # 2.8 s of the 3.5 pass before it can be seen


def test_link_loss_is_shown_within_three_seconds_and_recovery_too():
    port = free_port()
    with terminal(f"udpin:127.0.0.1:{port}") as screen:
        with speaking(port):
            screen.shows("last telemetry 0.")
        lost = time.monotonic()
        screen.shows("NO TELEMETRY FOR")
        assert time.monotonic() - lost < 3.5
        with speaking(port):
            screen.shows("last telemetry 0.")
