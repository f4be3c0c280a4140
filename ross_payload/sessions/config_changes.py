"""Another configuration for a recorded mission: what may change, and what the record decides."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ross_payload.bounded_files import toml_value
from ross_payload.config import Config, load, validated
from ross_payload.errors import ConfigError

FIXED = (("audio", "rate_hz"), ("audio", "hop_ms"))  # the Inputs are cut so
RECORDED = (  # what was heard and where the array stood come from the record
    ("actuator",), ("links",), ("telemetry",), ("service",), ("recording",), ("listening",), ("array", "offset_deg"),
    ("mount", "source"), ("mount", "yaw_deg"), ("mount", "fresh_s"), ("guard", "max_speed_deg_s"),
    ("guard", "max_acceleration_deg_s2"), ("guard", "max_move_s"), ("guard", "watchdog_s"), ("guard", "on_fault"),
    ("audio", "source"), ("audio", "preset"), ("audio", "channels"), ("audio", "device_channels"),
    ("audio", "latency_ms"), ("audio", "buffer_s"),
)  # fmt: skip
Values = dict[str, Any]


def changed(recorded: Config, file: Path | None, settings: Sequence[str]) -> Config:
    """Return the recorded configuration, or that of a file, with single keys changed, ``exploit.run_s=5``.

    Raises
    ------
    ConfigError
        When a key or value is wrong, or the recorded Inputs do not fit.
    """
    base = recorded if file is None else load(file)
    values = base.model_dump(mode="json")
    for setting in settings:
        assign(values, setting)
    config = validated(Config, values, "--set") if settings else base
    for path in FIXED:
        was, wanted = _at(recorded, path), _at(config, path)
        if was != wanted:
            raise ConfigError(f"{'.'.join(path)}: expected {was}, as recorded, got {wanted}")
    return config


def without_effect(recorded: Config, config: Config) -> tuple[str, ...]:
    """Return the keys that differ and that the record decides.

    >>> without_effect(Config(), Config.model_validate({"array": {"offset_deg": 3}, "exploit": {"run_s": 5}}))
    ('array.offset_deg',)
    """
    return tuple(".".join(path) for path in RECORDED if _at(recorded, path) != _at(config, path))


def matters(differing: Iterable[str]) -> bool:
    """Whether any of some keys can change what the mission does with the record.

    >>> matters(["mount.yaw_deg", "array.offset_deg"]), matters(["exploit.run_s"])
    (False, True)
    """
    decided = tuple(".".join(path) for path in RECORDED)
    return any(not key.startswith(decided) for key in differing)


def differences(recorded: Config, config: Config) -> Values:
    """Return what differs, {key: [recorded, now]}, as plain values."""
    was, now = _flat(recorded.model_dump(mode="json")), _flat(config.model_dump(mode="json"))
    return {key: [was.get(key), now.get(key)] for key in sorted({*was, *now}) if was.get(key) != now.get(key)}


def assign(values: Values, setting: str) -> None:
    """Change one key of a configuration as plain values by ``table.key=value``, the value as in TOML or a word.

    Without a value the key is absent: what holds then is its default.

    >>> values = {"audio": {"frame": 1024}}
    >>> assign(values, "audio.frame="), values
    (None, {'audio': {}})

    Raises
    ------
    ConfigError
        When it is anything else.
    """
    key, equals, text = setting.partition("=")
    if not equals:
        raise ConfigError(f"--set: expected key=value, such as exploit.separator=duet, got '{setting}'")
    *tables, last = key.strip().split(".")
    for name in tables:
        if values.get(name) is None:
            values[name] = {}
        values = values[name]
        if not isinstance(values, dict):
            raise ConfigError(f"--set {setting}: expected a table, got the key '{name}'")
    if text.strip() or last not in values:  # of a key that there is not, even to be absent, the check tells
        values[last] = toml_value(text.strip())
    else:
        del values[last]


def _at(config: Config, path: Sequence[str]) -> Any:
    found: Any = config
    for name in path:
        found = getattr(found, name)
    return found


def _flat(values: Values, prefix: str = "") -> Values:
    found: Values = {}
    for name, value in values.items():
        if isinstance(value, dict) and value:
            found |= _flat(value, f"{prefix}{name}.")
        else:
            found[prefix + name] = value
    return found
