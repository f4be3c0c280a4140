"""What simulated missions share."""

from mission_fixtures import fly, free_port, ground_station, process, run, short, undrawn  # noqa: F401
