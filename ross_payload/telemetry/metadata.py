"""What the component tells about itself in files: which there are, and what every parameter means."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from ross_payload.config import Config
from ross_payload.parameters import TABLE, Parameter, value_of
from ross_protocols.dialect import standard
from ross_protocols.ftp import checksum

GENERAL, PARAMETERS = "general.json", "parameter.json"
TYPE_PARAMETER = 1  # COMP_METADATA_TYPE
DECIMALS = 2


def files() -> dict[str, bytes]:
    """Return the content of every file, by name."""
    parameters = _json({"version": 1, "parameters": [_described(row) for row in TABLE.values()]})
    entry = {"type": TYPE_PARAMETER, "uri": f"mftp:///{PARAMETERS}", "fileCrc": checksum(parameters)}
    return {GENERAL: _json({"version": 1, "metadataTypes": [entry]}), PARAMETERS: parameters}


def metadata_message(content: Mapping[str, bytes], now: float) -> Any:
    """Return COMPONENT_METADATA at ``now`` [s]: where a client begins to read."""
    uri = f"mftp:///{GENERAL}".encode("ascii")
    return standard.MAVLink_component_metadata_message(round(now * 1e3) % 2**32, checksum(content[GENERAL]), uri)


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
