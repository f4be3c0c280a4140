"""Everything that can go wrong, as one tree.

::

    RossError
    ├── ConfigError          a file, an option or an argument is wrong: exit code 2
    │   └── PluginError      a plug-in is unknown, broken, or lacks an extra
    ├── AudioError           no audio, or audio that cannot be used: exit code 2
    │   └── AudioEnded       a recording has been played to its end: no fault
    ├── ActuatorError        the thing that turns: exit code 1
    │   ├── ActuatorFault    it reports a fault, or the guard does
    │   ├── LimitError       a goal outside the limits
    │   └── NotHomed         an absolute move before the position is known
    ├── LinkError            a port that cannot be opened: exit code 2
    └── OutputError          results cannot be written any more: exit code 1
"""


class RossError(Exception):
    """The root: one clear line for the user."""


class ConfigError(RossError):
    """A file, an option or an argument is wrong; says what was found and what was wanted."""


class PluginError(ConfigError):
    """A plug-in is unknown, broken, or lacks an extra."""


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
