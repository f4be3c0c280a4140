"""What whoever operates this page, a browser or a program, may do to payloads; control is held by one of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ross_payload.ground.client.command_status import CommandStatus
from ross_payload.ground.client.command_types import Order, Stop
from ross_payload.ground.client.param_client import ParamClient
from ross_payload.ground.model.payload_state import PayloadState
from ross_payload.ground.web.page_state import PageState
from ross_protocols.mavlink.component_id import ComponentId


class NotReceived(ValueError):
    """No such payload was received."""


class NotOrdered(ValueError):
    """There is no such order, or not any longer."""


class NoControl(ValueError):
    """Another one has control."""


class NoCommands(ValueError):
    """A recorded flight accepts no commands."""


@dataclass(frozen=True, slots=True)
class Operator:
    """One who operates the page; ``id`` tells it from others, ``name`` tells others who it is."""

    state: PageState
    id: str
    name: str

    def known(self, who: ComponentId) -> PayloadState:
        """Return what is known of a payload.

        Raises
        ------
        NotReceived
            When that is nothing.
        """
        known = self.state.station.fleet.payloads.get(who)
        if known is None:
            raise NotReceived(f"id: expected a payload that was received, got {who}")
        return known

    def addressed(self, who: ComponentId) -> PayloadState:
        """Return what is known of a payload that is to do something.

        Raises
        ------
        NoCommands, NotReceived
            When it cannot.
        """
        if not self.state.live:
            raise NoCommands("a recorded flight accepts no commands")
        return self.known(who)

    def give(self, who: ComponentId, order: Order) -> CommandStatus:
        """Pass an order on; a stop is anybody's, and for whoever was not heard yet, too.

        Raises
        ------
        NoCommands, NotReceived, NoControl
            When it may not.
        """
        if not (isinstance(order, Stop) and self.state.live):
            self.addressed(who)
            self.hold()
        number = self.state.client.orders.order(who, order)
        self.state.tick()
        return self.status(who, number)

    def status(self, who: ComponentId, number: int) -> CommandStatus:
        """Return what has become of an order to a payload, whoever gave it.

        Raises
        ------
        NotOrdered
            When there is none of that number, or not any longer.
        """
        found = next((each for each in self.state.client.doing(who) if each.number == number), None)
        if found is None:
            raise NotOrdered(f"number: expected that of an order to {who}, got {str(number)[:20]}")
        return found

    def cancel(self, who: ComponentId, number: int) -> CommandStatus:
        """Ask a payload to end one order.

        Raises
        ------
        NoCommands, NotReceived, NotOrdered, NoControl
            When it may not.
        """
        self.addressed(who)
        self.status(who, number)
        self.hold()
        self.state.client.orders.cancel(number)
        self.state.tick()
        return self.status(who, number)

    def settings(self, who: ComponentId) -> ParamClient:
        """Return the parameters of a payload; the first one who asks makes the page ask for them.

        Raises
        ------
        NoCommands, NotReceived
            When there are none.
        """
        self.addressed(who)
        return self.state.client.settings(who)

    def check_control(self) -> None:
        """Look whether control is here, or free.

        Raises
        ------
        NoControl
            When another one has it.
        """
        control = self.state.control
        if control.holder not in (None, self.id):
            raise NoControl(f"{control.name} has control: take control first")

    def hold(self) -> None:
        """Take control when it is free.

        Raises
        ------
        NoControl
            When another one has it.
        """
        self.check_control()
        self.state.control.may_order(self.id, self.name)

    def take_control(self) -> None:
        """Take control, whoever has it."""
        self.state.control.acquire(self.id, self.name)
        self.state.tick()

    def give_up_control(self) -> None:
        """Let control be free, if it is here."""
        self.state.control.release(self.id)
        self.state.tick()

    def control(self) -> dict[str, Any]:
        """Return who has control."""
        control = self.state.control
        return {"holder": control.holder, "name": control.name, "yours": control.holder == self.id}
