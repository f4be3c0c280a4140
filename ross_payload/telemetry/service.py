"""The telemetry of one mission: watches it and speaks on every link and into the log."""

from __future__ import annotations

import math
from pathlib import Path
from types import TracebackType
from typing import Self

from ross_payload import __version__
from ross_payload.angles import wrap
from ross_payload.config import Config
from ross_payload.dsp.order import MAX_SOURCES
from ross_payload.events import Event
from ross_payload.interfaces import Actuator, Capabilities, Clock, Feedback, Input
from ross_payload.links import Links
from ross_payload.telemetry.report import Every, Reporter, Snapshot
from ross_payload.telemetry.tlog import TlogRecorder
from ross_protocols.values import Information

LOOK_PERIOD = 0.050  # [s] between two looks at what is due and at what has arrived


class Telemetry:
    """Observes a mission on its own thread. A context manager; the links belong to who opened them.

    Raises
    ------
    ConfigError
        When the log cannot be made.
    """

    def __init__(
        self, config: Config, clock: Clock, links: Links, tlog: Path | None, actuator: Actuator | None = None
    ) -> None:
        self._clock = clock
        self._links = links
        self._actuator = actuator
        self._rate = config.audio.rate_hz
        self._looking = Every(LOOK_PERIOD)
        self._open_loop = actuator is not None and actuator.capabilities.feedback is Feedback.MODEL
        self._component = links.component(config.telemetry.component_id)
        self._reporter = Reporter(
            self._component.send,
            self._time_usec,
            information(config, None if actuator is None else actuator.capabilities),
            rotation_max=config.explore.max_rotations,
            criterion=config.exploit.criterion,
        )
        self._tlog = None if tlog is None else TlogRecorder(tlog)
        self._component.tap(self._record)

    def heard(self, heard: Input) -> None:
        """Send what is due; listen to the links."""
        now = self._clock.now()
        if self._looking.due(now):
            self._links.poll()
            self._reporter.tick(now, self._snapshot(heard))

    def said(self, event: Event, heard: Input) -> None:
        """Tell what the mission has just said."""
        self._reporter.handle(event, self._snapshot(heard))

    def __enter__(self) -> Self:
        """The log is open from the start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the log."""
        if self._tlog is not None:
            self._tlog.close()

    def _snapshot(self, heard: Input) -> Snapshot:
        seconds = heard.block.samples.shape[1] / self._rate
        state = None if self._actuator is None else self._actuator.state()
        turned = heard.heading_end - heard.heading_start
        return Snapshot(
            mission_time=heard.block.index / self._rate + seconds,
            earth=heard.attitude.known,
            heading=wrap(heard.heading_end),
            mount_yaw=heard.attitude.yaw if heard.attitude.known else None,
            present=True,
            joint=heard.joint,
            joint_rate=wrap(turned) / seconds if state is None else state.rate,
            settled=heard.settled,
            homed=state is None or state.homed,
            open_loop=self._open_loop,
            fault=heard.fault,
        )

    def _time_usec(self) -> int:
        return round(self._clock.now() * 1e6)

    def _record(self, frame: bytes) -> None:
        if self._tlog is not None:
            self._tlog.write(self._time_usec(), frame)


def information(config: Config, capabilities: Capabilities | None) -> Information:
    """Return who we are; the travel is the actuator's, or the guard's limits when no actuator is given."""
    guard = config.guard
    lower, upper, speed = (math.radians(x) for x in (guard.lower_deg, guard.upper_deg, guard.max_speed_deg_s))
    if capabilities is not None:
        lower, upper, speed = capabilities.lower, capabilities.upper, capabilities.max_speed
    return Information(
        time_usec=0,
        spacing=config.array.spacing_m,
        speed_of_sound=config.array.speed_of_sound_m_s,
        axis_offset=config.offset,
        joint_lower=lower if math.isfinite(lower) else None,
        joint_upper=upper if math.isfinite(upper) else None,
        joint_speed=speed,
        unit=config.explore.unit_s,
        rate=config.audio.rate_hz,
        k_max=MAX_SOURCES,
        software_version=__version__,
        actuator=config.actuator.kind,
    )
