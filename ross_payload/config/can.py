"""The table of the payload as a node on a CAN bus."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from ross_payload.config.base import Table


class Dronecan(Table):
    """[dronecan]: the payload as a node on a DroneCAN bus; every node on the bus can command it."""

    port: Annotated[str, Field(pattern="^(can:.+)?$")] = ""  # can:INTERFACE:CHANNEL[:BITRATE]; empty: no node
    node_id: Annotated[int, Field(ge=0, le=125)] = (
        121  # nobody else may have it; 0: asked of an allocator on the bus, mostly the autopilot
    )
    allocator: bool = False  # assign ids to nodes that request one; only if no other node does
    may_set: bool = True  # other nodes may set parameters, not only read them
    may_restart: bool = False  # other nodes may restart the payload while no task runs
    status_hz: Annotated[float, Field(gt=0, le=20)] = 5.0  # ross.Status
    sources_hz: Annotated[float, Field(gt=0, le=5)] = 1.0  # ross.Sources, besides when they change

    @model_validator(mode="after")
    def _possible(self) -> Dronecan:
        if 100 <= self.node_id <= 105:
            raise ValueError(
                f"node_id: expected none of 100 to 105, which autopilots take for cameras, got {self.node_id}"
            )
        if self.allocator and not self.node_id:
            raise ValueError("node_id: expected an id of its own, as allocator = true assigns ids to others, got 0")
        return self
