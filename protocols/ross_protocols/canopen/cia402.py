"""Drives by CiA 402: objects, the state machine, profile position and homing. No bus, no clock.

A drive tells its state in the statusword; `controlword` is the next step towards another.
"""

from __future__ import annotations

from enum import Enum, IntEnum

from ross_protocols.canopen.frames import Item

PROFILE = 402  # low half of the device type
DEVICE_TYPE = Item(0x1000, 0, "I")
CONSUMER_HEARTBEAT = Item(0x1016, 1, "I")
PRODUCER_HEARTBEAT = Item(0x1017, 0, "H")
VENDOR, PRODUCT, REVISION, SERIAL = (Item(0x1018, sub, "I") for sub in (1, 2, 3, 4))
ABORT_CONNECTION = Item(0x6007, 0, "h")
CONTROLWORD, STATUSWORD = Item(0x6040, 0, "H"), Item(0x6041, 0, "H")
QUICK_STOP_OPTION, HALT_OPTION = Item(0x605A, 0, "h"), Item(0x605D, 0, "h")
MODE, MODE_SHOWN = Item(0x6060, 0, "b"), Item(0x6061, 0, "b")
POSITION, VELOCITY = Item(0x6064, 0, "i"), Item(0x606C, 0, "i")
FOLLOWING_WINDOW, FOLLOWING_TIME = Item(0x6065, 0, "I"), Item(0x6066, 0, "H")
POSITION_WINDOW, POSITION_TIME = Item(0x6067, 0, "I"), Item(0x6068, 0, "H")
TARGET = Item(0x607A, 0, "i")
HOME_OFFSET = Item(0x607C, 0, "i")
LOWEST, HIGHEST = Item(0x607D, 1, "i"), Item(0x607D, 2, "i")
MAX_MOTOR_SPEED = Item(0x6080, 0, "I")  # [1/min]
PROFILE_VELOCITY = Item(0x6081, 0, "I")
PROFILE_ACCELERATION, PROFILE_DECELERATION = Item(0x6083, 0, "I"), Item(0x6084, 0, "I")
QUICK_STOP_DECELERATION = Item(0x6085, 0, "I")
HOMING_METHOD = Item(0x6098, 0, "b")
HOMING_FAST, HOMING_SLOW = Item(0x6099, 1, "I"), Item(0x6099, 2, "I")
HOMING_ACCELERATION = Item(0x609A, 0, "I")
SUPPORTED_MODES = Item(0x6502, 0, "I")

QUICK_STOP_ON_SILENCE = 3  # abort connection option: what a drive does when its master dies
QUICK_STOP_AND_OFF = 2  # quick stop option: along its ramp, then switch on disabled
SLOW_DOWN = 1  # halt option: along the ramp of the profile, then hold

# controlword
NEW_SET_POINT = START_HOMING = 0x10
AT_ONCE = 0x20  # a set-point replaces the one in flight
HALT = 0x100
ENABLED = 0x0F
FAULT_RESET = 0x80

# statusword
VOLTAGE, REMOTE, REACHED, LIMITED = 0x10, 0x200, 0x400, 0x800
ACKNOWLEDGED = ATTAINED = 0x1000  # profile position: the set-point is taken; homing: home is found
FOLLOWING_ERROR = HOMING_ERROR = 0x2000


class Mode(IntEnum):
    """Modes of operation that we use."""

    NONE = 0
    PROFILE_POSITION = 1
    HOMING = 6

    @property
    def bit(self) -> int:
        """Its bit in the supported modes.

        >>> Mode.PROFILE_POSITION.bit, Mode.HOMING.bit
        (1, 32)
        """
        return 1 << (self - 1)


class State(Enum):
    """States of a drive: mask and bits of the statusword."""

    NOT_READY = (0x4F, 0x00)
    SWITCH_ON_DISABLED = (0x4F, 0x40)
    READY_TO_SWITCH_ON = (0x6F, 0x21)
    SWITCHED_ON = (0x6F, 0x23)
    OPERATION_ENABLED = (0x6F, 0x27)
    QUICK_STOP_ACTIVE = (0x6F, 0x07)
    FAULT_REACTION = (0x4F, 0x0F)
    FAULT = (0x4F, 0x08)

    @property
    def words(self) -> str:
        """Its name.

        >>> State.SWITCH_ON_DISABLED.words
        'switch on disabled'
        """
        return self.name.lower().replace("_", " ")

    @property
    def bits(self) -> int:
        """Bits of the statusword."""
        return int(self.value[1])


def state_of(status: int) -> State | None:
    """Return the state that a statusword tells; None when it is none of them.

    >>> state_of(0x0237), state_of(0x0250), state_of(0x0001)
    (<State.OPERATION_ENABLED: (111, 39)>, <State.SWITCH_ON_DISABLED: (79, 64)>, None)
    """
    return next((state for state in State if status & state.value[0] == state.value[1]), None)


_TO_ENABLED = {
    State.SWITCH_ON_DISABLED: 0x06,  # shutdown
    State.READY_TO_SWITCH_ON: 0x07,  # switch on
    State.SWITCHED_ON: 0x0F,  # enable operation
    State.OPERATION_ENABLED: 0x0F,
}
_TO_QUICK_STOP = {State.OPERATION_ENABLED: 0x02, State.QUICK_STOP_ACTIVE: 0x02}


def controlword(status: int, wanted: State) -> int:
    """Return the controlword that takes a drive one step towards a state.

    ``wanted`` is operation enabled, quick stop active, or switch on disabled. Nothing here resets a fault: that is
    `FAULT_RESET`, after a controlword without it, and it leaves the drive disabled. A drive that is on another way,
    or that nobody understands, gets no voltage.

    >>> [hex(controlword(status, State.OPERATION_ENABLED)) for status in (0x250, 0x231, 0x233, 0x237, 0x218)]
    ['0x6', '0x7', '0xf', '0xf', '0x0']
    >>> hex(controlword(0x0237, State.QUICK_STOP_ACTIVE)), hex(controlword(0x0237, State.SWITCH_ON_DISABLED))
    ('0x2', '0x0')
    """
    steps = {State.OPERATION_ENABLED: _TO_ENABLED, State.QUICK_STOP_ACTIVE: _TO_QUICK_STOP}.get(wanted, {})
    state = state_of(status)
    return steps.get(state, 0) if state else 0


class Homing(Enum):
    """How far homing is."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


def homing_of(status: int) -> Homing:
    """Return how far homing is, in homing mode after its start.

    >>> [homing_of(status).name for status in (0x0237, 0x0637, 0x1637, 0x2637)]
    ['RUNNING', 'RUNNING', 'DONE', 'FAILED']
    """
    if status & HOMING_ERROR:
        return Homing.FAILED
    return Homing.DONE if status & ATTAINED and status & REACHED else Homing.RUNNING
