"""What may change in flight: names, bounds and meanings, and the pure change of a configuration.

Wiring and safety ([audio], [array], [actuator], [guard], [links]) are not in the table: they belong to the file.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ross_payload.config import Config, validated
from ross_payload.errors import ConfigError, unknown


@dataclass(frozen=True, slots=True)
class Parameter:
    """One setting that may change in flight."""

    name: str  # at most 16 characters
    key: str  # of the configuration: table.key
    lower: float
    upper: float
    unit: str  # "" for a plain number
    about: str
    whole: bool = False  # an integer; between 0 and 1 it is a switch

    @property
    def place(self) -> tuple[str, str]:
        """The table and the key."""
        table, key = self.key.split(".")
        return table, key

    def checked(self, value: float) -> float:
        """Return the value when it is allowed.

        Raises
        ------
        ConfigError
            When it is not a number, out of bounds, or not whole where a whole number is expected.
        """
        whole = "a whole number from" if self.whole else "a number from"
        expected = f"{whole} {self.lower:g} to {self.upper:g} {self.unit}".rstrip()
        if not math.isfinite(value) or not self.lower <= value <= self.upper or (self.whole and value % 1):
            raise ConfigError(f"{self.name}: expected {expected}, got {value:g}")
        return float(value)


def _table(*rows: Parameter) -> dict[str, Parameter]:
    return {row.name: row for row in rows}


TABLE = _table(
    Parameter("EXP_LEAD_IN", "explore.lead_in_s", 0, 60, "s", "Listening time before the first turn (noise)."),
    Parameter("EXP_UNIT", "explore.unit_s", 0.5, 60, "s", "Listening time at one orientation (T_unit)."),
    Parameter("EXP_STEP", "explore.step_deg", 1, 90, "deg", "One rotation of the exploration."),
    Parameter("EXP_MIN_ROT", "explore.min_rotations", 1, 24, "", "Minimum number of rotations.", whole=True),
    Parameter("EXP_MAX_ROT", "explore.max_rotations", 1, 24, "", "Maximum number of rotations.", whole=True),
    Parameter("EXP_PIPELINED", "explore.pipelined", 0, 1, "", "1: visit promising headings early.", whole=True),
    Parameter("EXP_CONTINUOUS", "explore.continuous", 0, 1, "", "1: turn without a pause.", whole=True),
    Parameter("EXP_RATE", "explore.rate_deg_s", 5, 90, "deg/s", "How fast it turns without a pause."),
    Parameter("EXP_TURN", "explore.turn_deg", 90, 3600, "deg", "How far at most, back and forth."),
    Parameter("XPL_CHECK", "exploit.check_s", 0.5, 60, "s", "Listening time at a candidate (T_check)."),
    Parameter("XPL_RUN", "exploit.run_s", 1, 600, "s", "Listening time of one delivered voice (T_run)."),
    Parameter("XPL_RUNS", "exploit.runs", 0, 10000, "", "Number of T_run; 0: until stopped.", whole=True),
    Parameter("XPL_CRITERION", "exploit.criterion", -50, 50, "", "A voice above this score is the target."),
    Parameter("XPL_RESTARTS", "exploit.max_restarts", 0, 100, "", "Restarts after the target is lost.", whole=True),
    Parameter("MNT_FOLLOW", "mount.follow_deg", 0.1, 45, "deg", "Turn when the heading error exceeds this."),
    Parameter("TLM_STATUS_HZ", "telemetry.status_hz", 0.1, 50, "Hz", "Rate of ROSS_STATUS."),
    Parameter("TLM_MIRROR_HZ", "telemetry.mirror_hz", 0, 10, "Hz", "Rate of NAMED_VALUE_FLOAT; 0: never."),
)  # by name, in the order of their indices on the wire


def named(name: str) -> Parameter:
    """Return the parameter of a name.

    Raises
    ------
    ConfigError
        When there is none.
    """
    if name not in TABLE:
        raise ConfigError(unknown("parameter", name, TABLE))
    return TABLE[name]


def value_of(config: Config, name: str) -> float:
    """Return what a configuration says about a parameter, as a number.

    >>> value_of(Config(), "EXP_UNIT"), value_of(Config(), "EXP_PIPELINED")
    (3.0, 0.0)
    """
    table, key = named(name).place
    return float(getattr(getattr(config, table), key))


def changed(config: Config, name: str, value: float) -> Config:
    """Return the configuration with one parameter changed.

    >>> changed(Config(), "EXP_UNIT", 2.5).explore.unit_s
    2.5

    Raises
    ------
    ConfigError
        When there is no such parameter, or the value is not allowed, or not together with the others.
    """
    parameter = named(name)
    table, key = parameter.place
    old = getattr(config, table)
    said = {field: getattr(old, field) for field in old.model_fields_set}
    new = validated(type(old), said | {key: parameter.checked(value)}, name)
    whole = {field: getattr(config, field) for field in config.model_fields_set}
    return validated(type(config), whole | {table: new}, name)
