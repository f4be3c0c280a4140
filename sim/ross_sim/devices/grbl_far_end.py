"""The far end of a serial line: a microcontroller with grbl 1.1, the driver of its motor, and the motor."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ross_payload.actuators.grbl.options import Options
from ross_payload.interfaces import Real
from ross_protocols.grbl.protocol import ACCELERATION, HOMING, IDLE_DELAY, MAX_RATE, STEPS, TRAVEL, State, per_degree
from ross_sim.devices.far_end import SLIP, Fault, WireEnd, checked
from ross_sim.devices.grbl_firmware import Firmware
from ross_sim.devices.grbl_planner import PIECE
from ross_sim.devices.stepper import Motor, Rotor

BYTES_PER_SECOND = 11520  # of a line at 115200 baud
NOISE = 0.03  # share of the bytes that arrive damaged on a noisy line
PULL_OFF = 1.0  # from the limit switch [deg]


class GrblFarEnd:
    """Lets the controller live in pieces of a millisecond and the motor follow its steps as well as it can.

    Parameters
    ----------
    options : Options
        How the driver believes motor and gear to be; they are.
    motor : Motor
        The motor and its load.
    settings : dict
        Of grbl, on top of those that fit the options.
    """

    faults = frozenset({Fault.STALL, Fault.STUCK, Fault.SLIP, Fault.SILENT, Fault.REBOOT, Fault.TAKEN, Fault.CORRUPT})

    def __init__(self, options: Options, motor: Motor, settings: dict[int, float]) -> None:
        self.port = WireEnd()
        self.rotor = Rotor(motor)
        self._options = options
        axes = "XYZABC"[: max(options.index + 1, 3)]
        self.firmware = Firmware(fitting(options) | settings, axes, options.axis, self._at_switch)
        self._now = 0.0
        self._windings = 0  # steps of the motor's driver since power-up
        self._credit = 0.0  # bytes that the line can carry by now
        self._suffering: set[Fault] = set()
        self._stranger: list[str] = []  # what somebody else wants next
        self._slipped = 0.0  # [rad]
        self._chance = np.random.default_rng(0)

    def advance(self, now: float) -> None:
        """Give the controller what was sent, let it and the motor live until ``now`` [s], deliver what it said."""
        for data in self.port.sent:
            self.firmware.on_bytes(data)
        self.port.sent.clear()
        n = round((now - self._now) / PIECE)
        duration = n * PIECE
        self._now += duration
        steps = [(0.0, self._windings)]
        if self.firmware.busy or self._stranger:
            steps += self._steps(n)
        self._turn(duration, *np.transpose(steps))
        self._deliver(duration)

    def angle(self) -> float:
        """Return the true joint angle [rad]."""
        return self.rotor.angle / self._options.gear_ratio + self._slipped

    def afflict(self, fault: Fault, on: bool = True) -> None:
        """Let a fault begin or end."""
        match checked(fault, self.faults), on:
            case Fault.SLIP, True:
                self._slipped += SLIP
            case Fault.REBOOT, True:
                self.firmware.boot()
            case Fault.TAKEN, True:
                back = -1 if self.firmware.forward else 1
                self._stranger = ["\x85", f"$J=G91G21{self._options.axis}{45 * back}F1800"]
            case _, True:
                self._suffering.add(fault)
            case _:
                self._suffering.discard(fault)

    def complaints(self) -> list[str]:
        """Return one line about steps lost."""
        lost = 4 * self.rotor.periods_lost
        return [f"steps lost: the shaft is {lost:+d} full steps off its windings"] if lost else []

    def _steps(self, n: int) -> list[tuple[float, int]]:
        """Let the controller live for so many pieces; times since then [s] and counts after each step."""
        steps: list[tuple[float, int]] = []
        for piece in range(n):
            self._interfere()
            before, after = self.firmware.tick()
            low, high = math.floor(before + 0.5), math.floor(after + 0.5)
            sign = 1 if high > low else -1
            for count in range(low, high, sign):
                self._windings += sign
                part = (count + sign / 2 - before) / (after - before)
                steps.append(((piece + part) * PIECE, self._windings))
        return steps

    def _turn(self, duration: float, times: Real, counts: Real) -> None:
        if Fault.STUCK in self._suffering:
            self.rotor.speed = 0.0
            return
        electrical = counts * (2 * math.pi / (self._options.full_steps * self._options.microsteps))
        energised = self.firmware.energised and Fault.STALL not in self._suffering
        self.rotor.live(duration, times[1:], electrical, energised)

    def _deliver(self, duration: float) -> None:
        """Let out what the line can carry by now."""
        out = self.firmware.out
        self._credit = self._credit + duration * BYTES_PER_SECOND if out else 0.0
        n = min(int(self._credit), len(out))
        data, out[:n] = bytes(out[:n]), b""
        self._credit -= n
        if data and Fault.SILENT not in self._suffering:
            self.port.arrived.append(self._damaged(data) if Fault.CORRUPT in self._suffering else data)

    def _damaged(self, data: bytes) -> bytes:
        struck = self._chance.random(len(data)) < NOISE
        other = self._chance.integers(1, 256, len(data), dtype=np.uint8)
        return (np.frombuffer(data, np.uint8) ^ np.where(struck, other, 0).astype(np.uint8)).tobytes()

    def _interfere(self) -> None:
        """Let somebody else cancel, and jog as soon as it is idle."""
        if self._stranger and self._stranger[0] == "\x85":
            self.firmware.on_bytes(b"\x85")
            self._stranger.pop(0)
        elif self._stranger and self.firmware.state is State.IDLE:
            self.firmware.obey(self._stranger.pop(0))

    def _at_switch(self) -> bool:
        """Whether the array stands at the limit switch, which lies a pull-off beyond home."""
        if self._options.zero != "switch":
            return False
        return self.angle() >= math.radians(self._options.home_deg + PULL_OFF)

    @classmethod
    def make(cls, config: Options, motor: Motor | None = None, settings: dict[int, float] | None = None) -> GrblFarEnd:
        """Make a controller set up as the driver's options say, at joint angle 0; a motor of its own may be heavier."""
        return cls(config, motor or replace(Motor(), teeth=config.full_steps // 4), settings or {})


def fitting(options: Options) -> dict[int, float]:
    """Return the settings of grbl that fit the driver's options."""
    return {
        IDLE_DELAY: 255,
        HOMING: int(options.zero == "switch"),
        24: 600.0,  # rates of homing [deg/min]
        25: 1800.0,
        27: PULL_OFF,
        STEPS + options.index: per_degree(options.resolution),
        MAX_RATE + options.index: options.max_speed_deg_s * 60,
        ACCELERATION + options.index: options.max_acceleration_deg_s2,
        TRAVEL + options.index: 400.0,
    }


far_end = GrblFarEnd
