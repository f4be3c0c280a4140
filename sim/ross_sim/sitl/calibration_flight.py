"""A calibration in lock-step: the real turn, guard and driver in a simulated room, with microphones not as told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from ross_payload.actuators.registry import open_actuator
from ross_payload.calibration.cross_spectrum import HeadingSpectrum
from ross_payload.doctor.calibration_session import Rig, TurnPlan, turned
from ross_payload.interfaces import Services
from ross_payload.mavlink import Router
from ross_payload.service.runner import Observer
from ross_payload.sessions.manifest import Beginning
from ross_sim.clock import SimClock
from ross_sim.devices.far_end import FarEnd, Fault, far_end_of
from ross_sim.scenario import Scenario
from ross_sim.sitl.mission_session import POLL, aboard
from ross_sim.sitl.recording import recorded
from ross_sim.sitl.world import World
from ross_sim.talkers.speech import TalkerVoice

Shaft = Callable[[float], float]


class InexactShaft:
    """A far end whose load is not quite where its motor is: off by an error [rad] that depends on the angle [rad]."""

    def __init__(self, far_end: FarEnd, error: Shaft) -> None:
        self.port, self.faults = far_end.port, far_end.faults
        self._far_end, self._error = far_end, error

    def advance(self, now: float) -> None:
        """Let the device live until ``now`` [s]."""
        self._far_end.advance(now)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        angle = self._far_end.angle()
        return angle + self._error(angle)

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Let a fault begin, or end."""
        self._far_end.afflict(fault, on)

    def complaints(self) -> list[str]:
        """Return what went wrong so far, in words."""
        return self._far_end.complaints()


def turned_in(
    scenario: Scenario,
    voices: Sequence[TalkerVoice],
    plan: TurnPlan,
    observers: tuple[Observer, ...] = (),
    *,
    shaft: Shaft | None = None,
    record: Path | None = None,
    cache: Path | None = None,
) -> tuple[list[HeadingSpectrum], World]:
    """Turn in a scenario and listen; return what was heard at every heading, and the world with its truth.

    ``shaft`` is the error of the true joint angle at every angle [rad], None: there is none; in the folder ``record``
    the session is recorded.

    Raises
    ------
    RossError
        As `ross_payload.doctor.calibration_session.turned`.
    """
    config, clock = scenario.payload, SimClock()
    with ExitStack() as stack:
        links = stack.enter_context(Router.open(config.links, clock, system_id=config.telemetry.system_id))
        device = far_end_of(config)
        far_end = device if shaft is None else InexactShaft(device, shaft)
        world = World(scenario, scenario.cast(voices).talkers, far_end, clock, config.seed, cache=cache)
        actuator = stack.enter_context(open_actuator(config, Services(clock, lambda url: far_end.port)))
        far_end.advance(clock.now())
        mount, _ = aboard(scenario, clock, links)
        clock.every(POLL, links.poll)
        stack.enter_context(world.source)
        able = actuator.capabilities
        begin = Beginning("session", config, able.lower, able.upper)
        recorder = stack.enter_context(recorded(record, begin, clock, links))
        seeing = observers if recorder is None else (*observers, recorder)
        return turned(Rig(clock, actuator, world.source, mount), config, plan, seeing), world
