"""Our dialect and MAVLink's common one behind one parser.

The generated module ``ross_dialect`` knows our messages, and the standard ones that pymavlink lacks. Here it learns the
common ones, with their constants and enumerations, so that one parser reads both and one MAVLink object sends both;
pymavlink's own modules stay as they are. To let pymavlink's mavutil, a client, speak our dialect:
``mavutil.mavlink = ross_protocols.mavlink.dialect.ross``.
"""

from __future__ import annotations

from typing import Any

from pymavlink.dialects.v20 import common

from ross_protocols.mavlink import ross_dialect as ross

for _id, _message in common.mavlink_map.items():
    ross.mavlink_map.setdefault(_id, _message)
for _name, _enum in common.enums.items():
    ross.enums[_name] = _enum | ross.enums.get(_name, {})
for _name, _thing in vars(common).items():
    if _name.startswith(("MAV", "MAVLink_")) and not hasattr(ross, _name):
        setattr(ross, _name, _thing)
for _name, _thing in vars(common.MAVLink).items():
    if _name.endswith(("_encode", "_send")) and not hasattr(ross.MAVLink, _name):
        setattr(ross.MAVLink, _name, _thing)

MESSAGES: dict[int, Any] = ross.mavlink_map  # by message id, ours and the common ones

__all__ = ["MESSAGES", "common", "ross"]
