"""Who may point: the mission while a task of it runs, else whom CONFIGURE has put in control, else anybody."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ross_payload.errors import ConfigError
from ross_protocols.gimbal import Address

NOBODY: Address = (0, 0)
UNCHANGED, ITSELF, AWAY = -1, -2, -3  # in place of an id
LARGEST_ID = 255


@dataclass(frozen=True, slots=True)
class Control:
    """Who was put in control.

    >>> control = Control().configured((-2, -2, -1, -1), (255, 190))
    >>> control.primary, control.allows((255, 190)), control.allows((254, 190))
    ((255, 190), True, False)
    >>> control.configured((-3, -3, -3, -3), (254, 190)) == control
    True
    """

    primary: Address = NOBODY
    secondary: Address = NOBODY

    def allows(self, who: Address) -> bool:
        """Tell whether somebody may point while no task runs."""
        return who in (self.primary, self.secondary) or self == Control()

    def configured(self, numbers: tuple[float, ...], who: Address) -> Control:
        """Return the control after the first four numbers of a CONFIGURE that somebody has sent.

        Raises
        ------
        ConfigError
            When they name nobody.
        """
        return replace(
            self,
            primary=_named(numbers[0], numbers[1], who, self.primary),
            secondary=_named(numbers[2], numbers[3], who, self.secondary),
        )


def _named(system: float, component: float, who: Address, before: Address) -> Address:
    """Return whom a pair of numbers names."""
    meanings = {UNCHANGED: before, ITSELF: who, AWAY: NOBODY if before == who else before}
    if system == component and system in meanings:
        return meanings[int(system)]
    if not all(0 <= number <= LARGEST_ID and number % 1 == 0 for number in (system, component)):
        raise ConfigError(f"expected two ids, or twice -1, -2 or -3, got {system:g}/{component:g}")
    return int(system), int(component)
