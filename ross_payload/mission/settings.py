"""What a mission is told before it begins: its numbers, and what it hears and decides with."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ross_payload.alignment.plan import Plan, Turn, plan
from ross_payload.dsp.rotors import Rotors
from ross_payload.dsp.stft import Stft
from ross_payload.events import SourceEstimate
from ross_payload.interfaces import Explorer, ReconsideringExplorer, Separator, TurningExplorer, VoicePrint
from ross_payload.localization.joint_in_noise import JointInNoise
from ross_payload.mission.source_tracking import SourceTracker
from ross_payload.voiceprint import VoiceModel, built_in_model


@dataclass(frozen=True, slots=True)
class Settings:
    """The mission's numbers, in SI and radians."""

    rate: int  # [Hz]
    spacing: float  # d [m]
    speed_of_sound: float  # v_p [m/s]
    lead_in: float  # [s] heard before anything turns
    unit: float  # T_unit [s]
    rotation: float  # one step of the exploration [rad]
    min_rotations: int
    max_rotations: int
    pipelined: bool  # try promising alignments before the exploration ends
    check: float  # T_check [s]
    run: float  # T_run [s]
    runs: int  # how many T_run until done, 0: until stopped
    criterion: float  # a voice above this score is the target
    max_restarts: int
    lower: float  # travel of the joint [rad]
    upper: float  # [rad]
    seed: int
    park: float = 0.0  # joint angle where it parks [rad]
    follow: float = math.radians(2.0)  # a heading that is off by more is followed [rad]
    track: bool = False  # follow sources that move while it listens
    level: bool = True  # sources are about as high as the array; not so below a vehicle that flies
    ego_noise: bool = False  # learn the noise of the vehicle in the lead-in
    blades: int = 2  # of every rotor
    turn_rate: float = math.radians(20.0)  # while it explores without a pause [rad/s]
    periods: int = 0  # T_unit that it listens then, at most; 0: it turns step by step
    longest_move: float = 30.0  # that the guard bears [s]


Planner = Callable[[Sequence[SourceEstimate], Turn, float, float | None], Plan]  # as `ross_payload.alignment.plan.plan`


@dataclass(frozen=True, slots=True)
class Tools:
    """What the mission hears and decides with; ``plan`` says where to turn, ``tracker`` follows who moves."""

    explorer: Explorer
    explorer_stft: Stft
    separator: Separator
    stft: Stft
    voiceprint: VoicePrint | None  # of the target, None: nobody is sought
    plan: Planner = plan
    voice_model: Callable[[], VoiceModel] = built_in_model  # enrols on the way; ConfigError: it cannot be used now
    tracker: type[SourceTracker] = SourceTracker
    rotors: Rotors | None = None  # of the vehicle
    in_noise: JointInNoise | None = None  # observes for the explorer where the vehicle makes noise
    turning: TurningExplorer | None = None  # the explorer, where it is to hear while the array turns
    reconsidering: ReconsideringExplorer | None = None  # the explorer, where it can be asked again later
