"""What an emulated payload tells at a time: full telemetry of talkers who walk around it."""

import math

from ross_protocols.mavlink.computer import Computer, computer_message
from ross_protocols.mavlink.values import (
    Alignment,
    Audio,
    CandidateState,
    Density,
    Health,
    Heartbeat,
    Information,
    Isolation,
    LinkReport,
    Named,
    Phase,
    Recording,
    RecordingState,
    Rule,
    Separation,
    Source,
    Status,
)

ROTATIONS = 4
LONGEST_ITD = 146e-6  # [s]
WALK = 0.05  # [rad/s] of the talkers
SWAY = 0.4  # [rad] of the array
STATES = ((0, 1), (3, 2), (6, 3), (12, 4), (14, 5), (18, 6))  # from a time [s] on: ROSS_STATE
POINTS = 80


def wrapped(angle):
    return math.remainder(angle, 2 * math.pi)


def azimuth(source, count, time):
    """Where a talker is [rad]."""
    return wrapped(2 * math.pi * source / count + WALK * time + 0.3)


def heading(time):
    """Where the array points [rad]."""
    return SWAY * math.sin(time / 4)


def state(time):
    return [number for since, number in STATES if time >= since][-1]


def status(time, sources=3):
    """The mission at a glance."""
    explored = time >= 6
    return Status(
        time_usec=int(time * 1e6),
        mission_time=time,
        state=state(time),
        earth=True,
        heading=heading(time),
        heading_goal=None,
        joint=heading(time),
        joint_rate=SWAY / 4 * math.cos(time / 4),
        mount_yaw=0.0,
        score=1.0 + 0.5 * math.sin(time / 3) if explored else None,
        criterion=0.6,
        rotation=min(int(time / 3), ROTATIONS),
        rotation_max=8,
        k=min(sources, 32) if explored else None,
        target=1 if time >= 14 and sources > 1 else None,
        certain=explored,
        noise_measured=True,
        target_found=time >= 14,
        actuator_present=True,
        settled=True,
        homed=True,
    )


def source(index, count, time):
    """One talker."""
    return Source(
        time_usec=int(time * 1e6),
        estimate=1,
        source=index,
        count=count,
        azimuth=azimuth(index, count, time),
        mirror=wrapped(2 * heading(time) - azimuth(index, count, time)),
        sigma=math.radians(2 + index % 4),
        confidence=max(0.95 - 0.1 * (index % 8), 0.1),
        weight=1 / count,
        earth=True,
        resolved=index % 3 != 2,
        target=index == 1,
    )


def alignment(index, count, time):
    """One heading that sets a talker apart."""
    goal = wrapped(azimuth(index, count, time) + 0.5)
    return Alignment(
        time_usec=int(time * 1e6),
        plan=1,
        candidate=index,
        count=count,
        source=index,
        heading=goal,
        joint=goal,
        isolation=60e-6,
        aliased=tuple(other for other in range(min(count, 32)) if other != index)[:2],
        rule=Rule.GAIN,
        state=CandidateState.ACCEPTED if index == 1 else CandidateState.PLANNED,
        earth=True,
        gain=9.0 + index,
    )


def bumps(time, count):
    """A curve with as many hills as there are talkers, 0 to 1."""
    return tuple(abs(math.sin(math.pi * count * step / (POINTS - 1) + time / 9)) for step in range(POINTS))


def density(rotation, time, count):
    first, last = -LONGEST_ITD, LONGEST_ITD
    return Density(int(time * 1e6), 1, rotation, rotation * math.pi / 8, True, first, last, bumps(time, count))


def isolation(index, time):
    return Isolation(int(time * 1e6), 1, index, True, 0.0, math.pi, 90e-6, bumps(time + 5 * index, 2))


def separation(group, time, count):
    members = (1,) if group == 0 else tuple(index for index in range(min(count, 32)) if index != 1)
    return Separation(
        time_usec=int(time * 1e6),
        separation=1,
        group=group,
        count=2,
        phase=Phase.RUN,
        members=members,
        method="gaussian",
        earth=True,
        heading=heading(time),
        score=1.2 - group,
        criterion=0.6,
        si_sdr=11.0 - 4 * group,
        si_sdri=8.0 - 3 * group,
        accepted=group == 0,
        target=group == 0,
    )


def information(time):
    return Information(
        int(time * 1e6), 0.05, 343.0, 0.0, -math.pi / 2, math.pi / 2, 4.0, 3.0, 16000, 5, "0.9", "tb6600"
    )


def condition(time, system):
    """How the payload itself is."""
    stamp = int(time * 1e6)
    level = -30 + 6 * math.sin(time)
    computer = Computer(time, (0.4 + 0.2 * math.sin(time / 7), 0.2), 51.0, 6e8, 4e9, 3e9, 3e10)
    return [
        information(time),
        Audio(stamp, 0, (level, level - 1), (level + 9, level + 8), rate=16000.0),
        Recording(stamp, RecordingState.ON, time, 2.7e10, f"flight-{system}"),
        LinkReport(stamp, 0, 2, "udpout:127.0.0.1:14550", True, False, sent=int(99 * time), received=int(time)),
        LinkReport(stamp, 1, 2, "serial:/dev/ttyAMA0:57600", True, True, sent=int(9 * time), received=int(50 * time)),
        computer_message(computer, stamp),
        Named(time, "ross_k", 3.0),
        Named(time, "ross_head", math.degrees(heading(time))),
    ]


def full(time, sources=3, system=1):
    """Everything there is to tell at once; curves only of as many talkers as a payload can have."""
    few = min(sources, 8)
    lists = [source(index, sources, time) for index in range(sources)]
    lists += [alignment(index, few, time) for index in range(few)]
    lists += [separation(group, time, sources) for group in range(2)]
    lists += [density(rotation, time, few) for rotation in range(ROTATIONS)]
    lists += [isolation(index, time) for index in range(few)]
    beat = Heartbeat(Health.ACTIVE, state(time))
    return [beat, status(time, sources), *lists, *condition(time, system)]
