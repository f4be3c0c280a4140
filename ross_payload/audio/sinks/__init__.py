"""Where voices go: sinks are plug-ins, entry points in ``ross_payload.sinks``, built-ins included.

A plug-in is an object with ``Config``, a `Table` with its options, and ``open(config, services)``, which makes an
`AudioSink` that is not open yet. Options that mean the same in every sink have the same names: ``address``, ``port``
and ``codec``, which an order can tell, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from ross_payload import plugins
from ross_payload.config.table import Table, validated
from ross_payload.errors import PLUGIN_RAISES, PluginError, RossError
from ross_payload.interfaces import AudioSink, Clock
from ross_payload.plugin_calls import called

GROUP = "ross_payload.sinks"
SINK_METHODS = ("write", "__enter__", "__exit__")
SINK_VALUES = ("fault", "lost")


@dataclass(frozen=True, slots=True)
class SinkServices:
    """What a sink is given when it is made."""

    clock: Clock
    rate: int  # of the blocks [Hz]
    number: int  # of the stream
    title: str  # what is listened to, in words: for a file's title, a session's name
    folder: Path  # of files that are named without a folder; need not be there
    live: bool = True  # False: time is simulated, and a sink waits for the disk instead of losing anything
    min_free_gb: float = 0.0  # of the configuration: free space below which a sink writes no file


@dataclass(frozen=True, slots=True)
class SinkInfo:
    """What a sink tells of itself, for telemetry."""

    address: str = ""  # where the voice goes: a host, a path, a device
    port: int = 0
    codec: str = ""  # such as s24le, L16, opus, FLAC
    rate: int = 0  # of what goes out [Hz]; 0: that of the blocks
    listeners: int = 0  # that take it; 1 for a file or a device that is open
    packets_lost: int | None = None  # on the way, as who listens reports; None: not known
    unheard_s: float = 0.0  # for how long nobody has taken it, as far as it can tell
    sdp: str = ""  # session description (RFC 8866) for who wants to listen; empty: there is none


@runtime_checkable
class Informative(Protocol):
    """A sink that tells more than its fault and what it lost."""

    @property
    def info(self) -> SinkInfo:
        """What it is, at this moment; from any thread."""


class SinkPlugin(Protocol):
    """The object behind an entry point in ``ross_payload.sinks``."""

    Config: type[Table]  # of its options

    def open(self, config: Any, services: SinkServices) -> AudioSink:
        """Make the sink; nothing is opened before it is entered."""


@dataclass(frozen=True)
class BuiltInSink:
    """The plug-in of a sink that comes with the payload: ``make`` builds it from options of ``Config``."""

    Config: type[Table]
    make: Callable[[Any, SinkServices], AudioSink]

    def open(self, config: Any, services: SinkServices) -> AudioSink:
        """Make the sink; nothing is opened before it is entered."""
        return self.make(config, services)


def checked_options(kind: str, options: Mapping[str, Any], where: str) -> Table:
    """Return a sink's own ``Config`` from plain values; ``where`` names their table in messages.

    Raises
    ------
    ConfigError
        When the sink is unknown or broken, or an option is wrong.
    """
    return validated(load_sink(kind).Config, dict(options), where)


def make_sink(kind: str, config: Table, services: SinkServices) -> AudioSink:
    """Make a sink with options that were checked; enter it to open it.

    Raises
    ------
    PluginError
        When it is unknown or broken.
    """
    try:
        plugin = load_sink(kind)
        sink = called(f"sink '{kind}'", "open", lambda: plugin.open(config, services))
    except RossError:
        raise
    except PLUGIN_RAISES as error:  # of others: it may raise anything
        raise PluginError(f"sink '{kind}': open raised {type(error).__name__}: {error}") from error
    lacking = [name for name in SINK_METHODS if not callable(getattr(type(sink), name, None))]
    lacking += [name for name in SINK_VALUES if not hasattr(sink, name)]
    if lacking:
        raise PluginError(f"sink '{kind}': expected open() to return an AudioSink, got one without {lacking[0]}")
    return sink


def load_sink(kind: str) -> SinkPlugin:
    """Import one sink.

    Raises
    ------
    PluginError
        When there is none of that name, it cannot be imported, or it is no sink; says what was expected.
    """
    plugin = plugins.load(GROUP, kind)
    model = getattr(plugin, "Config", None)
    if not (isinstance(model, type) and issubclass(model, Table) and callable(getattr(plugin, "open", None))):
        raise PluginError(f"sink '{kind}': expected an object with Config, a Table, and open(config, services)")
    return plugin  # type: ignore[no-any-return]


def info_of(sink: AudioSink) -> SinkInfo:
    """Return what a sink tells of itself; nothing when it does not."""
    return sink.info if isinstance(sink, Informative) else SinkInfo()
