"""Who our MAVLink component is: the address that it answers to, and what it says about itself."""

from __future__ import annotations

import re
from typing import Any

from ross_payload import __version__
from ross_payload.links import Links
from ross_protocols.commands import ALL
from ross_protocols.dialect import common, standard

CAPABILITIES = (
    common.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | common.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | common.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    | common.MAV_PROTOCOL_CAPABILITY_FTP
)


class Endpoint:
    """Our component on the links: its ids at present, and its voice."""

    def __init__(self, links: Links, component_id: int) -> None:
        self._links = links
        self._component = links.component(component_id)
        self.component_id = component_id

    @property
    def system_id(self) -> int:
        """Our system id; 0: not known yet."""
        return self._links.system_id

    def meant(self, system_id: int, component_id: int) -> bool:
        """Tell whether a target is us, alone or among all."""
        return system_id in (ALL, self.system_id) and component_id in (ALL, self.component_id)

    def send(self, said: Any, link: str | None = None) -> None:
        """Send a value or one of pymavlink's messages; see `ross_payload.links.Links`."""
        self._component.send(said, link)


def version_number(version: str) -> int:
    """Return a version as MAVLink packs it: major, minor, patch and kind (0: under development, 255: released).

    >>> hex(version_number("1.2.3")), hex(version_number("1.2.3.dev4"))
    ('0x10203ff', '0x1020300')
    """
    numbers = [int(number) for number in re.findall(r"\d+", version)[:3]]
    major, minor, patch = [*numbers, 0, 0, 0][:3]
    released = re.fullmatch(r"[\d.]+", version) is not None
    return major << 24 | minor << 16 | patch << 8 | (255 if released else 0)


def version_message() -> Any:
    """Return AUTOPILOT_VERSION, which every component may send: capabilities and software version."""
    nothing = [0] * 8
    return common.MAVLink_autopilot_version_message(
        capabilities=CAPABILITIES,
        flight_sw_version=version_number(__version__),
        middleware_sw_version=0,
        os_sw_version=0,
        board_version=0,
        flight_custom_version=nothing,
        middleware_custom_version=nothing,
        os_custom_version=nothing,
        vendor_id=0,
        product_id=0,
        uid=0,
    )


def basic_message(now: float) -> Any:
    """Return COMPONENT_INFORMATION_BASIC at ``now`` [s]: what we are, in words."""
    return standard.MAVLink_component_information_basic_message(
        time_boot_ms=round(now * 1e3) % 2**32,
        capabilities=CAPABILITIES,
        time_manufacture_s=0,
        vendor_name=b"RoSS",
        model_name=b"two-microphone payload",
        software_version=__version__.encode("ascii", "replace")[:23],
        hardware_version=b"",
        serial_number=b"",
    )


def protocol_message() -> Any:
    """Return PROTOCOL_VERSION: MAVLink 2 is spoken, and 1 is understood."""
    nothing = [0] * 8
    return standard.MAVLink_protocol_version_message(200, 100, 200, nothing, nothing)
