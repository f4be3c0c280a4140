"""How things stand at one moment, from what was heard last and what the actuator says at present."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ross_payload import __version__
from ross_payload.angles import wrap
from ross_payload.config import Config
from ross_payload.interfaces import ActuatorState, Capabilities, Input
from ross_payload.localization.model_order import MAX_SOURCES
from ross_payload.plugin_results import MOST_SOURCES
from ross_protocols.mavlink.values import Information


@dataclass(frozen=True, slots=True)
class Snapshot:
    """How things stand; angles in radians, counter-clockwise."""

    mission_time: float = 0.0  # [s]
    time_usec: int = 0  # [us]
    unix: bool = False  # time_usec is UNIX time, else since boot
    earth: bool = False  # headings are in the earth frame
    heading: float | None = None
    mount_yaw: float | None = None
    present: bool = False  # an actuator reports; else what follows means nothing
    joint: float | None = None
    joint_rate: float | None = None  # [rad/s]
    settled: bool = False
    homed: bool = False
    open_loop: bool = False
    fault: str = ""
    rotation_max: int = 0  # R
    criterion: float | None = None
    streaming: bool = False  # what is heard leaves the payload live
    recording: bool = False  # what is heard is kept on a disk


@dataclass(frozen=True, slots=True)
class Moment:
    """What everything else is told with."""

    time_usec: int  # [us]
    unix: bool
    config: Config  # in force
    open_loop: bool
    streaming: bool = False  # what is heard leaves the payload live
    recording: bool = False  # what is heard is kept on a disk


def standing(hop: Input | None, state: ActuatorState | None, moment: Moment) -> Snapshot:
    """Return how things stand.

    While the mission computes, what it heard last grows old; the actuator's own report does not.
    """
    fault = "" if state is None or state.healthy else state.fault or "the actuator reports a fault"
    unheard = Snapshot(
        time_usec=moment.time_usec,
        unix=moment.unix,
        present=state is not None,
        joint=None if state is None else state.angle,
        joint_rate=None if state is None else state.rate,
        settled=state is not None and state.settled,
        homed=state is not None and state.homed,
        open_loop=moment.open_loop,
        fault=fault,
        rotation_max=moment.config.explore.last_rotation,
        criterion=moment.config.exploit.criterion,
        streaming=moment.streaming,
        recording=moment.recording,
    )
    if hop is None:
        return unheard
    rate, pointing = moment.config.audio.rate_hz, hop.pointing
    seconds = hop.block.samples.shape[1] / rate
    joint = pointing.joint if state is None else state.angle
    return replace(
        unheard,
        mission_time=hop.block.index / rate + seconds,
        earth=pointing.earth,
        heading=wrap(pointing.at(joint)),
        mount_yaw=pointing.base if pointing.earth else None,
        present=True,
        joint=joint,
        joint_rate=wrap(pointing.heading - hop.heading_start) / seconds if state is None else state.rate,
        settled=hop.settled,
        homed=state is None or state.homed,
        fault=hop.fault or fault,
    )


def information(config: Config, capabilities: Capabilities | None, time_usec: int) -> Information:
    """Return who we are; the travel is the actuator's, or the guard's limits when no actuator is given."""
    guard = config.guard
    lower, upper, speed = (math.radians(x) for x in (guard.lower_deg, guard.upper_deg, guard.max_speed_deg_s))
    if capabilities is not None:
        lower, upper, speed = capabilities.lower, capabilities.upper, capabilities.max_speed
    return Information(
        time_usec=time_usec,
        spacing=config.array.spacing_m,
        speed_of_sound=config.array.speed_of_sound_m_s,
        axis_offset=config.offset,
        joint_lower=lower if math.isfinite(lower) else None,
        joint_upper=upper if math.isfinite(upper) else None,
        joint_speed=speed,
        unit=config.explore.unit_s,
        rate=config.audio.rate_hz,
        k_max=MAX_SOURCES if config.explore.method == "joint" else MOST_SOURCES,
        software_version=__version__,
        actuator=config.actuator.kind,
    )
