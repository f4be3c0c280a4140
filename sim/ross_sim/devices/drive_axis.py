"""The firmware of the simulated CANopen drive that moves: states by CiA 402, profile position, homing, following error.

Positions are encoder counts from the drive's own zero. It makes its trapezoids with the driver's own arithmetic.
"""

from __future__ import annotations

from enum import Enum

from ross_payload.actuators.motion import Motion, Trapezoid
from ross_protocols.canopen import cia402
from ross_protocols.canopen.cia402 import Mode, State
from ross_protocols.canopen.frames import Emergency, Item
from ross_sim.devices.drive_objects import Objects
from ross_sim.devices.drive_servo import STEP, Axle

FOLLOWING_ERROR, LIFE_MISSED = 0x8611, 0x8130
NEVER = 0xFFFF_FFFF  # a following error window that is switched off
HERE = (35, 37)  # homing methods that take the place where it stands
SEARCHES = {17: -1, 18: 1, 19: 1, 21: -1}  # those that look for a switch: on which side it is


class Search(Enum):
    """Stages of homing."""

    TOWARDS = "towards the switch"
    BACK = "off the switch"


class Axis:
    """The part of a drive that is one axis.

    Parameters
    ----------
    objects : Objects
        The dictionary.
    axle : Axle
        What it turns.
    counts_per_turn : float
        Of the motor.
    origin, switch : int
        Encoder counts at the drive's zero when it is switched on, and where the switch for homing is.
    """

    def __init__(self, objects: Objects, axle: Axle, counts_per_turn: float, origin: int, switch: int) -> None:
        self.state = State.SWITCH_ON_DISABLED
        self.emergencies: list[Emergency] = []
        self._objects, self._axle, self._counts_per_turn = objects, axle, counts_per_turn
        self._origin, self._switch = origin, switch
        self._now = 0.0
        self._word = 0  # the last controlword
        self._motion = self._rest()
        self._speed = 0.0  # of the demand one step ago [1/s]
        self._next: int | None = None  # a set-point that waits for the one in flight
        self._acknowledged = self._reached = self._limited = False
        self._attained = self._failed = False
        self._search: Search | None = None
        self._behind = 0.0  # for so long has the following error been too large [s]

    # ------------------------------------------------------------------------------------------ what it is told

    def obey(self, word: int) -> None:
        """Obey a controlword."""
        rising, self._word = word & ~self._word, word
        if self.state is State.FAULT:
            if rising & cia402.FAULT_RESET:
                self.state = State.SWITCH_ON_DISABLED
                self._report(0)
            return
        self._change_state(word)
        if self.state is State.OPERATION_ENABLED:
            self._command(word, rising)

    def choose(self, mode: int) -> None:
        """Change the mode of operation, which ends a move."""
        known = mode in set(Mode) and (not mode or Mode(mode).bit & self._objects[cia402.SUPPORTED_MODES])
        if known and mode != self._objects[cia402.MODE_SHOWN]:
            self._objects[cia402.MODE_SHOWN] = mode
            self._acknowledged = self._attained = self._failed = False
            self._brake(cia402.PROFILE_DECELERATION)

    def lose_master(self) -> None:
        """React to a master that is silent, as the abort connection option says."""
        self._report(LIFE_MISSED)
        if self.state is not State.OPERATION_ENABLED:
            return
        option = self._objects[cia402.ABORT_CONNECTION]
        if option == 1:
            self.fail(LIFE_MISSED)
        elif option == 2:
            self._disable(State.SWITCH_ON_DISABLED)
        elif option == cia402.QUICK_STOP_ON_SILENCE:
            self._quick_stop()

    # ------------------------------------------------------------------------------------------ what it says

    @property
    def status(self) -> int:
        """The statusword."""
        word = self.state.bits | cia402.VOLTAGE | cia402.REMOTE | (cia402.LIMITED if self._limited else 0)
        if self.state is not State.OPERATION_ENABLED:
            return word
        word |= cia402.REACHED if self._reached else 0
        if self._objects[cia402.MODE_SHOWN] == Mode.HOMING:
            return word | (cia402.ATTAINED if self._attained else 0) | (cia402.HOMING_ERROR if self._failed else 0)
        late = self._behind > 0
        return word | (cia402.ACKNOWLEDGED if self._acknowledged else 0) | (cia402.FOLLOWING_ERROR if late else 0)

    @property
    def position(self) -> int:
        """Where the encoder says that it is."""
        return self._axle.counts - self._origin

    # ------------------------------------------------------------------------------------------ life

    def step(self, now: float) -> None:
        """Live for one step that ends at ``now`` [s]."""
        self._now = now
        demand, speed = self._motion.at(now)
        if self.state in (State.OPERATION_ENABLED, State.QUICK_STOP_ACTIVE, State.FAULT_REACTION):
            lag = demand - self.position
            self._axle.follow(lag, speed, (speed - self._speed) / STEP)
            window, timeout = self._objects[cia402.FOLLOWING_WINDOW], self._objects[cia402.FOLLOWING_TIME] * 1e-3
            self._behind = self._behind + STEP if window != NEVER and abs(lag) > window else 0.0
            if self._behind > timeout and self.state is State.OPERATION_ENABLED:
                self.fail(FOLLOWING_ERROR)
            self._proceed(now)
        else:
            self._axle.live()
        self._speed = speed
        self._objects[cia402.POSITION] = self.position
        self._objects[cia402.VELOCITY] = round(self._axle.counts_rate)

    def _proceed(self, now: float) -> None:
        over = now >= self._motion.end
        if self.state is State.OPERATION_ENABLED:
            self._seek()
            near = abs(self._motion.plan.goal - self.position) <= self._objects[cia402.POSITION_WINDOW]
            held = now >= self._motion.end + self._objects[cia402.POSITION_TIME] * 1e-3
            self._reached = over and held and (near or bool(self._word & cia402.HALT)) and self._search is None
            if over and self._next is not None:
                goal, self._next = self._next, None
                self._go(goal)
        elif over:
            self._disable(State.FAULT if self.state is State.FAULT_REACTION else State.SWITCH_ON_DISABLED)

    # ------------------------------------------------------------------------------------------ states

    def _change_state(self, word: int) -> None:
        state = self.state
        if not word & 0x02:
            if state not in (State.SWITCH_ON_DISABLED, State.FAULT_REACTION):
                self._disable(State.SWITCH_ON_DISABLED)
        elif not word & 0x04:
            if state is State.OPERATION_ENABLED:
                self._quick_stop()
            elif state in (State.READY_TO_SWITCH_ON, State.SWITCHED_ON):
                self.state = State.SWITCH_ON_DISABLED
        elif word & 0x07 == 0x06:
            if state in (State.SWITCH_ON_DISABLED, State.SWITCHED_ON, State.OPERATION_ENABLED):
                self._disable(State.READY_TO_SWITCH_ON)
        elif word & 0x08:
            if state is State.SWITCHED_ON:
                self.state = State.OPERATION_ENABLED
                self._acknowledged = self._reached = self._limited = False
                self._behind = 0.0
                self._motion = self._rest()
        elif state in (State.READY_TO_SWITCH_ON, State.OPERATION_ENABLED):
            self._disable(State.SWITCHED_ON)

    def _disable(self, state: State) -> None:
        self.state, self._next, self._search, self._behind = state, None, None, 0.0

    def _quick_stop(self) -> None:
        self.state, self._next, self._search = State.QUICK_STOP_ACTIVE, None, None
        self._brake(cia402.QUICK_STOP_DECELERATION)

    def fail(self, code: int) -> None:
        """Report an error and stop because of it."""
        self._report(code)
        self._quick_stop()
        self.state = State.FAULT_REACTION

    def _report(self, code: int) -> None:
        self.emergencies.append(Emergency(code, 0x21 if code else 0))

    # ------------------------------------------------------------------------------------------ moves

    def _command(self, word: int, rising: int) -> None:
        if rising & cia402.HALT:
            self._next, self._search = None, None
            self._brake(cia402.PROFILE_DECELERATION)
        if word & cia402.HALT:
            return
        if self._objects[cia402.MODE_SHOWN] == Mode.HOMING:
            if rising & cia402.START_HOMING:
                self._begin_homing()
        elif self._objects[cia402.MODE_SHOWN] == Mode.PROFILE_POSITION:
            self._take_set_point(word, rising)

    def _take_set_point(self, word: int, rising: int) -> None:
        if not word & cia402.NEW_SET_POINT:
            self._acknowledged = False
        elif rising & cia402.NEW_SET_POINT and not self._acknowledged:
            self._acknowledged, self._reached = True, False
            target = self._objects[cia402.TARGET]
            lowest, highest = self._objects[cia402.LOWEST], self._objects[cia402.HIGHEST]
            goal = max(lowest, min(target, highest))
            self._limited = goal != target
            if word & cia402.AT_ONCE or self._now >= self._motion.end:
                self._go(goal)
            else:
                self._next = goal

    def _go(self, goal: int, speed: int | None = None, acceleration: int | None = None) -> None:
        """Plan from the demand to a goal; at the acceleration of the profile both ways."""
        position, velocity = self._motion.at(self._now)
        fastest = self._objects[cia402.MAX_MOTOR_SPEED] / 60 * self._counts_per_turn
        speed = speed or self._objects[cia402.PROFILE_VELOCITY]
        acceleration = acceleration or self._objects[cia402.PROFILE_ACCELERATION]
        plan = Trapezoid(position, goal, max(min(speed, fastest), 1.0), acceleration, velocity)
        self._motion = Motion(plan, self._now)

    def _brake(self, ramp: Item) -> None:
        position, velocity = self._motion.at(self._now)
        self._motion = Motion(Trapezoid.to_rest(position, velocity, self._objects[ramp]), self._now)

    def _rest(self) -> Motion:
        """Return a demand that is where the axle is, and brakes."""
        ramp = self._objects[cia402.QUICK_STOP_DECELERATION]
        return Motion(Trapezoid.to_rest(self.position, self._axle.counts_rate, ramp), self._now)

    # ------------------------------------------------------------------------------------------ homing

    def _begin_homing(self) -> None:
        method = self._objects[cia402.HOMING_METHOD]
        self._attained, self._failed, self._reached = False, False, False
        if method in HERE:
            self._find_home(self._axle.counts)
        elif method in SEARCHES:
            self._search = Search.TOWARDS
            self._run(SEARCHES[method], cia402.HOMING_FAST)
        else:
            self._failed = True

    def _run(self, direction: int, speed: Item) -> None:
        """Turn without an end, as far as 32 bits go."""
        self._go(direction * 2**31, self._objects[speed], self._objects[cia402.HOMING_ACCELERATION])

    def _seek(self) -> None:
        if self._search is None:
            return
        side = SEARCHES[self._objects[cia402.HOMING_METHOD]]
        switch = self._switch - round(self._axle.slipped * self._axle.scale)  # it is on the array's side
        on_switch = (self._axle.counts - switch) * side >= 0
        if self._search is Search.TOWARDS and on_switch:
            self._search = Search.BACK
            self._run(-side, cia402.HOMING_SLOW)
        elif self._search is Search.BACK and not on_switch:
            self._find_home(switch)

    def _find_home(self, origin: int) -> None:
        """Shift the zero, and the demand with it, so that nothing jumps."""
        position, velocity = self._motion.at(self._now)
        shift = origin - self._origin
        self._origin, self._search, self._attained = origin, None, True
        ramp = self._objects[cia402.HOMING_ACCELERATION]
        self._motion = Motion(Trapezoid.to_rest(position - shift, velocity, ramp), self._now)
