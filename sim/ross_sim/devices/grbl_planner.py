"""How grbl moves: a look-ahead planner of straight lines, and step segments prepared ahead of the motor.

The speed along the blocks is that of grbl: constant acceleration up to the feed rate, down to what the junction ahead
allows, to rest at the end of the last block. Steps are prepared in segments of 10 ms, five at most, which cannot be
taken back: a hold begins to slow down 40 to 50 ms later, and reports tell the speed of what was prepared last.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from ross_protocols.grbl.protocol import MIN_FEED

PIECE = 0.001  # of a motion, with constant acceleration [s]
SEGMENT = 10  # pieces that are prepared at once
AHEAD = 5 * SEGMENT  # pieces that are prepared at most
BLOCKS = 15  # that can wait

Vector = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Axis:
    """What the settings say about an axis."""

    steps: float  # per mm
    rate: float  # [mm/min]
    acceleration: float  # [mm/s^2]


@dataclass(frozen=True, slots=True)
class Block:
    """A straight line."""

    start: Vector  # [steps]
    target: Vector  # [steps]
    unit: Vector
    length: float  # [mm]
    speed: float  # [mm/s]
    acceleration: float  # [mm/s^2]
    entry: float  # fastest at its begin [mm/s]

    def at(self, travelled: float) -> Vector:
        """Return the position [steps] after so many [mm]."""
        part = travelled / self.length
        return tuple(a + (b - a) * part for a, b in zip(self.start, self.target, strict=True))


class Motion:
    """Blocks in, positions out, a piece at a time.

    >>> motion = Motion((Axis(10.0, 600.0, 100.0),), 0.01)
    >>> motion.add((5,), 600.0)
    True
    >>> while motion.moving: before, after = motion.piece()
    >>> after, motion.speed
    ((5.0,), 0.0)
    """

    def __init__(self, axes: Sequence[Axis], deviation: float) -> None:
        self.axes = tuple(axes)
        self.speed = 0.0  # at the end of what is prepared [mm/s]
        self._deviation = deviation  # of junctions [mm]
        self._blocks: deque[Block] = deque()
        self._travelled = 0.0  # of the first block [mm]
        self._prepared: deque[Vector] = deque()
        self._position: Vector = tuple(0.0 for _ in axes)
        self._holding = False

    @property
    def position(self) -> tuple[int, ...]:
        """Where the counters are [steps]."""
        return tuple(math.floor(value + 0.5) for value in self._position)

    @property
    def moving(self) -> bool:
        """Whether there is anything left to do, but for a hold."""
        return bool(self._prepared) or self._going

    @property
    def planned(self) -> tuple[int, ...]:
        """Where the counters will be after the last block [steps]."""
        return tuple(round(value) for value in self._blocks[-1].target) if self._blocks else self.position

    @property
    def free(self) -> int:
        """How many more blocks can be added."""
        return BLOCKS - len(self._blocks)

    def add(self, target: Sequence[int], feed: float) -> bool:
        """Append a line to ``target`` [steps] at ``feed`` [mm/min]; whether there is anything to move."""
        start = tuple(map(float, self.planned))
        sides = [(b - a) / axis.steps for a, b, axis in zip(start, target, self.axes, strict=True)]
        length = math.hypot(*sides)
        if length == 0.0:
            return False
        unit = tuple(side / length for side in sides)
        used = [(axis, abs(part)) for axis, part in zip(self.axes, unit, strict=True) if part]
        speed = max(MIN_FEED, min([feed, *(axis.rate / part for axis, part in used)])) / 60
        acceleration = min(axis.acceleration / part for axis, part in used)
        entry = self._junction(unit, speed, acceleration)
        self._blocks.append(Block(start, tuple(map(float, target)), unit, length, speed, acceleration, entry))
        return True

    def hold(self) -> None:
        """Slow down to rest, after what is prepared."""
        self._holding = True

    def resume(self) -> None:
        """Go on after a hold."""
        self._holding = False

    def clear(self) -> None:
        """Forget everything; a motor that moves is stopped dead."""
        self._blocks.clear()
        self._prepared.clear()
        self._travelled = self.speed = 0.0
        self._holding = False
        self._position = tuple(map(float, self.position))

    def place(self, position: Sequence[int]) -> None:
        """Declare where the counters are [steps]."""
        self._position = tuple(map(float, position))

    def piece(self) -> tuple[Vector, Vector]:
        """Let one piece pass; return the positions [steps] before and after it."""
        while len(self._prepared) <= AHEAD - SEGMENT and self._going:
            for _ in range(SEGMENT):
                self._prepared.append(self._prepare())
        before = self._position
        if self._prepared:
            self._position = self._prepared.popleft()
        return before, self._position

    def _junction(self, unit: Vector, speed: float, acceleration: float) -> float:
        """Return the speed [mm/s] at which the corner into a new block may be taken."""
        if not self._blocks:
            return 0.0
        before = self._blocks[-1]
        cosine = -sum(a * b for a, b in zip(before.unit, unit, strict=True))
        if cosine > 0.999999:
            return 0.0
        half = math.sqrt((1 - cosine) / 2)
        curve = math.inf if cosine < -0.999999 else math.sqrt(acceleration * self._deviation * half / (1 - half))
        return min(curve, speed, before.speed)

    def _exit(self) -> float:
        """Return the speed [mm/s] with which the first block may end, looking ahead from the last."""
        speed = 0.0
        for block in list(self._blocks)[:0:-1]:
            speed = min(block.entry, math.sqrt(speed**2 + 2 * block.acceleration * block.length))
        return speed

    @property
    def _going(self) -> bool:
        """Whether there is more to prepare."""
        return bool(self._blocks) and not (self._holding and self.speed == 0.0)

    def _prepare(self) -> Vector:
        """Compute one piece; a block that ends within it hands over to the next."""
        if not self._going:
            return self._prepared[-1]
        left, position = PIECE, self._blocks[0].at(self._travelled)
        while left > 1e-12 and self._blocks:
            block = self._blocks[0]
            after = self._after(block, left)
            rest, mean = block.length - self._travelled, (self.speed + after) / 2
            if mean * left < rest - 1e-9:
                self._travelled, self.speed = self._travelled + mean * left, after
                return block.at(self._travelled)
            left -= rest / mean if mean else left
            position, self.speed, self._travelled = block.target, after, 0.0
            self._blocks.popleft()
        if not self._blocks:
            self.speed = 0.0
        return position

    def _after(self, block: Block, duration: float) -> float:
        """Return the speed [mm/s] after a piece: as fast as feed, acceleration and the end of the block allow."""
        most = block.acceleration * duration
        slowest = max(self.speed - most, 0.0)
        if self._holding:
            return slowest
        rest = block.length - self._travelled
        root = most**2 + 4 * (self._exit() ** 2 + 2 * block.acceleration * rest - most * self.speed)
        braking = (math.sqrt(root) - most) / 2 if root > 0 else 0.0
        return max(slowest, min(braking, self.speed + most, block.speed))
