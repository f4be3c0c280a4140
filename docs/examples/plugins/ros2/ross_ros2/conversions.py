"""What a payload tells, as the fields of ROS messages: plain dicts, so that nothing here needs ROS.

Angles of the payload's client are degrees, clockwise: from north (`earth`), else from the zero of the mount. Those of
ROS are radians, counter-clockwise (REP 103): from east in the frame of the map, from ahead in that of the mount.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ross_payload.ground.client.events import SourceEstimate

Fields = dict[str, Any]

MAP, MOUNT = "map", "ross_mount"  # frames: x to the east and y to the north; x ahead and y to the left
OK, WARN, ERROR, STALE = 0, 1, 2, 3  # levels of diagnostic_msgs/DiagnosticStatus


def yaw_of(azimuth_deg: float, *, earth: bool) -> float:
    """Yaw [rad] in `MAP` when ``earth``, else in `MOUNT`, of an azimuth of the payload [deg].

    >>> round(yaw_of(0.0, earth=True), 4), round(yaw_of(90.0, earth=True), 4), round(yaw_of(90.0, earth=False), 4)
    (1.5708, 0.0, -1.5708)
    """
    return math.remainder((math.pi / 2 if earth else 0.0) - math.radians(azimuth_deg), 2 * math.pi)


def azimuth_of(x: float, y: float, *, earth: bool) -> float:
    """Azimuth of the payload [deg], 0 to 360, of a point in `MAP` when ``earth``, else in `MOUNT`.

    >>> azimuth_of(1.0, 0.0, earth=True), azimuth_of(0.0, 1.0, earth=False)
    (90.0, 270.0)

    Raises
    ------
    ValueError
        When the point is the array itself, or no number.
    """
    if not (math.isfinite(x) and math.isfinite(y)) or math.hypot(x, y) == 0:
        raise ValueError(f"expected a point beside the array, got x = {x:g}, y = {y:g}")
    return math.degrees((math.pi / 2 if earth else 0.0) - math.atan2(y, x)) % 360


def frame_of(*, earth: bool) -> str:
    """Return the frame in which the payload thinks."""
    return MAP if earth else MOUNT


def pose(yaw: float) -> Fields:
    """geometry_msgs/Pose of the array, its x axis in the direction of a yaw [rad]."""
    turned = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": turned}


def bearings(sources: Iterable[SourceEstimate], *, earth: bool) -> Fields:
    """geometry_msgs/PoseArray: a pose per source, in the order of their indices, x axis towards it."""
    ordered = sorted((each for each in sources if each.earth == earth), key=lambda each: each.source)
    poses = [pose(yaw_of(each.azimuth_deg, earth=earth)) for each in ordered]
    return {"header": {"frame_id": frame_of(earth=earth)}, "poses": poses}


def heading(pointing: Mapping[str, Any]) -> Fields | None:
    """geometry_msgs/PoseStamped of the axis from microphone 1 to 2; None while nobody tells it."""
    if pointing["heading"] is None:
        return None
    earth = bool(pointing["earth"])
    return {"header": {"frame_id": frame_of(earth=earth)}, "pose": pose(yaw_of(pointing["heading"], earth=earth))}


def diagnostics(view: Mapping[str, Any], sources: Iterable[SourceEstimate], *, silent: bool) -> Fields:
    """diagnostic_msgs/DiagnosticArray: the mission's state, and every source with its sigma and confidence."""
    standing, pointing, mission = view["standing"], view["pointing"], view["mission"]
    fault = bool(pointing.get("fault"))
    level = STALE if silent else ERROR if fault else WARN if standing["flaws"] else OK
    values = {"k": mission["k"], "score": mission["score"], "outcome": standing["outcome"], "fault": fault}
    for each in sources:
        values[f"source {each.source}"] = (
            f"azimuth {each.azimuth_deg:.1f} deg, sigma {each.sigma_deg:.1f} deg, confidence {each.confidence:.2f}"
        )
    status = {
        "level": bytes([level]),  # the type octet
        "name": f"ross {standing['who']}",
        "message": "no message of the payload" if silent else str(standing["state"] or ""),
        "hardware_id": str(standing["actuator"] or ""),
        "values": [{"key": key, "value": "" if value is None else str(value)} for key, value in values.items()],
    }
    return {"header": {"frame_id": ""}, "status": [status]}


def audio(samples: np.ndarray[Any, Any]) -> Fields:
    """audio_common_msgs/AudioData: 16-bit little-endian samples of one channel, (n,), of floats within -1 to 1."""
    whole = np.clip(np.round(32768 * np.asarray(samples)), -32768, 32767).astype("<i2")
    return {"data": list(whole.tobytes())}


def audio_info(rate: int) -> Fields:
    """audio_common_msgs/AudioInfo of what `audio` makes."""
    sample = {"channels": 1, "sample_rate": rate, "sample_format": "S16LE"}
    return sample | {"bitrate": 16 * rate, "coding_format": "wave"}
