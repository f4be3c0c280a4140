"""The table [vehicle] of a scenario: what carries the array, or is turned itself."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from ross_payload.config import VEHICLE_YAW, Config, Degrees, Table
from ross_sim.autopilot.yaw import Yaw
from ross_sim.autopilot.yaw_dynamics import Wind
from ross_sim.devices.far_end import FarEnd
from ross_sim.devices.vehicle_far_end import VehicleFarEnd

GUSTS = frozenset(("gust_deg_s2", "gust_s"))  # keys of a vehicle that is turned itself alone
LINK = frozenset(("latency_ms",))  # of any vehicle
Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Vehicle(Table):
    """[vehicle]: what carries the mount; it yaws, and an autopilot tells the payload over MAVLink.

    To and fro at ``rate_deg_s``, steadily at ``steady_deg_s``, here and there by ``drift_deg``, and as it vibrates:
    all of them add up.

    The room is that of a mount which points to ``yaw_deg``: azimuths of talkers count from there. A vehicle that is
    turned itself, with the actuator ``vehicle_yaw``, begins to the north; azimuths count from there, and only gusts and
    the latency of its link, each way, can be told of it.
    """

    yaw_deg: Degrees = 0.0  # the middle, clockwise from north as on a compass
    amplitude_deg: Annotated[float, Field(ge=0, le=180)] = 0.0  # to either side; 0: at rest
    rate_deg_s: Annotated[float, Field(gt=0, le=360)] = 10.0  # how fast it yaws to and fro
    steady_deg_s: Annotated[float, Field(ge=-360, le=360)] = 0.0  # yaws all the time, clockwise
    drift_deg: Annotated[float, Field(ge=0, le=45)] = 0.0  # wanders within 30 s, one standard deviation
    vibration_deg: Annotated[float, Field(ge=0, le=5)] = 0.0  # shakes to either side
    vibration_hz: Annotated[float, Field(gt=0, le=200)] = 12.0  # so often
    attitude_hz: Annotated[float, Field(gt=0, le=100)] = 25.0  # ATTITUDE
    latency_ms: Annotated[float, Field(ge=0, le=1000)] = 40.0  # of the link, at least
    jitter_ms: Annotated[float, Field(ge=0, le=1000)] = 20.0  # on top of it, at most
    rotor_messages: Literal["esc_telemetry", "esc_status", "rpm", "none"] = "esc_telemetry"  # that tell of made rotors
    silent: tuple[tuple[Seconds, Seconds], ...] = ()  # [[from, to], ...] when the autopilot says nothing
    gust_deg_s2: Annotated[float, Field(ge=0, le=1000)] = 0.0  # yaw that gusts of wind give, standard deviation
    gust_s: Annotated[float, Field(gt=0, le=60)] = 0.5  # how long a gust lasts: its correlation time

    def motion(self) -> Yaw:
        """Return how it yaws, in radians, counter-clockwise."""
        return Yaw(
            -math.radians(self.yaw_deg),
            math.radians(self.amplitude_deg),
            math.radians(self.rate_deg_s),
            steady=-math.radians(self.steady_deg_s),
            drift=math.radians(self.drift_deg),
            vibration=math.radians(self.vibration_deg),
            frequency=self.vibration_hz,
        )

    def check(self, payload: Config) -> None:
        """Refuse keys of a vehicle that carries a turntable where it is turned itself, and the other way round.

        Raises
        ------
        ValueError
            Which key.
        """
        turned = payload.actuator.kind == VEHICLE_YAW
        wrong = sorted(self.model_fields_set - GUSTS - LINK if turned else self.model_fields_set & GUSTS)
        if wrong:
            expected = ", ".join(sorted(GUSTS | LINK)) if turned else f"the actuator {VEHICLE_YAW} for it"
            raise ValueError(f"vehicle.{wrong[0]}: expected {expected}")

    def in_wind(self, far_end: FarEnd, seed: int) -> FarEnd:
        """Let gusts blow on a vehicle that is turned itself, behind its link; any other far end stays as it is."""
        if isinstance(far_end, VehicleFarEnd):
            wind = Wind(math.radians(self.gust_deg_s2), self.gust_s)
            far_end.delay(self.latency_ms / 1e3)
            far_end.blow(wind, np.random.Generator(np.random.PCG64(seed)))
        return far_end
