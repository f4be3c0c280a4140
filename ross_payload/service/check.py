"""What `ross run` asks of a configuration before it opens anything; `ross config check` asks the same and no more.

Nothing here touches a device, a bus or a network: these may come later. Files that the configuration names must be
there: a recording to play, the keys of links, the voice print of the target.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NoReturn, TypeVar

from ross_payload import config as settings
from ross_payload.actuators.registry import checked_options, open_actuator
from ross_payload.actuators.wires import check_wire
from ross_payload.audio.open_source import open_source
from ross_payload.clock import SystemClock
from ross_payload.config import Config
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Services
from ross_payload.listening.observers import check_listening
from ross_payload.named_paths import expanded
from ross_payload.service.assemble import explorer_of, tools_of
from ross_payload.service.dronecan_node import check_one_id
from ross_payload.service.state_folder import check_state_folder, recording_path
from ross_payload.transport.link_url import parse
from ross_payload.transport.signing import read_key
from ross_payload.voiceprint import VoiceStore
from ross_payload.voiceprint.model_folder import ModelFolder
from ross_payload.voiceprint.store import Damaged

T = TypeVar("T")

LINKS = "mavlink:"  # the port of a driver that shares the links
SCENARIO = "talkers"  # a key that only scenarios of the simulator have


def loaded(path: Path) -> Config:
    """Load the TOML file of a payload that can be run.

    Raises
    ------
    RossError
        With one line that names the file, the table and the key.
    """
    values = settings.read_toml(path)
    if SCENARIO in values:
        raise ConfigError(f"{path}: expected a payload, got a scenario of the simulator: ross sitl --scenario {path}")
    config = settings.validated(Config, values, str(path))
    try:
        check(config)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error
    return config


def check(config: Config) -> None:
    """Refuse what cannot be run.

    Raises
    ------
    RossError
        With one line that names the table and the key, what was expected and what was got.
    """
    _check_links(config)
    _check_audio(config)
    name, store = config.service.target, VoiceStore.default()
    if config.service.autostart == "seek" and not name:
        raise ConfigError("service.target: expected the name of an enrolled voice for autostart = 'seek', got none")
    model = _at("voice_print.model", partial(ModelFolder.default().in_use, config.voice_print.model))
    if name:
        _check_target(store, name)
        with suppress(Damaged):  # it is set aside when the payload starts
            _at("service.target", partial(store.load, name, model))
    check_state_folder(config)
    recording_path(config)
    checked_options(config)
    check_one_id(config)
    for key, port in _ports(config):
        _at(key, partial(check_wire, port))
    open_actuator(config, Services(SystemClock(), _refused))  # it is not entered, so its wire stays closed
    tools_of(config, None)
    check_listening(config)


def check_settable(config: Config) -> None:
    """Refuse what parameters can ask for, but not of this explorer or actuator: to explore without a pause.

    Raises
    ------
    ConfigError
        With one line that names the key, what was expected and what was got.
    """
    if config.explore.continuous:
        explorer_of(config)
        open_actuator(config, Services(SystemClock(), _refused))  # it is not entered, so its wire stays closed


def _check_links(config: Config) -> None:
    for number, link in enumerate(config.links):
        _at(f"links.{number}.url", partial(parse, link.url))
        if link.key_file:
            _at(f"links.{number}", partial(_read_key, link.key_file))
    urls = [link.url for link in config.links]
    for number, url in enumerate(urls):
        if url in urls[:number]:
            raise ConfigError(f"links.{number}.url: expected each URL once, got '{url}' twice")
    roles = {link.role for link in config.links}
    for key, value, needs in (
        ("mount.source", config.mount.source, "autopilot"),
        ("gimbal.mode", config.gimbal.mode, "device"),
        ("telemetry.system_id", config.telemetry.system_id, 0),  # without one nothing is ever sent
    ):
        if value == needs and "autopilot" not in roles and (roles or needs):
            raise ConfigError(f"{key} = {value!r}: expected a link of role 'autopilot', got none")
    if config.actuator.kind == "mavlink_gimbal" and not config.links:
        raise ConfigError("actuator.kind = 'mavlink_gimbal': expected [[links]] as the way to it, got none")
    if config.actuator.kind == settings.VEHICLE_YAW and "autopilot" not in roles:
        raise ConfigError(f"actuator.kind = '{settings.VEHICLE_YAW}': expected a link of role 'autopilot', got none")


def _check_audio(config: Config) -> None:
    source = open_source(config, SystemClock())
    if config.audio.source.startswith("file:"):
        with source:
            return


def _ports(config: Config) -> Iterator[tuple[str, str]]:
    port = getattr(checked_options(config), "port", "")
    if port and not port.startswith(LINKS):
        yield "actuator.options.port", port
    if config.dronecan.port:
        yield "dronecan.port", config.dronecan.port


def _at(key: str, call: Callable[[], T]) -> T:
    """Name the key whose value is refused."""
    try:
        return call()
    except ConfigError as error:
        raise type(error)(f"{key}: {error}") from error


def _check_target(store: VoiceStore, name: str) -> None:
    _at("service.target", partial(store.path, name))
    try:
        store.check(name)
    except ConfigError as error:
        raise ConfigError(f"service.target: {error}; `ross enroll {name} FILE.wav` enrols it") from error


def _read_key(named: str) -> bytes:
    return read_key(expanded(named))


def _refused(url: str) -> NoReturn:
    raise ConfigError(f"{url}: a driver that opens its wire in open() cannot be checked")
