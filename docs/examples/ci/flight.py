"""Explore a simulated room, compare the azimuths with the scenario, and listen to the target.

``python flight.py URL SCENARIO [DEGREES]``: exit code 0 when everybody was found within so many degrees (5) and the
target was recognised, 1 with a line that says what was not.
"""

import asyncio
import sys
from contextlib import suppress

from ross_payload.ground import GroundError, TaskCancelled, connect
from ross_sim.scenario import load

MINUTES = 10.0  # until it is given up


def apart(one: float, other: float) -> float:
    """Angle between two directions [deg]."""
    return abs((one - other + 180.0) % 360.0 - 180.0)


async def fly(url: str, scenario: str, allowed: float) -> str:
    """Fly one mission; return what is wrong with it, empty when all is well."""
    truth = [-talker.azimuth_deg for talker in load(scenario).talkers]  # of a client: clockwise
    async with connect(url) as payload:
        found = [source.azimuth_deg for source in await payload.explore()]
        print("talkers at", *(f"{azimuth:.1f}" for azimuth in found))
        if len(found) != len(truth):
            return f"expected {len(truth)} talkers, got {len(found)}"
        error = max(min(apart(azimuth, each) for each in found) for azimuth in truth)
        print(f"largest error {error:.2f} deg")
        if error > allowed:
            return f"expected errors of {allowed:g} deg at most, got {error:.1f}"
        searching = asyncio.create_task(payload.find_voice(found))
        recognised = asyncio.create_task(payload.until(lambda: payload.view["mission"].get("target_found")))
        await asyncio.wait((searching, recognised), return_when=asyncio.FIRST_COMPLETED)
        if not recognised.done():
            recognised.cancel()
            await searching  # raises when it failed
            return "expected the target to be recognised, got the end of the search"
        print("target recognised")
        await payload.cancel()
        with suppress(TaskCancelled):  # as asked for
            await searching
    return ""


async def main(url: str, scenario: str, allowed: str = "5") -> int:
    """Fly within a time limit; return the exit code."""
    try:
        async with asyncio.timeout(60.0 * MINUTES):
            wrong = await fly(url, scenario, float(allowed))
    except (GroundError, TimeoutError) as error:
        wrong = str(error) or f"expected an end within {MINUTES:g} minutes, got none"
    if wrong:
        print(wrong, file=sys.stderr)
    return 1 if wrong else 0


sys.exit(asyncio.run(main(*sys.argv[1:])))
