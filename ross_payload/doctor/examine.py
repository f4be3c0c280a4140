"""Every check, in the order in which a person would look."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from ross_payload.config import Config
from ross_payload.doctor import computer, folders, microphones, speed, turning, wires
from ross_payload.doctor.finding import Finding, fail
from ross_payload.doctor.machine import Machine
from ross_payload.interfaces import Clock

Check = Callable[[Config, Machine], Iterator[Finding]]

CHECKS: tuple[Check, ...] = (
    computer.python, computer.clock, computer.heat, computer.priority, computer.power,
    wires.extras, wires.serial, wires.can, wires.links, wires.identity,
    folders.state, folders.recordings, folders.voice, turning.start,
)  # fmt: skip


def examine(config: Config, machine: Machine, clock: Clock, first: Sequence[Check] = CHECKS) -> Iterator[Finding]:
    """Yield what every check finds, as soon as it is found; a check that breaks hurts no other."""
    checks: list[tuple[str, Callable[[], Iterator[Finding]]]] = [
        (check.__name__, partial(check, config, machine)) for check in first
    ]
    checks.append(("microphones", partial(microphones.microphones, config, clock)))
    checks.append(("actuator", partial(turning.actuator, config, machine, clock)))
    checks.append(("speed", partial(speed.headroom, config, clock)))
    for name, check in checks:
        try:
            yield from check()
        except Exception as error:  # a computer that surprises one check is what the others are for
            yield fail(name, f"the check itself failed: {error!r}", "please report this line")
