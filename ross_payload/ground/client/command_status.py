"""What becomes of an order, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ross_payload.ground.client.command_types import Order
from ross_payload.ground.model.payload_state import StatusText
from ross_payload.ground.model.status_text import PREFIX
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.component_id import ComponentId

SENT, ACKNOWLEDGED, IN_PROGRESS, DONE, REFUSED, FAILED, CANCELLED, NO_ANSWER = (
    "sent", "acknowledged", "in_progress", "done", "refused", "failed", "cancelled", "no_answer"
)  # fmt: skip
ENDS = {
    Result.ACCEPTED: (DONE, ""),
    Result.TEMPORARILY_REJECTED: (REFUSED, "not possible now"),
    Result.DENIED: (REFUSED, "invalid parameters, or this station is not permitted ([[links]] accept)"),
    Result.UNSUPPORTED: (REFUSED, "this payload does not support the command"),
    Result.FAILED: (FAILED, "it did not complete"),
    Result.CANCELLED: (CANCELLED, "ended by a cancel, a stop or another command"),
    Result.COMMAND_LONG_ONLY: (REFUSED, "this payload accepts only COMMAND_LONG"),
}
OVER = frozenset((DONE, REFUSED, FAILED, CANCELLED, NO_ANSWER))
DEFAULT_REASONS = frozenset(reason for _, reason in ENDS.values())
NOT_ANSWERED = "check that it is in range, that it accepts this station ([[links]] accept), and the signing key"
HAS_STOPPED = "its telemetry says that it has stopped"
NO_RESULT = "the result was not received: check the payload's state"
REPLACED = "replaced by another command"
RESTARTED = "the payload restarted"
AFTER_STOP = "stop was sent"
OVERTAKEN = "another command was sent before it was answered"


@dataclass(frozen=True, slots=True)
class CommandStatus:
    """An order and what has become of it."""

    number: int
    who: ComponentId
    order: Order
    state: str  # sent, acknowledged, in_progress; done, refused, failed, cancelled, no_answer
    since: float  # ordered [s]
    at: float  # latest change [s]
    progress: float | None = None  # 0 to 1
    reason: str = ""

    @property
    def words(self) -> str:
        """What was ordered."""
        return self.order.words

    @property
    def over(self) -> bool:
        """Whether nothing more becomes of it."""
        return self.state in OVER

    @property
    def explained(self) -> bool:
        """Whether it was done, or the payload's own words say why not; they may come a little later."""
        return self.state == DONE or (self.over and self.reason not in DEFAULT_REASONS)

    def json(self) -> dict[str, Any]:
        """Return it as plain JSON."""
        return {
            "number": self.number,
            "id": str(self.who),
            "words": self.words,
            "state": self.state,
            "progress": self.progress,
            "reason": self.reason,
            "since": self.since,
            "at": self.at,
        }


def reason_in(text: StatusText, doing: CommandStatus) -> str:
    """Return why an order was refused, or failed, as far as a text of its payload tells it; empty: it does not.

    >>> from ross_payload.ground.client.command_types import Turn
    >>> doing = CommandStatus(1, ComponentId(1, 191), Turn(40.0), REFUSED, since=0.0, at=0.2)
    >>> reason_in(StatusText(0.3, 4, "RoSS: turn refused: stopped: re-arm first"), doing)
    'stopped: re-arm first'
    """
    refused, failed = f"{doing.order.name} refused: ", ("mission over: ", "fault: ")
    starts = {REFUSED: (refused,), FAILED: (refused, *failed)}.get(doing.state, ())
    words = text.text.removeprefix(PREFIX)
    return next((words.removeprefix(start) for start in starts if words.startswith(start)), "")
