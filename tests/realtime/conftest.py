"""What simulated missions share."""

from mission_fixtures import fly, free_port, ground_station, process, run, short  # noqa: F401
from own_actuator import folder  # noqa: F401
from pulse_rig import noise  # noqa: F401
