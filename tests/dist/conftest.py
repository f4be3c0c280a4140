"""What every test in this folder can ask for."""

from own_actuator import folder  # noqa: F401
