"""A room and a far end in real time, for a payload in another process."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ross_sim.clock import QUANTUM, RealTimeDriver
from ross_sim.devices.connections import Coupling
from ross_sim.live_world.audio_output import AudioOutput
from ross_sim.sitl.ground_truth import TruthWriter
from ross_sim.sitl.world import World

STRETCH = 50  # quanta between two writes of what is true


class LiveWorld:
    """Lives by the wall's clock, a quantum at a time; silent until it is opened.

    Parameters
    ----------
    world
        On the clock that ``real_time`` drives.
    side
        The far end's side of the wire.
    outlets
        Where the sound goes.
    truth
        Takes what was rendered.
    real_time
        Drives.
    """

    def __init__(
        self,
        world: World,
        side: Coupling,
        outlets: Sequence[AudioOutput],
        truth: TruthWriter,
        real_time: RealTimeDriver,
    ) -> None:
        self._world = world
        self._side = side
        self._outlets = outlets
        self._truth = truth
        self._real_time = real_time
        self._quanta = 0  # since the sound began
        self._samples = 0  # samples
        self._began: float | None = None

    def live(self, wanted: Callable[[], bool], stopped: Callable[[], bool]) -> None:
        """Live until ``stopped``; the sound begins when it is ``wanted``."""
        while not (stopped() or wanted()):
            self._real_time.step(self._side.exchange, self._wait)
        if stopped():
            return
        with self._world.source:
            self._began = self._real_time.epoch + self._world.clock.now()
            while not stopped():
                self._real_time.step(self._side.exchange, self._sound)
            self._truth.write(self._world.drain())

    def account(self) -> dict[str, Any]:
        """Return when the sound began on the monotonic clock [s], and the samples that nobody fetched in time."""
        return {"began_s": self._began, "lost": sum(outlet.lost for outlet in self._outlets)}

    def _wait(self) -> None:
        silence = self._world.mixture()
        for outlet in self._outlets:
            outlet.put(silence)  # of no samples: only to see who listens

    def _sound(self) -> None:
        self._quanta += 1
        n = self._quanta * self._world.rate // round(1 / QUANTUM) - self._samples
        samples = self._world.source.read(n).samples
        self._samples += n
        for outlet in self._outlets:
            outlet.put(samples)
        if self._quanta % STRETCH == 0:
            self._truth.write(self._world.drain())
