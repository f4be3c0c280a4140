"""Everything that can go wrong, as one tree.

::

    RossError
    ├── ConfigError          a file, an option or an argument is wrong: exit code 2
    │   └── PluginError      a plug-in is unknown, broken, or lacks an extra
    │       └── NotLive      a separator cannot separate frame by frame
    ├── AudioError           no audio, or audio that cannot be used: exit code 2
    │   └── AudioEnded       a recording has been played to its end: no fault
    ├── ActuatorError        the thing that turns: exit code 1
    │   ├── ActuatorFault    it reports a fault, or the guard does
    │   ├── LimitError       a goal outside the limits
    │   └── NotHomed         an absolute move before the position is known
    ├── LinkError            a port that cannot be opened: exit code 2
    └── OutputError          results cannot be written any more: exit code 1
"""

import errno
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches

SHOWN = 80  # characters of a value in a message
PLUGIN_RAISES = (Exception, SystemExit)  # by code of others: neither ends the program, nor keeps a stop from it
UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG)  # what a disk says that takes no more


def shown(value: object) -> str:
    """Return a value as it stands in a message, cut where it is long.

    >>> shown("x" * 5000)[-6:]
    "xx...'"
    """
    text = value if isinstance(value, str) else repr(value)
    short = text if len(text) <= SHOWN else text[: SHOWN - 3] + "..."
    return f"'{short}'" if isinstance(value, str) else short


def near(name: str, names: Iterable[str]) -> str:
    """Return the name that may have been meant, as the end of a message; nothing when none is near.

    >>> near("spacng_m", ["spacing_m", "offset_deg"])
    "; did you mean 'spacing_m'?"
    """
    lower = {each.lower(): each for each in names}
    found = get_close_matches(name[:SHOWN].lower(), lower, n=1)
    return f"; did you mean '{lower[found[0]]}'?" if found else ""


def unknown(kind: str, name: str, names: Iterable[str]) -> str:
    """Say that there is no such thing, what there is, and what may have been meant.

    >>> unknown("scenario", "dmo", ["demo", "tour"])
    "scenario 'dmo' is unknown; there are: demo, tour; did you mean 'demo'?"
    """
    known = list(names)
    return f"{kind} {shown(name)} is unknown; there are: {', '.join(known) or 'none'}{near(name, known)}"


class RossError(Exception):
    """The root: one clear line for the user."""


class ConfigError(RossError):
    """A file, an option or an argument is wrong; says what was expected and what was got."""


class PluginError(ConfigError):
    """A plug-in is unknown, broken, or lacks an extra."""


class NotLive(PluginError):
    """A separator cannot separate frame by frame."""


class AudioError(RossError):
    """No audio, or audio that cannot be used."""


class AudioEnded(AudioError):
    """A recording has been played to its end."""


class ActuatorError(RossError):
    """The thing that turns."""


class ActuatorFault(ActuatorError):
    """The actuator or its guard reports a fault."""


class LimitError(ActuatorError):
    """A goal outside the limits."""


class NotHomed(ActuatorError):
    """An absolute move was asked for before the position is known."""


class LinkError(RossError):
    """A port that cannot be opened."""


class OutputError(RossError):
    """Results cannot be written any more: the disk is full or gone."""


class TimeStandsStill(RuntimeError):
    """A clock does not move on, so that nothing that waits for it ends: a defect, for which nobody's input stands."""


def unkept(what: str, error: OSError) -> RossError:
    """Return the error of a file that cannot be kept: `OutputError` where the disk takes no more, else `ConfigError`.

    >>> unkept("ann.json: cannot be written", OSError(28, "No space left on device"))
    OutputError('ann.json: cannot be written: No space left on device')
    """
    kind = OutputError if error.errno in UNWRITABLE else ConfigError
    return kind(f"{what}: {reason(error)}")


def reason(error: Exception) -> str:
    """Return what is wrong, in the system's words where it has some.

    >>> reason(ConnectionRefusedError(111, "Connect call failed ('127.0.0.1', 5760)"))
    'Connection refused'
    """
    if isinstance(error, OSError) and error.errno and error.errno > 0:
        return os.strerror(error.errno)
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


@contextmanager
def refused_as(kind: type[Exception], what: str) -> Iterator[None]:
    """Let what the system refuses, an OSError, become an error of ours: ``what``, and why.

    >>> with refused_as(ConfigError, "config.toml: cannot be read"):
    ...     raise OSError(13, "Permission denied")
    Traceback (most recent call last):
    ross_payload.errors.ConfigError: config.toml: cannot be read: Permission denied
    """
    try:
        yield
    except OSError as error:
        raise kind(f"{what}: {reason(error)}") from error
