"""A NEMA 17 and what it turns: inertia, a magnetic spring that gives way, friction.

The rotor is pulled towards the electrical angle of the windings by a torque that is a sine of its lag, one period per
tooth: ``J w' = T(w) sin(teeth (electrical - angle)) - friction``. Beyond two full steps of lag the spring pulls the
other way and the rotor falls into the next period, four full steps off. The torque falls with speed as the windings'
inductance and back-EMF take the current away: ``T(w) = holding / sqrt(1 + (w / corner)^2)``.

Simplifications: friction is viscous plus a Coulomb part that fades below 0.05 rad/s, so the rotor at rest ends exactly
on its electrical angle; the detent acts only without current.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ross_payload.interfaces import Real

FADE = 0.05  # speed over which Coulomb friction fades in [rad/s]
STILL = 1e-6  # lag and lag-equivalent speed below which the rotor snaps to rest [rad]


@dataclass(frozen=True, slots=True)
class Motor:
    """A 42 mm hybrid motor with a light turntable, seen at the shaft."""

    teeth: int = 50  # of the rotor; four full steps each
    rotor_inertia: float = 5.4e-6  # [kg m^2]
    load_inertia: float = 1.5e-4  # a disc of 150 g, 9 cm across, at the shaft [kg m^2]
    holding_torque: float = 0.4  # at zero speed [N m]
    corner_speed: float = 30.0  # where the torque has fallen to 71 % [rad/s]
    detent_torque: float = 0.015  # without current [N m]
    viscous: float = 8e-3  # bearing, grease and eddy currents [N m s]
    coulomb: float = 0.01  # [N m]

    @property
    def inertia(self) -> float:
        """Rotor and load together [kg m^2]."""
        return self.rotor_inertia + self.load_inertia

    @property
    def natural(self) -> float:
        """Angular frequency of small swings about the electrical angle [rad/s].

        >>> round(Motor(rotor_inertia=0.0, load_inertia=2e-4, holding_torque=0.4).natural)
        316
        """
        return math.sqrt(self.teeth * self.holding_torque / self.inertia)


class Rotor:
    """The mechanics: integrates the lag of one motor behind its windings.

    Semi-implicit Euler, implicit in the friction, with a step of at most a tenth of a radian of the natural frequency
    and 0.5 ms. At rest it costs nothing.
    """

    def __init__(self, motor: Motor) -> None:
        self._motor = motor
        self._longest = min(0.5e-3, 0.1 / motor.natural)
        self._electrical = 0.0
        self._energised = True
        self._rested = False
        self._blocked, self._current = False, True
        self.angle = 0.0  # of the shaft [rad]
        self.speed = 0.0  # [rad/s]
        self.worst_lag = 0.0  # [rad]

    def live(self, duration: float, times: Real, electrical: Real, energised: bool) -> None:
        """Follow the windings for ``duration`` [s].

        Parameters
        ----------
        times : array, (n,)
            When the electrical angle changes, since the start [s].
        electrical : array, (n + 1,)
            The electrical angle before the first change and after each [rad].
        energised : bool
            Whether there is current during the whole stretch.
        """
        energised = energised and self._current
        if not len(times) and self._at_rest(float(electrical[0]), energised):
            return
        self._energised = energised
        if self._blocked:
            self.speed, self._electrical = 0.0, float(electrical[-1])
            return
        n = max(math.ceil(duration / self._longest - 1e-9), 1)
        dt = duration / n
        fields = electrical[np.searchsorted(times, (np.arange(n) + 1) * dt, side="right")]
        self._integrate(dt, fields.tolist())
        self._electrical = float(electrical[-1])
        self._snap()

    def suffer(self, *, blocked: bool, current: bool) -> None:
        """Block the bearing, or take away the current whatever the module says, from now on."""
        self._blocked, self._current = blocked, current
        self._rested = False

    @property
    def still(self) -> bool:
        """Whether it stays where it is until the windings change."""
        return self._rested

    def periods_at(self, electrical: float) -> int:
        """Whole periods (four full steps each) from the windings at ``electrical`` [rad] to the shaft; < 0: behind."""
        return round((self.angle - electrical) * self._motor.teeth / (2 * math.pi))

    @property
    def periods_lost(self) -> int:
        """Whole periods from the windings to the shaft; negative when it fell behind."""
        return self.periods_at(self._electrical)

    def _integrate(self, dt: float, fields: list[float]) -> None:
        """Advance by one step of ``dt`` [s] per electrical angle [rad]; a hot loop, so everything is local."""
        motor, sin, hypot, tanh = self._motor, math.sin, math.hypot, math.tanh
        holding, corner, inertia = motor.holding_torque, motor.corner_speed, motor.inertia
        viscous, coulomb, detent = motor.viscous, motor.coulomb, motor.detent_torque
        teeth, energised = motor.teeth, self._energised
        angle, speed, worst = self.angle, self.speed, self.worst_lag
        for field in fields:
            if energised:
                lag = field - angle
                torque = holding / hypot(1.0, speed / corner) * sin(teeth * lag)
                if not -worst <= lag <= worst:
                    worst = abs(lag)
            else:
                torque = -detent * sin(4 * teeth * angle)
            moves = speed > 1e-9 or speed < -1e-9
            drag = viscous + coulomb * (tanh(speed / FADE) / speed if moves else 1 / FADE)
            speed = (speed + dt * torque / inertia) / (1 + dt * drag / inertia)
            angle += dt * speed
        self.angle, self.speed, self.worst_lag = angle, speed, worst

    def _at_rest(self, electrical: float, energised: bool) -> bool:
        return self._rested and electrical == self._electrical and energised == self._energised

    def _snap(self) -> None:
        """Put a rotor that has come to rest exactly there."""
        teeth = self._motor.teeth
        period = 2 * math.pi / teeth if self._energised else math.pi / (2 * teeth)
        centre = self._electrical if self._energised else 0.0
        rest = centre + round((self.angle - centre) / period) * period
        self._rested = abs(self.angle - rest) < STILL and abs(self.speed) < STILL * self._motor.natural
        if self._rested:
            self.angle, self.speed = rest, 0.0
