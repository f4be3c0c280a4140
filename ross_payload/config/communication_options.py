"""The tables of how others reach the payload, and of its state: links, telemetry, DroneCAN, service, recording."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from ross_payload.config.table import Table

SystemId = Annotated[int, Field(ge=1, le=255)]


class Link(Table):
    """[[links]]: one MAVLink connection; each has its own parser, writer and budget."""

    url: str  # udpin:, udpout:, tcp: or tcpin:host:port, serial:device:baud or serial:device:auto
    role: Literal["ground", "autopilot"] = (
        "ground"  # autopilot: attitude and system id come from it; ROSS_* are sent in TUNNEL
    )
    key_file: str = ""  # 32 bytes or 64 hex digits, mode 0600: sign what is sent, accept only what is signed with it
    accept: tuple[SystemId, ...] = ()  # system ids that may send commands, others are only received; empty: all
    max_bytes_s: Annotated[int, Field(ge=0, le=1_000_000_000)] = (
        0  # send budget [bytes/s]; 0: half of a serial baud rate, else none
    )


class Telemetry(Table):
    """[telemetry]: identity and rates on MAVLink."""

    system_id: Annotated[int, Field(ge=0, le=255)] = (
        1  # of the vehicle; 0: from the heartbeat on the link of role autopilot
    )
    component_id: Annotated[int, Field(ge=2, le=255)] = 191  # 191: onboard computer; 1 is the autopilot
    status_hz: Annotated[float, Field(gt=0, le=50)] = 4.0  # ROSS_STATUS
    mirror_hz: Annotated[float, Field(ge=0, le=10)] = 1.0  # NAMED_VALUE_FLOAT and DEBUG_FLOAT_ARRAY; 0: never


class Gimbal(Table):
    """[gimbal]: the array as a MAVLink gimbal, which reports where it points and can be pointed by the pilot."""

    mode: Literal["off", "standalone", "device"] = (
        "off"  # standalone: its own gimbal manager; device: managed by the autopilot; off with mavlink_gimbal
    )
    component_id: Literal[0, 154, 171, 172, 173, 174, 175] = 0  # 0: 154, or the next free one


class Service(Table):
    """[service]: start and state of `ross run`."""

    state_dir: str = ""  # parameters set in flight, signing time; empty: $STATE_DIRECTORY, else ~/.local/state/ross
    autostart: Literal["nothing", "explore", "seek"] = "nothing"  # at the start; seek: find the target
    target: str = ""  # name of the enrolled voice; empty: no target
    log_level: Literal["debug", "info", "warning", "error"] = "info"  # what is logged: this and worse
    log_format: Literal["text", "json"] = "text"  # lines for people, or one JSON object per line


class Recording(Table):
    """[recording]: sessions on disk; personal data, so only on request."""

    folder: str = ""  # empty: recordings below the state folder
    always: bool = False  # record from start to end without a command
    target: bool = False  # also the separated voice of the target, target.flac
    sources: bool = False  # also the separated voice of every source, source-0.flac and so on
    max_gb: Annotated[float, Field(gt=0, le=10_000)] = 4.0  # of all sessions together; the oldest are deleted first
    max_days: Annotated[float, Field(gt=0, le=3650)] = 30.0  # older sessions are deleted
    min_free_gb: Annotated[float, Field(ge=0, le=10_000)] = (
        0.5  # free space below which recording stops, and streams to files
    )
    offer_ftp: bool = False  # let peers that may send commands read recordings over MAVLink FTP
    ftp_bytes_s: Annotated[float, Field(ge=100, le=1_000_000)] = (
        50_000.0  # limit, and at most half of the link's budget
    )


class Dronecan(Table):
    """[dronecan]: the payload as a node on a DroneCAN bus; no node can turn the array, any may set parameters."""

    port: Annotated[str, Field(pattern="^(can:.+)?$")] = ""  # can:INTERFACE:CHANNEL[:BITRATE]; empty: no node
    node_id: Annotated[int, Field(ge=0, le=125)] = (
        121  # must be unique; 0: requested from an allocator on the bus, usually the autopilot
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
