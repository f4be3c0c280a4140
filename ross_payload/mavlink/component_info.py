"""What the payload says about itself: versions, capabilities, names, and in files what every parameter means."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from ross_payload import __version__
from ross_payload.config import Config
from ross_payload.config.parameter_table import TABLE, Parameter, value_of
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.ftp import checksum

CAPABILITIES = (
    common.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | common.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | common.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
    | common.MAV_PROTOCOL_CAPABILITY_FTP
)
GENERAL, PARAMETERS = "general.json", "parameter.json"
TYPE_PARAMETER = 1  # COMP_METADATA_TYPE
DECIMALS = 2


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
    return ross.MAVLink_component_information_basic_message(
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
    return ross.MAVLink_protocol_version_message(200, 100, 200, nothing, nothing)


def files() -> dict[str, bytes]:
    """Return the content of every file, by name."""
    parameters = _json({"version": 1, "parameters": [_described(row) for row in TABLE.values()]})
    entry = {"type": TYPE_PARAMETER, "uri": f"mftp:///{PARAMETERS}", "fileCrc": checksum(parameters)}
    return {GENERAL: _json({"version": 1, "metadataTypes": [entry]}), PARAMETERS: parameters}


def metadata_message(content: Mapping[str, bytes], now: float) -> Any:
    """Return COMPONENT_METADATA at ``now`` [s]: where a client begins to read."""
    uri = f"mftp:///{GENERAL}".encode("ascii")
    return ross.MAVLink_component_metadata_message(round(now * 1e3) % 2**32, checksum(content[GENERAL]), uri)


def _described(parameter: Parameter) -> dict[str, Any]:
    described = {
        "name": parameter.name,
        "type": "Float",
        "shortDesc": parameter.about,
        "longDesc": f"Key {parameter.key} of the configuration.",
        "group": parameter.place[0],
        "units": parameter.unit,
        "default": value_of(Config(), parameter.name),
        "min": parameter.lower,
        "max": parameter.upper,
        "decimalPlaces": 0 if parameter.whole else DECIMALS,
    }
    return described | ({"increment": 1} if parameter.whole else {})


def _json(content: Any) -> bytes:
    return json.dumps(content, separators=(",", ":")).encode("ascii")
