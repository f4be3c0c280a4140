"""Who is obeyed when. The last explicit act counts: an order for a task, or taking control; what streams does not.

- While a task of the mission runs, the mission is in control, and nobody else points.
- Taking control by CONFIGURE ends the task. The array is at rest, and the mission does not go on by itself.
- Ordering a task takes control back from whoever had it.
- A set-point that was said in vain is not obeyed later, unless it changes.
- A rate counts as long as somebody renews it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace

from ross_payload.errors import ConfigError
from ross_payload.events import Answer, Answered, Event
from ross_payload.mavlink.command_server import ACCEPTED, Verdict
from ross_payload.mavlink.gimbal.device_state import DeviceState
from ross_payload.mavlink.gimbal.setpoint_controller import SetpointController, VainRequests
from ross_payload.mission_state import MissionState, reduce
from ross_payload.orders import Order
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import NOBODY, ComponentId
from ross_protocols.mavlink.gimbal_device import Aim

UNCHANGED, ITSELF, AWAY = -1, -2, -3  # in place of an id
LARGEST_ID = 255
RATE_TIMEOUT_S = 1.5  # [s] that a rate counts: ground stations send one every 0.5 s, and links lose some

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Control:
    """Who was put in control.

    >>> control = Control().configured((-2, -2, -1, -1), (255, 190))
    >>> control.primary, control.allows((255, 190)), control.allows((254, 190))
    ((255, 190), True, False)
    >>> control.configured((-3, -3, -3, -3), (254, 190)) == control
    True
    """

    primary: ComponentId = NOBODY
    secondary: ComponentId = NOBODY

    def allows(self, who: ComponentId) -> bool:
        """Tell whether somebody may point while no task runs."""
        return who in (self.primary, self.secondary) or self == Control()

    def configured(self, numbers: tuple[float, ...], who: ComponentId) -> Control:
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


def _named(system: float, component: float, who: ComponentId, before: ComponentId) -> ComponentId:
    """Return whom a pair of numbers names."""
    meanings = {UNCHANGED: before, ITSELF: who, AWAY: NOBODY if before == who else before}
    if system == component and system in meanings:
        return meanings[int(system)]
    if not all(0 <= number <= LARGEST_ID and number % 1 == 0 for number in (system, component)):
        raise ConfigError(f"expected two ids, or twice -1, -2 or -3, got {system:g}/{component:g}")
    return ComponentId(int(system), int(component))


class ControlArbiter:
    """Judges set-points and control, and gives the orders that follow.

    Parameters
    ----------
    device
        What would turn.
    give
        Hands an order to the runner.
    payload
        Tells the address of the mission.
    """

    def __init__(self, device: DeviceState, give: Callable[[Order], None], payload: Callable[[], ComponentId]) -> None:
        self._device = device
        self._payload = payload
        self._mission = MissionState()
        self._setpoints = SetpointController(give, device.park)
        self._vain = VainRequests()
        self._control = Control()
        self._streams = NOBODY  # who sent the last set-point that nobody acknowledges

    @property
    def _busy(self) -> bool:
        """Whether a task runs that is not ours, and that nobody has ended."""
        return self._mission.running and not self._setpoints.followed and not self._setpoints.cancelling

    @property
    def control(self) -> Control:
        """Who is in control, the mission while a task of it runs."""
        return replace(self._control, primary=self._payload()) if self._busy else self._control

    @property
    def aim(self) -> Aim | None:
        """What the array follows, or has reached, by hand."""
        return self._setpoints.aim

    def on_event(self, event: Event) -> None:
        """Take what the mission says."""
        busy = self._busy
        self._mission = reduce(self._mission, event)
        if isinstance(event, Answered):
            self._setpoints.on_answer(event)
        if self._busy and not busy:
            self._control = Control()
            self._setpoints.forget()
        elif self._mission.barred:
            self._cancel()
        elif isinstance(event, Answered) and event.order < 0:
            self._answered(event)

    def tick(self, now: float) -> None:
        """End what nobody renews."""
        self._setpoints.tick(now)

    def point(self, aim: Aim, who: ComponentId, now: float) -> Verdict:
        """Obey a command."""
        verdict = self._judged(aim, who, now)
        if verdict is ACCEPTED:
            self._vain.forget(who)
            self._setpoints.forget()  # also what is in force already is ordered once more
            self._setpoints.point(aim, self._device.offset(), now + RATE_TIMEOUT_S)
        return verdict

    def stream(self, aim: Aim, who: ComponentId, now: float, timeout: float = RATE_TIMEOUT_S) -> None:
        """Obey a message, one of many that nobody acknowledges, unless it only repeats what was said in vain.

        A rate alone counts for ``timeout`` [s].
        """
        if self._forbidden(who) or self._mission.barred:
            self._vain.note(who, aim)
        elif self._vain.is_news(who, aim) and not self._device.unable(aim, now):
            self._streams = who
            self._setpoints.point(aim, self._device.offset(), now + timeout)

    def meet(self, aim: Aim, who: ComponentId) -> None:
        """Note what somebody said before we listened: it is no order."""
        self._vain.note(who, aim)

    def configure(self, control: Control, who: ComponentId, taken: bool) -> None:
        """Let others be in control; who takes it finds the array at rest, and so does who comes after a release."""
        if control.primary == self._payload():
            control = replace(control, primary=NOBODY)
        if control.primary != NOBODY and taken:
            self._vain.forget(control.primary)
            if self._busy:
                self._setpoints.cancel()
        if control.primary != self._control.primary:
            log.info("%s is in control, as %d/%d requested", _name_of(control.primary), *who)
            if self._setpoints.followed or self._setpoints.aim is not None:
                self._setpoints.still()
        self._control = control

    def _answered(self, event: Answered) -> None:
        """Forget what the mission does not follow, or not any more."""
        if event.answer is Answer.CANCELLED:
            self._cancel()
        elif event.answer is Answer.FAILED or (
            event.answer is Answer.REFUSED and event.order == self._setpoints.latest
        ):
            self._setpoints.forget()

    def _cancel(self) -> None:
        """Forget what somebody has ended: it does not begin again because it goes on being streamed."""
        if self._setpoints.aim is not None:
            self._vain.note(self._streams, self._setpoints.aim)
        self._setpoints.forget()

    def _judged(self, aim: Aim, who: ComponentId, now: float) -> Verdict:
        forbidden = self._forbidden(who)
        if forbidden:
            return Verdict(Result.DENIED, forbidden)
        reason = self._mission.barred or self._device.unable(aim, now)
        return Verdict(Result.TEMPORARILY_REJECTED, reason) if reason else ACCEPTED

    def _forbidden(self, who: ComponentId) -> str:
        if self._busy:
            return "a task of the mission runs: take control first"
        return "" if self._control.allows(who) else "another component is in control"


def _name_of(who: ComponentId) -> str:
    return "nobody" if who == NOBODY else f"{who[0]}/{who[1]}"
