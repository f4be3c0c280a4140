"""The address of a MAVLink component."""

from __future__ import annotations

from typing import NamedTuple, Self


class ComponentId(NamedTuple):
    """A component of a system; as a target, 0 means all: every system, or every component of one.

    >>> str(ComponentId(1, 191)), ComponentId.parse("1-191")
    ('1-191', ComponentId(system=1, component=191))
    """

    system: int
    component: int

    def __str__(self) -> str:
        """Write it as URLs and file names can hold it."""
        return f"{self.system}-{self.component}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read what `str` wrote.

        Raises
        ------
        ValueError
            When it is anything else.
        """
        system, dash, component = text.partition("-")
        numbers = [int(part) if part.isascii() and part.isdigit() else 256 for part in (system, component)]
        if not dash or not all(0 < number < 256 for number in numbers):
            raise ValueError(f"expected system-component, as in 1-191, got '{text}'")
        return cls(*numbers)

    @property
    def is_broadcast(self) -> bool:
        """Whether this target means every component, or every system."""
        return 0 in self

    def includes(self, other: ComponentId) -> bool:
        """Tell whether this target means a component, alone or among all.

        >>> ComponentId(1, 0).includes(ComponentId(1, 191)), ComponentId(2, 191).includes(ComponentId(1, 191))
        (True, False)
        """
        return self.system in (0, other.system) and self.component in (0, other.component)


NOBODY = ComponentId(0, 0)  # as who is in control


def target_of(message: object) -> ComponentId:
    """Return whom a message with a target is for; one without a target is for all."""
    return ComponentId(getattr(message, "target_system", 0), getattr(message, "target_component", 0))
