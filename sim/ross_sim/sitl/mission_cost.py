"""What a mission computes, apart from the world that it is flown in."""

from __future__ import annotations

from dataclasses import dataclass

from ross_payload.computing import cpu_time
from ross_payload.interfaces import Mission, Result


@dataclass(slots=True)
class Cost:
    """CPU time of a mission on its threads [s]: exploring, deciding, separating, comparing voices."""

    seconds: float = 0.0

    def of(self, mission: Mission) -> Mission:
        """Pass everything on, and count the time that the mission takes over each hop.

        >>> def twice():
        ...     heard = yield "a"
        ...     return heard
        >>> cost = Cost()
        >>> metered = cost.of(twice())
        >>> next(metered)
        'a'
        >>> try:
        ...     metered.send("hop")
        ... except StopIteration as end:
        ...     end.value, cost.seconds > 0
        ('hop', True)
        """
        try:
            began = cpu_time()
            output = next(mission)
            while True:
                self.seconds += cpu_time() - began
                hop = yield output
                began = cpu_time()
                output = mission.send(hop)
        except StopIteration as end:
            self.seconds += cpu_time() - began
            result: Result = end.value
            return result
        finally:
            mission.close()
