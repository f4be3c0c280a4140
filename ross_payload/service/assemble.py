"""From a configuration to what the mission works with."""

from __future__ import annotations

import math
from functools import partial

from ross_payload import plugins
from ross_payload.alignment.paper_rules import paper_plan
from ross_payload.alignment.plan import plan
from ross_payload.angles import wrap
from ross_payload.config import Config, Table, validated
from ross_payload.dsp.rotors import Rotors
from ross_payload.dsp.stft import Stft, separation_frame, short_frames
from ross_payload.errors import PluginError
from ross_payload.events import Estimate, SourceEstimate
from ross_payload.interfaces import Attitude, VoicePrint
from ross_payload.localization.joint_in_noise import JointInNoise
from ross_payload.mission.settings import Planner, Settings, Tools
from ross_payload.plugin_checks import CheckedExplorer, checked_explorer, load_separator
from ross_payload.voiceprint.model_folder import ModelFolder

PLANNERS: dict[str, Planner] = {"best": plan, "paper": paper_plan}


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
        park=min(max(math.radians(config.guard.park_deg), lower), upper),  # where the guard parks, too
        follow=math.radians(config.mount.follow_deg),
        track=exploit.track,
        level=config.mount.source == "fixed",
        ego_noise=config.ego_noise.learn,
        blades=config.ego_noise.blades,
        turn_rate=math.radians(explore.rate_deg_s),
        periods=explore.periods,
        longest_move=config.guard.max_move_s,
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


def explorer_of(config: Config) -> CheckedExplorer:
    """Make the explorer that a configuration names, with its own options.

    Raises
    ------
    ConfigError
        When there is none of that name, or an option is wrong.
    PluginError
        When it is none, or is to hear while the array turns, and cannot.
    """
    array, asked = config.array, config.explore
    factory = plugins.load("ross_payload.explorers", asked.method)
    model: type[Table] = getattr(factory, "Options", Table)
    if not callable(getattr(factory, "make", None)) or not issubclass(model, Table):
        expected = "an object with make(spacing, speed_of_sound[, options]), and Options a Table if it has any"
        raise PluginError(f"explorer '{asked.method}': expected {expected}, got {factory!r}")
    options = validated(model, asked.options, f"explore.options of '{asked.method}'")
    given = (options,) if asked.options else ()
    made = checked_explorer(asked.method, lambda: factory.make(array.spacing_m, array.speed_of_sound_m_s, *given))
    if asked.continuous and not made.hears_turning:
        raise PluginError(f"explore.continuous: expected an explorer that hears while turning, got '{asked.method}'")
    return made


def tools_of(config: Config, voiceprint: VoicePrint | None) -> Tools:
    """Load the plug-ins that a configuration names."""
    audio, explorer = config.audio, explorer_of(config)
    short = config.explore.frame or short_frames(audio.rate_hz).frame
    long = audio.frame or separation_frame(audio.rate_hz)
    return Tools(
        explorer=explorer,
        explorer_stft=Stft(audio.rate_hz, short, round(short * (1 - config.explore.overlap))),
        separator=load_separator(config.exploit.separator),
        stft=Stft(audio.rate_hz, long, round(long * (1 - audio.overlap))),
        voiceprint=voiceprint,
        plan=PLANNERS[config.exploit.rules],
        voice_model=partial(ModelFolder.default().in_use, config.voice_print.model),
        rotors=rotors_of(config),
        in_noise=in_noise_of(config),
        turning=explorer if config.explore.continuous else None,
        reconsidering=explorer if explorer.reconsiders and _at_rest_among_talkers(config) else None,
    )


def _at_rest_among_talkers(config: Config) -> bool:
    """Whether it explores step by step, without a vehicle's noise: of the rest nobody knows how sure it is later."""
    return not (config.explore.continuous or config.ego_noise.learn)


def rotors_of(config: Config) -> Rotors | None:
    """Where the rotors are; None when nobody says."""
    places, array = config.ego_noise.rotors_m, config.array
    return Rotors(places, array.spacing_m, array.speed_of_sound_m_s) if places else None


def in_noise_of(config: Config) -> JointInNoise | None:
    """What observes for the explorer where the vehicle makes noise; None: the explorer does not know of noise."""
    if config.explore.method != "joint" or not config.ego_noise.learn:
        return None
    return JointInNoise(config.array.spacing_m, config.array.speed_of_sound_m_s)
