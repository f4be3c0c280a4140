"""Explore a simulated room, compare the azimuths with the scenario, and listen to the target.

``python flight.py URL SCENARIO [DEGREES]``: exit code 0 when everybody was found within so many degrees (5) and the
target was recognised where it is, 1 with a line that says what was not.
"""

import asyncio
import sys
from argparse import ArgumentParser
from contextlib import suppress
from math import degrees

from ross_payload.errors import RossError
from ross_payload.ground import GroundError, TaskCancelled, connect
from ross_sim.scenario import Scenario, load
from ross_sim.sitl.mission_session import room_yaw

MINUTES = 10.0  # until it is given up


def apart(one: float, other: float) -> float:
    """Angle between two directions [deg]."""
    return abs((one - other + 180.0) % 360.0 - 180.0)


def azimuths(scenario: Scenario) -> list[float]:
    """Where the talkers are for a client [deg]: clockwise, from north where the payload knows it."""
    return [-(talker.azimuth_deg + degrees(room_yaw(scenario))) for talker in scenario.talkers]


def azimuth_of_target(scenario: Scenario) -> float | None:
    """Where the target is for a client [deg]; None when the scenario does not say which of its talkers that is."""
    named = [talker.name for talker in scenario.talkers]
    index = named.index(scenario.target) if scenario.target in named else scenario.target
    return azimuths(scenario)[index] if isinstance(index, int) and index < len(named) else None


async def fly(url: str, scenario: str, allowed: float) -> str:
    """Fly one mission; return what is wrong with it, empty when all is well."""
    truth, target = azimuths(load(scenario)), azimuth_of_target(load(scenario))
    async with connect(url) as payload:
        found = [source.azimuth_deg for source in await payload.explore()]
        print("talkers at", *(f"{azimuth:.1f}" for azimuth in found))
        if len(found) != len(truth):
            return f"expected {len(truth)} talkers, got {len(found)}"
        error = max((min(apart(azimuth, each) for each in found) for azimuth in truth), default=0.0)
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
        recognised_at = found[payload.view["mission"]["target"]]
        await payload.cancel()
        with suppress(TaskCancelled):  # as asked for
            await searching
        if target is not None and apart(recognised_at, target) > allowed:  # somebody else was taken for it
            return f"expected the target at {target % 360.0:.1f} deg, got {recognised_at:.1f}"
        print("target recognised")
    return ""


async def main(url: str, scenario: str, allowed: float) -> int:
    """Fly within a time limit; return the exit code."""
    try:
        async with asyncio.timeout(60.0 * MINUTES):
            wrong = await fly(url, scenario, allowed)
    except (GroundError, RossError, TimeoutError) as error:
        wrong = str(error) or f"expected an end within {MINUTES:g} minutes, got none"
    if wrong:
        print(wrong, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    parser = ArgumentParser(description="Fly one mission of a simulated payload.")
    parser.add_argument("url")
    parser.add_argument("scenario")
    parser.add_argument("degrees", type=float, nargs="?", default=5.0)
    given = parser.parse_args()
    sys.exit(asyncio.run(main(given.url, given.scenario, given.degrees)))
