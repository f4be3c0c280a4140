"""What becomes of an order, in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ross_payload.ground.clients.asking import Order
from ross_payload.ground.picture.known import Said, Who
from ross_protocols.commands import Result

PREFIX = "RoSS: "  # of the payload's texts
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
UNHEARD = "check that it is in range, that it accepts this station ([[links]] accept), and the signing key"
SILENCE = "the result was not received: check the payload's state"
REPLACED = "replaced by another command"
STARTED_ANEW = "the payload restarted"
AFTER_STOP = "stop was sent"
OVERTAKEN = "another command was sent before it was answered"


@dataclass(frozen=True, slots=True)
class Doing:
    """An order and what has become of it."""

    number: int
    who: Who
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


def reason_in(said: Said, doing: Doing) -> str:
    """Return why an order was refused, or failed, as far as a text of its payload tells it; empty: it does not.

    >>> from ross_payload.ground.clients.asking import Turn
    >>> doing = Doing(1, Who(1, 191), Turn(40.0), REFUSED, since=0.0, at=0.2)
    >>> reason_in(Said(0.3, 4, "RoSS: turn refused: stopped: re-arm first"), doing)
    'stopped: re-arm first'
    """
    refused, failed = f"{doing.order.name} refused: ", ("mission over: ", "fault: ")
    starts = {REFUSED: (refused,), FAILED: (refused, *failed)}.get(doing.state, ())
    text = said.text.removeprefix(PREFIX)
    return next((text.removeprefix(start) for start in starts if text.startswith(start)), "")
