"""What a mission computes, apart from the world that it is flown in."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

from ross_payload.computing import cpu_time
from ross_payload.events import State, StateChanged
from ross_payload.interfaces import Mission, Output, Result


@dataclass(slots=True)
class StateCost:
    """CPU time of a mission in one of its states."""

    hops: int = 0
    cpu_s: float = 0.0
    longest_s: float = 0.0  # over one hop


@dataclass(slots=True)
class Cost:
    """CPU time of a mission on its threads: exploring, deciding, separating, comparing voices."""

    states: dict[State, StateCost] = field(default_factory=lambda: defaultdict(StateCost))
    _state: State = State.IDLE

    @property
    def seconds(self) -> float:
        """Of all states together [s]."""
        return sum(each.cpu_s for each in self.states.values())

    def of(self, mission: Mission) -> Mission:
        """Pass everything on, and count the time that the mission takes over each hop, in the state that it ends.

        >>> def twice():
        ...     heard = yield Output()
        ...     return heard
        >>> cost = Cost()
        >>> metered = cost.of(twice())
        >>> next(metered) == Output()
        True
        >>> try:
        ...     metered.send("hop")
        ... except StopIteration as end:
        ...     end.value, cost.states[State.IDLE].hops, cost.seconds > 0
        ('hop', 1, True)
        """
        began = cpu_time()
        try:
            output = next(mission)
            while True:
                self._count(cpu_time() - began, output)
                hop = yield output
                self.states[self._state].hops += 1
                began = cpu_time()
                output = mission.send(hop)
        except StopIteration as end:
            self._count(cpu_time() - began, Output())
            result: Result = end.value
            return result
        finally:
            mission.close()

    def _count(self, seconds: float, output: Output) -> None:
        spent = self.states[self._state]
        spent.cpu_s += seconds
        spent.longest_s = max(spent.longest_s, seconds)
        for event in output.events:
            if isinstance(event, StateChanged):
                self._state = event.state
