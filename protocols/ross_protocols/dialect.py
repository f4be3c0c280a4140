"""Our dialect and MAVLink's common one behind one parser.

The generated module ``ross_dialect`` knows our messages only. Here it learns the common ones, by class, so that one
parser reads both; pymavlink's own modules stay as they are.
"""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import common

from ross_protocols import ross_dialect as ross

for _id, _message in common.mavlink_map.items():
    ross.mavlink_map.setdefault(_id, _message)

MESSAGES: dict[int, Any] = ross.mavlink_map  # by message id, ours and the common ones

__all__ = ["MESSAGES", "common", "ross"]
