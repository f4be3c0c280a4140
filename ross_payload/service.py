"""Configuration to objects, and the runner: read a hop, send an Input, obey the Output."""

from __future__ import annotations

import math
from queue import Empty, SimpleQueue
from typing import Protocol

from ross_payload import plugins
from ross_payload.angles import wrap
from ross_payload.config import Config, Table, validated
from ross_payload.dsp.alignment import plan
from ross_payload.dsp.paper_rules import paper_plan
from ross_payload.dsp.stft import Stft
from ross_payload.errors import ActuatorError
from ross_payload.events import Estimate, Event, SourceEstimate
from ross_payload.interfaces import (
    Actuator,
    ActuatorState,
    Attitude,
    AudioSource,
    Explorer,
    Input,
    Mission,
    Mount,
    Output,
    Result,
    Separator,
    VoicePrint,
)
from ross_payload.mission.context import Planner, Settings, Tools
from ross_payload.orders import Order

EXPLORER_FRAME = 0.043  # [s], rounded to a power of two in samples: short frames keep onsets apart
PLANNERS: dict[str, Planner] = {"best": plan, "paper": paper_plan}
REST_TIMEOUT = 10.0  # [s] of audio that a decelerating motor may take at the end


class Observer(Protocol):
    """Watches a mission: telemetry, recorders, live views."""

    def heard(self, heard: Input) -> None:
        """One hop was heard."""

    def said(self, event: Event, heard: Input) -> None:
        """The mission said something; this is the first hop after it."""


class Runner:
    """Drives one mission with real or simulated parts; every stop passes through it within one hop."""

    def __init__(self, mission: Mission, source: AudioSource, actuator: Actuator, mount: Mount, config: Config) -> None:
        self._mission = mission
        self._source = source
        self._actuator = actuator
        self._mount = mount
        self._hop = config.hop
        self._offset = config.offset
        self._rest_hops = math.ceil(REST_TIMEOUT * source.rate / config.hop)
        self._orders: SimpleQueue[Order] = SimpleQueue()
        self._fault = ""
        self.observers: list[Observer] = []

    def order(self, order: Order) -> None:
        """Ask the running mission for something; from any thread or signal handler."""
        self._orders.put(order)

    def run(self) -> Result:
        """Run the mission to its end and the actuator to rest."""
        output = next(self._mission)
        try:
            while True:
                self._move(output)
                heard = self._listen(output.goal)
                self._tell(output, heard)
                output = self._mission.send(heard)
        except StopIteration as end:
            result: Result = end.value
        except BaseException:
            self._actuator.stop()
            raise
        self._rest()
        return result

    def _listen(self, goal: float | None) -> Input:
        before = self._actuator.state()
        block = self._source.read(self._hop)
        after = self._actuator.state()
        heard = Input(
            block=block,
            heading_start=self._heading(before, block.time),
            heading_end=self._heading(after, block.time + self._hop / self._source.rate),
            joint=after.angle,
            settled=before.settled and after.settled and goal is None,
            attitude=self._mount.attitude(block.time),
            fault=self._fault or ("" if after.healthy else after.fault or "the actuator reports a fault"),
            orders=self._drain(),
        )
        for observer in self.observers:
            observer.heard(heard)
        return heard

    def _move(self, output: Output) -> None:
        if output.stop:
            self._actuator.stop()
        if output.goal is not None:
            try:
                self._actuator.command(output.goal)
            except ActuatorError as error:
                self._fault = str(error)

    def _tell(self, output: Output, heard: Input) -> None:
        for event in output.events:
            for observer in self.observers:
                observer.said(event, heard)

    def _rest(self) -> None:
        """Keep hearing until the motor stands still, so that what is recorded includes its deceleration."""
        for _ in range(self._rest_hops):
            if self._actuator.state().rate == 0.0:
                return
            self._listen(None)

    def _heading(self, state: ActuatorState, time: float) -> float:
        return self._mount.attitude(time).yaw + state.angle + self._offset

    def _drain(self) -> tuple[Order, ...]:
        orders = []
        try:
            while True:
                orders.append(self._orders.get_nowait())
        except Empty:
            return tuple(orders)


def settings_of(config: Config, lower: float, upper: float) -> Settings:
    """Convert a configuration to the mission's units; ``lower`` and ``upper`` are the guarded travel [rad]."""
    explore, exploit = config.explore, config.exploit
    return Settings(
        rate=config.audio.rate_hz,
        spacing=config.array.spacing_m,
        speed_of_sound=config.array.speed_of_sound_m_s,
        lead_in=explore.lead_in_s,
        unit=explore.unit_s,
        rotation=math.radians(explore.step_deg),
        min_rotations=explore.min_rotations,
        max_rotations=explore.max_rotations,
        pipelined=explore.pipelined,
        check=exploit.check_s,
        run=exploit.run_s,
        runs=exploit.runs,
        criterion=exploit.criterion,
        max_restarts=exploit.max_restarts,
        lower=lower,
        upper=upper,
        seed=config.seed,
    )


def informed_of(config: Config, attitude: Attitude) -> Estimate | None:
    """Convert what is told from outside to the frame of the headings; None when the mission has to explore.

    In the file azimuths are counter-clockwise from the zero of the mount; ``attitude`` says where that points.
    """
    told = config.informed
    if told is None:
        return None
    heights = (None,) * len(told.azimuths_deg) if told.elevations_deg is None else told.elevations_deg
    sources = (
        SourceEstimate(
            azimuth=wrap(math.radians(azimuth) + attitude.yaw),
            sigma=math.radians(told.sigma_deg),
            confidence=1.0,
            resolved=True,
            weight=1 / len(heights),
            elevation=None if height is None else math.radians(height),
        )
        for azimuth, height in zip(told.azimuths_deg, heights, strict=True)
    )
    return Estimate(tuple(sources), certain=True)


def explorer_of(config: Config) -> Explorer:
    """Make the explorer that a configuration names, with its own options.

    Raises
    ------
    ConfigError
        When there is none of that name, or an option is wrong.
    """
    array, asked = config.array, config.explore
    factory = plugins.load("ross_payload.explorers", asked.method)
    model: type[Table] = getattr(factory, "Options", Table)
    options = validated(model, asked.options, f"explore.options of '{asked.method}'")
    given = (options,) if asked.options else ()
    explorer: Explorer = factory.make(array.spacing_m, array.speed_of_sound_m_s, *given)
    return explorer


def tools_of(config: Config, voiceprint: VoicePrint) -> Tools:
    """Load the plug-ins that a configuration names."""
    audio = config.audio
    separator: Separator = plugins.load("ross_payload.separators", config.exploit.separator)
    frame = config.explore.frame or 2 ** round(math.log2(EXPLORER_FRAME * audio.rate_hz))
    return Tools(
        explorer=explorer_of(config),
        explorer_stft=Stft(audio.rate_hz, frame, round(frame * (1 - config.explore.overlap))),
        separator=separator,
        stft=Stft(audio.rate_hz, audio.frame, round(audio.frame * (1 - audio.overlap))),
        voiceprint=voiceprint,
        plan=PLANNERS[config.exploit.rules],
    )
