"""The configuration in force: what the file says and what was set in flight."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from enum import StrEnum
from pathlib import Path

from ross_payload.bounded_files import set_aside
from ross_payload.config import Config
from ross_payload.config.parameter_persistence import StoredValue, Unusable, read, write
from ross_payload.config.parameter_table import TABLE, changed, named, value_of
from ross_payload.errors import ConfigError

log = logging.getLogger(__name__)


class Origin(StrEnum):
    """Where the value of a key comes from."""

    FILE = "file"
    DEFAULT = "default"
    IN_FLIGHT = "in flight"


Check = Callable[[Config], None]  # raises ConfigError where nothing can work as a configuration says


def any_serves(config: Config) -> None:
    """Refuse no configuration."""


class Parameters(AbstractContextManager["Parameters"]):
    """What is in force: the configuration with what was set in flight. A context manager.

    ``path`` is the file that outlives a restart, None: nothing does. It is written by a thread of its own, since a
    disk may take long; leaving the context waits for it. Everything else belongs to one thread.

    ``notes`` says what an operator should know about the file that was found; ``trouble`` why it cannot be written
    at present, empty when it can. ``check`` refuses what the table allows, and what else there is cannot do: a value
    that it refuses is not set, nor taken from the file.
    """

    def __init__(self, config: Config, path: Path | None = None, check: Check = any_serves) -> None:
        self._configured = config
        self._check = check
        self._path = path
        kept, problem = ({}, "") if path is None else _found(path)
        self.config, self._kept, notes = recall(config, kept, check)
        self.notes = tuple([problem, *notes] if problem else notes)
        self.trouble = ""
        self._written = kept
        self._writer = ThreadPoolExecutor(max_workers=1, thread_name_prefix="parameters")

    def value(self, name: str) -> float:
        """Return the value in force.

        Raises
        ------
        ConfigError
            When there is no such parameter.
        """
        return value_of(self.config, name)

    def origin(self, name: str) -> Origin:
        """Return where the value in force comes from.

        Raises
        ------
        ConfigError
            When there is no such parameter.
        """
        place = named(name).place
        return Origin.IN_FLIGHT if name in self._kept else origin_in(self._configured, *place)

    def configured(self, name: str) -> float:
        """Return what the file of the configuration says, or the default.

        Raises
        ------
        ConfigError
            When there is no such parameter.
        """
        return value_of(self._configured, name)

    def set(self, name: str, value: float) -> None:
        """Change a value; it is in force at once and soon in the file.

        Raises
        ------
        ConfigError
            When there is no such parameter, or the value is not allowed, or not together with the others.
        """
        self.config = _serving(self.config, name, value, self._check)
        entry = StoredValue(self.value(name), value_of(self._configured, name))
        others = {other: kept for other, kept in self._kept.items() if other != name}
        self._kept = others if entry.value == entry.replaced else others | {name: entry}
        if self._path is not None:
            try:
                self._writer.submit(self._write, self._path)
            except RuntimeError as error:  # the system has no thread left: it is in force, and written with the next
                self.trouble = f"{self._path}: cannot be written: {error}"
                log.warning(self.trouble)

    def _write(self, path: Path) -> None:
        latest = self._kept  # several changes while the disk was busy are written once
        if latest == self._written:
            return
        try:
            write(path, latest)
        except OSError as error:
            self.trouble = f"{path}: cannot be written: {error.strerror}"
            log.warning(self.trouble)
        else:
            self._written, self.trouble = latest, ""

    def close(self) -> None:
        """Wait until what was set is in the file; idempotent."""
        self._writer.shutdown()

    def __exit__(self, *exception: object) -> None:
        """Wait until what was set is in the file."""
        self.close()


def origin_in(config: Config, table: str, key: str) -> Origin:
    """Tell whether the file of a configuration says something about a key."""
    return Origin.FILE if key in getattr(config, table).model_fields_set else Origin.DEFAULT


def _serving(config: Config, name: str, value: float, check: Check) -> Config:
    """Return the configuration with one parameter changed, unless nothing can work as it says."""
    new = changed(config, name, value)
    try:
        check(new)
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error
    return new


def recall(
    config: Config, kept: Mapping[str, StoredValue], check: Check = any_serves
) -> tuple[Config, dict[str, StoredValue], list[str]]:
    """Return the configuration with what was set in flight, what of that holds, and what there is to tell.

    Where the file of the configuration says something else since, it wins.
    """
    held: dict[str, StoredValue] = {}
    notes = []
    for name, entry in kept.items():
        if name not in TABLE:
            notes.append(f"{name}: this version has no such parameter: discarded")
        elif (said := value_of(config, name)) == entry.replaced:
            held[name] = entry
        elif said != entry.value:
            notes.append(
                f"{name}: the configuration says {said:g}, no longer {entry.replaced:g}: {entry.value:g} is discarded"
            )
    config, refused = _together(config, {name: entry.value for name, entry in held.items()}, check)
    notes += [f"{reason}: discarded" for reason in refused.values()]
    return config, {name: entry for name, entry in held.items() if name not in refused}, notes


def _together(config: Config, values: Mapping[str, float], check: Check) -> tuple[Config, dict[str, str]]:
    """Change what can be changed, in an order in which it can; return why the rest cannot."""
    refused: dict[str, str] = {}
    for name, value in values.items():
        try:
            config = _serving(config, name, value, check)
        except ConfigError as error:
            refused[name] = str(error)
    if not refused or len(refused) == len(values):
        return config, refused
    return _together(config, {name: values[name] for name in refused}, check)


def _found(path: Path) -> tuple[dict[str, StoredValue], str]:
    """Read the file; one that cannot be used is put aside, and the reason returned."""
    try:
        return read(path), ""
    except Unusable as unusable:
        return {}, f"{unusable}; {set_aside(path, unusable.word)}"
