"""Scenarios drawn at random: whatever a file may ask for, in combinations that nobody has thought of."""

from __future__ import annotations

import random
from typing import Any

from ross_payload.config import validated
from ross_payload.errors import ConfigError
from ross_sim.scenario import Scenario

KINDS = ("tb6600", "grbl", "mavlink_gimbal", "dronecan_servo", "canopen_drive", "vehicle_yaw", "ideal")
SEPARATORS = ("auto", "refined", "gaussian", "duet", "auxiva", "iva", "mvdr", "lcmv", "paper")
MICROPHONES = (
    {"gain_db": [6, -6]}, {"invert": [True, False]}, {"swapped": True}, {"spacing_m": 0.06}, {"offset_deg": 20},
    {"gain_db": [-100, 0]}, {"gain_db": [60, 60]}, {"roll_off_hz": [20, 60]},
)  # fmt: skip


def any_scenario(seed: int) -> Scenario:
    """The first possible scenario that a seed draws."""
    chance = random.Random(seed)  # noqa: S311  of a test
    while True:
        values = _values(chance)
        try:
            scenario = validated(Scenario, values, "drawn")
            faults = sorted(scenario.far_end().faults)
            if not faults or chance.random() < 0.6:
                return scenario
            return validated(Scenario, values | {"troubles": _troubles(chance, faults)}, "drawn")
        except ConfigError:  # it asks for what cannot be, as a rate that the actuator does not reach
            continue


def _some(chance: random.Random, odds: float, **choices: tuple[Any, ...]) -> dict[str, Any]:
    """Each key with one of its choices, as often as the odds say."""
    return {key: chance.choice(values) for key, values in choices.items() if chance.random() < odds}


def _values(chance: random.Random) -> dict[str, Any]:
    kind, n = chance.choice(KINDS), chance.choice((0, 1, 2, 2, 3, 3, 3, 4, 5, 6))
    explore = _some(
        chance, 0.2, unit_s=(0.5, 1, 2, 5), step_deg=(5, 10, 30, 90), max_rotations=(1, 2, 6, 12, 24),
        method=("joint", "markov", "markov-plain"), lead_in_s=(0, 0.1, 5), continuous=(True,), rate_deg_s=(5, 45),
        pipelined=(True,), frame=(128, 512, 1002, 2048), overlap=(0.25, 0.5, 0.9),
    )  # fmt: skip
    exploit = _some(
        chance, 0.25, run_s=(1, 2, 5), runs=(1, 2, 3), check_s=(0.5, 1), separator=SEPARATORS, rules=("paper",),
        criterion=(-5, 0, 2, 50), max_restarts=(0, 1), track=(False,),
    )  # fmt: skip
    audio = _some(
        chance, 0.2, rate_hz=(24000, 32000, 44100, 48000), hop_ms=(1, 5, 20), frame=(128, 512, 1024, 4096),
        overlap=(0.25, 0.5, 0.9), gain_db=((-30, 30), (12, 12)),
    )  # fmt: skip
    guard = _some(
        chance, 0.2, max_speed_deg_s=(10, 60, 400), max_acceleration_deg_s2=(5, 50, 1000),
        on_fault=("release", "park"), max_move_s=(5,),
    )  # fmt: skip
    if chance.random() < 0.4:
        low = chance.choice((-200, -90, -45, -10, 0, 30))
        guard |= {"lower_deg": low, "upper_deg": low + chance.choice((5, 60, 180, 270)), "park_deg": low}
    payload: dict[str, Any] = {
        "audio": audio, "explore": explore | {"min_rotations": 1}, "exploit": exploit, "guard": guard,
        "actuator": {"kind": kind, "options": {"turn_vehicle": True} if kind == "vehicle_yaw" else {}},
        "array": _some(chance, 0.2, spacing_m=(0.01, 0.1, 0.3), offset_deg=(37, 180, -90)),
        "ego_noise": _some(chance, 0.15, learn=(True,)), "seed": chance.randrange(1000),
    }  # fmt: skip
    size = [chance.uniform(5, 10), chance.uniform(5, 10)] + [chance.uniform(2.4, 4)] * chance.choice((0, 0, 1))
    values: dict[str, Any] = {
        "title": "drawn", "payload": payload, "target": chance.choice((0, 0, 0, n, n + 1)),
        "talkers": [_talker(chance) for _ in range(n)],
        "room": {"size_m": size, "t60_s": chance.choice((0, 0, 0.2, 0.3)), "turns_heard": chance.random() < 0.3},
        "noise": {"snr_db": chance.choice((0, 10, 20, 40, 60)), "motor_db": chance.choice((-40, -20, 0)),
                  "sources": _sources(chance)},
    }  # fmt: skip
    if chance.random() < 0.12:
        values["microphones"] = chance.choice(MICROPHONES)
    if chance.random() < 0.2:
        payload["mount"] = {"source": "fixed" if kind == "vehicle_yaw" else "autopilot"}
        turning = _some(chance, 0.4, amplitude_deg=(10, 60), drift_deg=(5,), steady_deg_s=(5,))
        values["vehicle"] = {} if kind == "vehicle_yaw" else {"yaw_deg": chance.uniform(-180, 180)} | turning
    return values


def _talker(chance: random.Random) -> dict[str, Any]:
    azimuth = chance.uniform(-180, 180)
    walks = [{"at_s": 20, "azimuth_deg": azimuth + chance.uniform(-90, 90)}, {"at_s": 40, "azimuth_deg": azimuth}]
    return {"azimuth_deg": azimuth, "distance_m": chance.uniform(0.4, 2.3)} | _some(
        chance, 0.15, level_db=(-20, 10), start_s=(0, 15), end_s=(21, 60), pauses=([[5, 9], [15, 30]],), path=(walks,)
    )


def _sources(chance: random.Random) -> list[dict[str, Any]]:
    loud = chance.uniform(-5, 20)
    every = (
        {"name": "fan", "azimuth_deg": chance.uniform(-180, 180), "distance_m": 1.5},
        {"name": "rotors", "kind": "rotor"}, {"name": "wind", "kind": "wind"}, {"name": "talk", "kind": "babble"},
        {"name": "car", "kind": "passing_car", "azimuth_deg": 50},
    )  # fmt: skip
    return [source | {"snr_db": loud} for source in every if chance.random() < 0.08]


def _troubles(chance: random.Random, faults: list[str]) -> list[dict[str, Any]]:
    begins = [chance.uniform(0, 40) for _ in range(chance.choice((1, 1, 2)))]
    return [
        {"fault": chance.choice(faults), "at_s": begin} | _some(chance, 0.5, end_s=(begin + 0.3, begin + 10))
        for begin in begins
    ]
