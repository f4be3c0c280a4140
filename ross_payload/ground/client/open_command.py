"""What the client of the command protocol remembers: orders that are not over, and payloads."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from ross_payload.ground.client.command_status import DONE, HAS_STOPPED, NOT_ANSWERED, CommandStatus
from ross_payload.ground.client.command_types import Order, Rearm, Stop
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.model.status_text import RecentTexts
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import ross

LATE_ACK_S = 1.0  # [s] after the end of an order, in which an answer to the next of its kind may be one to it


@dataclass(slots=True)
class OpenCommand:
    """An order that is not over."""

    number: int
    who: ComponentId
    order: Order
    due: float  # when it is said again [s]
    repeated: bool  # its like ended a moment ago: what the payload remembers may be that
    trusted: float  # [s]: a final answer before may be a late one to its like
    after_done: bool  # its like was done: a refusal is none of that
    lasts: float = -math.inf  # until when it is said without an answer after its tries, too [s]
    refusable: float = -math.inf  # [s]: a refusal before may be that of a later one of its kind, doubled
    sent: int = 0  # frames
    answered: float | None = None  # the latest time [s]
    doubted: int = 0  # frames that were sent when the first answer came that may be one to an older order of its kind
    cancelling: int = 0  # COMMAND_CANCEL, so often
    over: bool = False  # given up, until something is heard after all
    unheard: bool = False  # it was given up without an answer: said again later, it might be a new order
    heard: bool = False  # the payload has it: what it says about it can be about nothing else
    undone: set[int] = field(default_factory=set)  # by these later orders, or said again it would end or undo them

    @property
    def sure(self) -> bool:
        """Whether an answer that it goes on is one to it: it was asked for after the first that may be to another."""
        return 0 < self.doubted < self.sent


@dataclass(slots=True)
class Peer:
    """What is remembered of a payload."""

    boots: int | None = None
    stopped: float | None = None  # when its telemetry last said so [s]; None: the latest says otherwise
    texts: RecentTexts = field(default_factory=RecentTexts)
    ended: dict[int, tuple[float, str]] = field(default_factory=dict)  # when [s] and how, by MAV_CMD
    sent: dict[int, float] = field(default_factory=dict)  # when [s], by MAV_CMD

    def on_state(self, payload: PayloadState) -> None:
        """Learn of it, whenever it is heard."""
        self.boots = payload.boots
        self.stopped = payload.state_at if payload.state == ross.ROSS_STATE_STOPPED else None

    def why_unanswered(self, doing: CommandStatus) -> str:
        """Return what is known of an order to it that was not answered; what it told before the order is not."""
        stopped = self.stopped is not None and self.stopped >= doing.since
        return HAS_STOPPED if stopped and isinstance(doing.order, Stop) else NOT_ANSWERED

    def trusted(self, order: Order) -> tuple[float, bool]:
        """Return from when on [s] a final answer is one to an order, and whether its like before was done.

        A stop is only in doubt after it was re-armed; infinity: the answer to the one before that has not come yet.
        """
        ended, how = self.ended.get(order.number, (-math.inf, ""))
        before, arming = (self.sent.get(number, -math.inf) for number in (order.number, Rearm.number))
        if isinstance(order, Stop) and arming >= before > ended:
            return math.inf, False
        armed = arming >= ended > -math.inf
        return ended + LATE_ACK_S if armed or not isinstance(order, Stop) else -math.inf, how == DONE
