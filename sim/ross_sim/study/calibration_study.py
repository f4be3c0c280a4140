"""How well arrays are calibrated by turning: random arrays in simulated rooms, the real turn, guard and driver.

Every draw has its own spacing (30 to 100 mm), heading offset, gain, polarity, roll-offs and order of the cables, none
of which the payload is told; one sound at a random azimuth, 2.5 m away and as high as the array, and sensor noise
15 dB below it. A stepper turns the array, and its shaft is off by up to 5 % of a full step, differently at each of
them, which does not add up, as the makers of motors state it. The sound is noise, as a phone plays it, or a recorded
talker.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, product
from pathlib import Path
from typing import Any

import click
import numpy as np

import ross_payload
import ross_sim.study
from ross_payload.angles import wrap
from ross_payload.atomic_files import replacing
from ross_payload.calibration.estimate import Calibration, NotCalibrated, calibrate
from ross_payload.config import validated
from ross_payload.doctor.calibration_session import Stopped, TurnPlan
from ross_payload.errors import ConfigError, OutputError, refused_as, unknown
from ross_payload.interfaces import Real, Samples
from ross_sim.scenario import Scenario
from ross_sim.sitl.calibration_flight import turned_in
from ross_sim.study.rows.calibration_rows import CalibrationRow, calibrations
from ross_sim.study.rows.row_files import as_csv, read_rows
from ross_sim.study.runs.missions_run import CODE as MISSIONS
from ross_sim.study.runs.row_manifest import alone_with, claim
from ross_sim.study.runs.study_store import Code, basis_of
from ross_sim.study.runs.talker_placement import heard_as
from ross_sim.study.scenes.room_settings import SETTINGS, check_rooms
from ross_sim.talkers.speech import TalkerVoice
from ross_sim.talkers.synthetic_voices import voices_of

RATE = 16000  # [Hz]
PLAN = TurnPlan()  # as `ross calibrate` turns
NOISE, TALKER = "noise", "talker"
SPACING_M = (0.03, 0.1)
GAIN_DB, OFFSET_DEG = 3.0, 40.0  # to either side at most
ROLL_OFF_HZ = (20.0, 80.0)  # of each microphone
SNR_DB = 15.0
SECONDS = 60.0  # of sound
SOFTEST_HZ, LOUDEST_HZ = 300.0, 1000.0  # a phone's loudspeaker: nothing below the one, pink above the other
STEP_ERROR = 0.05 * math.radians(1.8)  # of a NEMA 17 at most [rad]
FULL_STEPS = 200
CODE: Code = MISSIONS | {  # behind the rows
    ross_payload: (*MISSIONS[ross_payload], "doctor/calibration_session.py"),
    ross_sim.study: (*MISSIONS[ross_sim.study], "rows/calibration_rows.py", "calibration_study.py"),
}


@dataclass(frozen=True, slots=True)
class Draw:
    """One array, one sound, one room."""

    setting: str
    sound: str
    number: int
    seed: int
    azimuth: float  # of the sound [rad]
    spacing: float  # [m]
    offset_deg: float
    gain_db: float  # of microphone 2
    inverted: bool
    swapped: bool
    roll_off_hz: tuple[float, float]  # of microphones 1 and 2

    @property
    def higher(self) -> float:
        """By how much microphone 2 rolls off above microphone 1 [Hz]."""
        return self.roll_off_hz[1] - self.roll_off_hz[0]


class StepErrors:
    """The error of a stepper's shaft at every angle: one value per full step, linear between them.

    >>> errors = StepErrors(np.random.default_rng(0))
    >>> abs(errors(0.3)) <= STEP_ERROR, errors(0.3) == errors(0.3 + 2 * math.pi)
    (True, True)
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._table = rng.uniform(-STEP_ERROR, STEP_ERROR, FULL_STEPS)

    def __call__(self, angle: float) -> float:
        """Return the error at an angle [rad]."""
        place = round(angle * FULL_STEPS / (2 * math.pi) % FULL_STEPS, 9)
        left = int(place) % FULL_STEPS
        here, there = self._table[left], self._table[(left + 1) % FULL_STEPS]
        return float(here + (place - int(place)) * (there - here))


def drawn(setting: str, sound: str, number: int, seed: int) -> Draw:
    """Draw one array; the same numbers give the same array."""
    rng = np.random.default_rng([seed, number, sorted(SETTINGS).index(setting), sound == TALKER])
    return Draw(
        setting, sound, number, seed,
        azimuth=float(rng.uniform(-math.pi, math.pi)), spacing=float(rng.uniform(*SPACING_M)),
        offset_deg=float(rng.uniform(-OFFSET_DEG, OFFSET_DEG)), gain_db=float(rng.uniform(-GAIN_DB, GAIN_DB)),
        inverted=bool(rng.random() < 0.5), swapped=bool(rng.random() < 0.25),
        roll_off_hz=(float(rng.uniform(*ROLL_OFF_HZ)), float(rng.uniform(*ROLL_OFF_HZ))),
    )  # fmt: skip


def scenario_of(draw: Draw) -> Scenario:
    """The room of a draw, with a payload that is told nothing about its array."""
    room = SETTINGS[draw.setting]
    values: dict[str, Any] = {
        "title": "calibration",
        "payload": {"seed": draw.seed + draw.number, "explore": {"lead_in_s": 0}, "actuator": {"kind": "tb6600"}},
        "room": {"size_m": room.size, "t60_s": room.t60, "array_m": room.centre},
        "noise": {"snr_db": SNR_DB},
        "microphones": {
            "spacing_m": draw.spacing, "offset_deg": draw.offset_deg, "gain_db": (0.0, draw.gain_db),
            "invert": (False, draw.inverted), "swapped": draw.swapped,
            "roll_off_hz": draw.roll_off_hz,
        },
        "talkers": [{"azimuth_deg": math.degrees(draw.azimuth), "start_s": 0.0}
                    | ({} if room.flat else {"height_m": room.centre[2]})],
    }  # fmt: skip
    return validated(Scenario, values, "calibration")


def phone_noise(rng: np.random.Generator) -> Samples:
    """Noise as a phone plays it: nothing below 300 Hz, white to 1 kHz, pink above, (n,)."""
    n = round(SECONDS * RATE)
    frequencies = np.fft.rfftfreq(n, 1 / RATE)
    strength = (frequencies >= SOFTEST_HZ) / np.sqrt(np.maximum(frequencies / LOUDEST_HZ, 1.0))
    noise: Real = np.fft.irfft(strength * np.exp(2j * np.pi * rng.random(frequencies.size)), n)
    return np.asarray(noise / np.sqrt(np.mean(noise**2)), dtype=np.float32)


def measured(draw: Draw, talkers: Sequence[TalkerVoice]) -> CalibrationRow:
    """Calibrate one array.

    Raises
    ------
    KeyboardInterrupt
        When a signal has stopped the turn, as it would anywhere else.
    """
    rng = np.random.default_rng([draw.seed, draw.number])
    if draw.sound == NOISE:
        noise = phone_noise(rng)
        voice = TalkerVoice("phone", noise, noise[: 5 * RATE], RATE)
    else:
        voice = talkers[draw.number % len(talkers)]
    scenario = scenario_of(draw)
    try:
        heard, world = turned_in(scenario, [voice], PLAN, shaft=StepErrors(rng))
    except Stopped as stopped:
        raise KeyboardInterrupt from stopped
    speed = scenario.payload.array.speed_of_sound_m_s
    try:
        return _row(draw, calibrate(heard, speed, azimuth=draw.azimuth), world.clock.now())
    except NotCalibrated as error:
        return _row(draw, str(error), world.clock.now())


def conduct(
    *, out: Path, speech: Path | None, settings: Sequence[str], sounds: Sequence[str], draws: int, seed: int
) -> int:
    """Calibrate, write the rows after every array and show the table; return the exit code.

    A study that was stopped goes on with the array that is next.

    Raises
    ------
    ConfigError
        When a name is unknown, the voices cannot be read, or ``out`` holds something else.
    OutputError
        When the rows cannot be written.
    """
    check_rooms(settings)
    for name in sounds:
        if name not in (NOISE, TALKER):
            raise ConfigError(unknown("sound", name, (NOISE, TALKER)))
    talkers = voices_of(speech, RATE)
    asked = {"settings": settings, "sounds": sounds, "draws": draws, "seed": seed}
    with alone_with(out):
        claim(out, {"asked": asked} | basis_of(heard_as(talkers), CODE))
        made: list[CalibrationRow] = read_rows(out, [CalibrationRow])[1] if out.exists() else []
        for row in rows(settings, sounds, draws, seed, talkers, done=len(made)):
            made.append(row)
            said = row.refused or f"spacing {row.spacing_error_mm:+.2f} mm, offset {row.offset_error_deg:+.2f} deg"
            click.echo(f"{row.setting} {row.sound} {row.draw}: {said}", err=True)
            with refused_as(OutputError, f"{out}: cannot be written"), replacing(out) as part:
                part.write_bytes(as_csv(made, CalibrationRow))
    click.echo(calibrations(made).body())
    return 0


def rows(
    settings: Sequence[str],
    sounds: Sequence[str],
    draws: int,
    seed: int,
    talkers: Sequence[TalkerVoice],
    *,
    done: int = 0,
) -> Iterator[CalibrationRow]:
    """Calibrate every draw of every setting and sound, but for those that are ``done``."""
    for setting, sound, number in islice(product(settings, sounds, range(draws)), done, None):
        yield measured(drawn(setting, sound, number, seed), talkers)


def _row(draw: Draw, found: Calibration | str, seconds: float) -> CalibrationRow:
    told = {
        "setting": draw.setting, "sound": draw.sound, "draw": draw.number, "seed": draw.seed,
        "spacing_mm": round(1e3 * draw.spacing, 3), "offset_deg": round(draw.offset_deg, 3),
        "gain_db": round(draw.gain_db, 3), "roll_off_hz": round(draw.higher, 3), "turn_s": round(seconds, 2),
    }  # fmt: skip
    if isinstance(found, str):
        none = dict.fromkeys(
            ("spacing_error_mm", "spacing_sigma_mm", "offset_error_deg", "offset_sigma_deg", "gain_error_db",
             "gain_sigma_db", "roll_off_error_hz", "roll_off_sigma_hz", "direct")
        )  # fmt: skip
        return CalibrationRow(**told, **none, polarity_right=False, swap_right=False, refused=found)  # type: ignore[arg-type]
    gain, higher = (-draw.gain_db, -draw.higher) if draw.swapped else (draw.gain_db, draw.higher)
    offset = wrap((found.offset or 0.0) - math.radians(draw.offset_deg))
    return CalibrationRow(
        **told,  # type: ignore[arg-type]
        spacing_error_mm=_round(1e3 * (found.spacing - draw.spacing)),
        spacing_sigma_mm=_round(1e3 * found.spacing_sigma),
        offset_error_deg=_round(math.degrees(offset)),
        offset_sigma_deg=_round(math.degrees(found.azimuth_sigma)),
        gain_error_db=_round(found.gain_db - gain),
        gain_sigma_db=_round(found.gain_sigma_db),
        roll_off_error_hz=None if found.roll_off is None else _round(found.roll_off - higher),
        roll_off_sigma_hz=None if found.roll_off_sigma is None else _round(found.roll_off_sigma),
        polarity_right=found.inverted == draw.inverted,
        swap_right=found.swapped == draw.swapped,
        direct=_round(found.direct),
        refused="",
    )


def _round(value: float) -> float:
    return round(value, 4)
