"""What five talkative payloads cost a ground station."""

import asyncio
import os
import time
from pathlib import Path

import pytest

from fleet_bench import FleetBench
from ports import free_port
from ross_payload.ground.station import Station
from waiting import wait_for_async

PAYLOADS, HZ, SPAN, WARM = 5, 10.0, 60.0, 5.0  # SPAN and WARM in seconds
MOST = 0.3  # of a core


def resident() -> float:
    """The memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@pytest.mark.soak
async def test_full_telemetry_of_five_payloads_ten_times_a_second_costs_less_than_a_third_of_a_core(
    tmp_path: Path,
) -> None:
    async def measured() -> tuple[float, float, float]:
        port = free_port()
        async with Station([f"udpin:127.0.0.1:{port}"], log=tmp_path) as station:
            with FleetBench(port, PAYLOADS, HZ):
                await wait_for_async(lambda: len(station.fleet.payloads) == PAYLOADS)
                await asyncio.sleep(WARM)
                used, began, heard = time.process_time(), time.monotonic(), station.links()[0].frames
                memory = resident()
                await asyncio.sleep(SPAN)
                span = time.monotonic() - began
                rate = (station.links()[0].frames - heard) / span
                return (time.process_time() - used) / span, rate, resident() - memory

    share, rate, growth = await measured()
    print(  # noqa: T201  the figure itself
        f"\n{share:.3f} of a core for {rate:.0f} messages/s with a log; {growth:+.1f} MB in {SPAN:.0f} s"
    )
    assert rate > 10 * PAYLOADS * HZ, "full telemetry"
    assert share < MOST
    assert growth < 10.0
