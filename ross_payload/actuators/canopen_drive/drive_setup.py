"""How a CANopen drive is asked who it is and told how to move, one dictionary entry after the other."""

from __future__ import annotations

import logging
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass

from ross_payload.actuators.canopen_drive.options import HOMING_METHODS, Options
from ross_payload.errors import ActuatorFault
from ross_protocols.canopen import cia402
from ross_protocols.canopen.frames import NOT_VALID, ON_EVENT, RPDO, TPDO, Item
from ross_protocols.canopen.sdo import NO_OBJECT, NO_SUBINDEX, Abort, Read, Value, Write, Written

SDO_TIMEOUT_S, SDO_TRIES = 0.25, 3  # [s] with an answer; how often to ask
HEARTBEAT_MS, HEARTBEAT_TIMEOUT_MS = 100, 500  # the drive's heartbeat; how long it waits for ours [ms]
REPORT_PERIOD_MS = 20  # between two reports of the drive [ms]
# process data to the drive: the speed first, also through a controller that sends the lowest identifier first
RPDO1_ITEMS = (cia402.PROFILE_VELOCITY,)
RPDO2_ITEMS = (cia402.CONTROLWORD, cia402.TARGET, cia402.MODE)
TPDO1_ITEMS = (cia402.STATUSWORD, cia402.POSITION, cia402.MODE_SHOWN)  # process data from the drive
TPDO2_ITEMS = (cia402.VELOCITY,)
IDENTITY = {cia402.VENDOR: "vendor", cia402.PRODUCT: "product", cia402.REVISION: "revision", cia402.SERIAL: "serial"}
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SdoTransfer:
    """An entry to read or, with a value, to write."""

    item: Item
    value: int | None = None
    needed: bool = True  # the drive must have it

    @property
    def request(self) -> Read | Write:
        """What to ask."""
        index, sub = self.item.index, self.item.sub
        return Read(index, sub) if self.value is None else Write(index, sub, self.item.pack(self.value))

    def __str__(self) -> str:
        return f"read {self.item}" if self.value is None else f"write {self.item} = {self.value}"


Steps = Generator[SdoTransfer, int | None, None]


class DriveSetup:
    """Asks one thing at a time; what the drive answers decides what comes next.

    Raises
    ------
    ActuatorFault
        From `advance`: no answer, a refusal, or a drive that cannot do what is wanted.
    """

    def __init__(self, options: Options) -> None:
        self._node = options.node_id
        self._steps = steps(options)
        self._transfer: SdoTransfer | None = next(self._steps)
        self._tries = 0
        self._asked_at: float | None = None  # [s]
        self._identity: dict[Item, int] = {}  # of its identity

    @property
    def done(self) -> bool:
        """Whether all is asked and told."""
        return self._transfer is None

    @property
    def identity(self) -> str:
        """The numbers by which the drive's maker knows it; empty until it has told them all."""
        if self._transfer is not None and self._transfer.item in IDENTITY:
            return ""
        return ", ".join(f"{IDENTITY[item]} 0x{value:X}" for item, value in self._identity.items())

    def advance(self, answers: Sequence[Value | Written | Abort], now: float) -> Read | Write | None:
        """Take answers; return what to ask at ``now`` [s]: None while the drive may still answer, and when done."""
        for answer in answers:
            self._on_answer(answer)
        if self._transfer is None or (self._asked_at is not None and now < self._asked_at + SDO_TIMEOUT_S):
            return None
        if self._tries == SDO_TRIES:
            raise ActuatorFault(f"node {self._node} does not answer: cannot {self._transfer}")
        self._tries, self._asked_at = self._tries + 1, now
        return self._transfer.request

    def _on_answer(self, answer: Value | Written | Abort) -> None:
        """Take the answer to what was asked last; any other is left."""
        transfer = self._transfer
        if transfer is None or (answer.index, answer.sub) != (transfer.item.index, transfer.item.sub):
            return
        if isinstance(answer, Abort):
            missing = answer.code in (NO_OBJECT, NO_SUBINDEX)
            if transfer.needed or not missing:
                raise ActuatorFault(f"node {self._node} refuses to {transfer}: {answer}")
            self._advance(None)
        elif isinstance(answer, Value) is (transfer.value is None):
            self._advance(self._number(transfer, answer) if isinstance(answer, Value) else None)

    def _number(self, transfer: SdoTransfer, answer: Value) -> int:
        if len(answer.data) < transfer.item.size:
            found = f"{len(answer.data)} bytes, not {transfer.item.size}"
            raise ActuatorFault(f"node {self._node}: {transfer.item} has {found}")
        return transfer.item.unpack(answer.data[: transfer.item.size])

    def _advance(self, answer: int | None) -> None:
        self._asked_at, self._tries = None, 0
        if self._transfer is not None and answer is not None and self._transfer.item in IDENTITY:
            self._identity[self._transfer.item] = answer
        try:
            self._transfer = self._steps.send(answer)
        except StopIteration:
            self._transfer = None
            log.info("drive at node %d: %s", self._node, self.identity)


def steps(options: Options) -> Steps:
    """Ask and tell everything; nothing moves, and a drive that does is stopped."""
    yield from _identify(options)
    yield from _check(options)
    for item, value in settings(options):
        yield SdoTransfer(item, value)
    for item, value in optional_settings(options):
        yield SdoTransfer(item, value, needed=False)
    yield from _map(0x1400, RPDO[0] + options.node_id, RPDO1_ITEMS)
    yield from _map(0x1401, RPDO[1] + options.node_id, RPDO2_ITEMS)
    yield from _map(0x1800, TPDO[0] + options.node_id, TPDO1_ITEMS)
    yield from _map(0x1801, TPDO[1] + options.node_id, TPDO2_ITEMS)


def settings(options: Options) -> Iterator[tuple[Item, int]]:
    """Return what a drive must be told: what to do without us, how to brake, when it does not follow, its home."""
    ramp = options.span(options.max_acceleration_deg_s2)
    yield cia402.PRODUCER_HEARTBEAT, HEARTBEAT_MS
    yield cia402.CONSUMER_HEARTBEAT, options.own_node_id << 16 | HEARTBEAT_TIMEOUT_MS
    yield cia402.ABORT_CONNECTION, cia402.QUICK_STOP_ON_SILENCE
    yield cia402.QUICK_STOP_OPTION, cia402.QUICK_STOP_AND_OFF
    yield cia402.FOLLOWING_WINDOW, options.span(options.max_lag_deg)
    yield cia402.PROFILE_ACCELERATION, ramp
    yield cia402.PROFILE_DECELERATION, ramp
    yield cia402.QUICK_STOP_DECELERATION, ramp
    if not options.absolute:
        fast = options.span(min(options.homing_deg_s, options.max_speed_deg_s))
        yield cia402.HOMING_METHOD, HOMING_METHODS[options.homing]
        yield cia402.HOMING_FAST, fast
        yield cia402.HOMING_SLOW, max(fast // 10, 1)
        yield cia402.HOMING_ACCELERATION, ramp


def optional_settings(options: Options) -> Iterator[tuple[Item, int]]:
    """Return what not every drive can be told."""
    yield cia402.HALT_OPTION, cia402.SLOW_DOWN
    yield cia402.FOLLOWING_TIME, 50
    yield cia402.POSITION_WINDOW, max(round(abs(options.resolution * options.scale) / 2), 1)
    yield cia402.POSITION_TIME, REPORT_PERIOD_MS
    if not options.absolute:
        yield cia402.HOME_OFFSET, 0


def _identify(options: Options) -> Steps:
    kind = yield SdoTransfer(cia402.DEVICE_TYPE)
    if (kind or 0) & 0xFFFF != cia402.PROFILE:
        raise ActuatorFault(f"node {options.node_id} is not a CiA 402 drive: its device type is 0x{kind or 0:08X}")
    yield SdoTransfer(
        cia402.CONTROLWORD, cia402.controlword(cia402.State.OPERATION_ENABLED.bits, cia402.State.QUICK_STOP_ACTIVE)
    )
    for item in IDENTITY:
        yield SdoTransfer(item, needed=item == cia402.VENDOR)


def _check(options: Options) -> Steps:
    """Compare what the drive can do with what is wanted of it."""
    modes = yield SdoTransfer(cia402.SUPPORTED_MODES)
    asked = cia402.Mode.PROFILE_POSITION.bit | (cia402.Mode.HOMING.bit if not options.absolute else 0)
    if (modes or 0) & asked != asked:
        raise ActuatorFault(f"the drive lacks a mode: expected 0x{asked:X}, got 0x{modes or 0:X}")
    lowest = yield SdoTransfer(cia402.LOWEST, needed=False)
    highest = yield SdoTransfer(cia402.HIGHEST, needed=False)
    if lowest is not None and highest is not None:
        if lowest >= highest:
            raise ActuatorFault(f"the drive's software limits are invalid: {lowest} to {highest} counts")
        lower, upper = options.travel
        if lower < lowest or upper > highest:
            raise ActuatorFault(
                f"the travel of {lower} to {upper} counts is beyond the drive's software limits, {lowest} to {highest}"
            )
    rpm = yield SdoTransfer(cia402.MAX_MOTOR_SPEED, needed=False)
    needed = options.max_speed_deg_s * abs(options.gear_ratio) / 6
    if rpm is not None and rpm < needed * (1 - 1e-9):
        most = rpm * 6 / abs(options.gear_ratio)
        raise ActuatorFault(f"max_speed_deg_s = {options.max_speed_deg_s:g} is beyond the drive's own {most:g} deg/s")


def _map(parameter: int, identifier: int, items: Sequence[Item]) -> Steps:
    """Switch process data off, map them, switch them on."""
    mapping = parameter + 0x200
    yield SdoTransfer(Item(parameter, 1, "I"), identifier | NOT_VALID)
    yield SdoTransfer(Item(mapping, 0, "B"), 0)
    for place, item in enumerate(items, 1):
        yield SdoTransfer(Item(mapping, place, "I"), item.mapping)
    yield SdoTransfer(Item(mapping, 0, "B"), len(items))
    yield SdoTransfer(Item(parameter, 2, "B"), ON_EVENT)
    if parameter >= 0x1800:
        yield SdoTransfer(Item(parameter, 5, "H"), REPORT_PERIOD_MS)
    yield SdoTransfer(Item(parameter, 1, "I"), identifier)
