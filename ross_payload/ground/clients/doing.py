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
    Result.TEMPORARILY_REJECTED: (REFUSED, "not now"),
    Result.DENIED: (REFUSED, "not with these numbers, or not by this station ([[links]] accept)"),
    Result.UNSUPPORTED: (REFUSED, "this payload does not know the command"),
    Result.FAILED: (FAILED, "it came to no good end"),
    Result.CANCELLED: (CANCELLED, "ended by a cancel, a stop or another order"),
    Result.COMMAND_LONG_ONLY: (REFUSED, "this payload wants COMMAND_LONG"),
}
UNHEARD = "no answer: is it in reach, may this station order there ([[links]] accept), has it the right key?"
SILENCE = "how it ended was not heard: look at the payload's state"
REPLACED = "another order took its place"
STARTED_ANEW = "the payload started anew"
AFTER_STOP = "a stop was ordered"
OVERTAKEN = "another order followed before it was answered"


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
