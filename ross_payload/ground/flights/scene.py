"""What a payload knows as Foxglove's standard messages.

Foxglove counts as ROS does: x to the east, y to the north, angles counter-clockwise from x. Angles in here are
counter-clockwise from north, or from the zero of the mount, whose frame has its x there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from foxglove.messages import (
    Color,
    FrameTransform,
    LinePrimitive,
    LinePrimitiveLineType,
    LocationFix,
    Point3,
    Pose,
    PoseInFrame,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    TextPrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)

from ross_payload.ground.flights.plot_style import COLOURS, parts
from ross_payload.ground.model.payload_state import PayloadState
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.values import Source, Status
from ross_protocols.mavlink.vehicle import Position

EARTH = "earth"
LENGTH = 5.0  # of a wedge [m]: how far a source is nobody knows
SIGMAS = 3.0  # to each side of a wedge
NOWHERE = Vector3(x=0.0, y=0.0, z=0.0)


def mount(who: ComponentId) -> str:
    """Return the name of a mount's frame."""
    return f"{who}/mount"


def yaw(angle: float, earth: bool) -> float:
    """Return a direction as an angle about z: from the east, or from the zero of the mount [rad].

    >>> yaw(0.0, earth=True) == math.pi / 2, yaw(0.3, earth=False)
    (True, 0.3)
    """
    return angle + math.pi / 2 if earth else angle


def transforms(who: ComponentId, status: Status, at: Timestamp) -> Iterator[FrameTransform]:
    """Yield how the mount stands on the earth, when that is known, and the axis on the mount."""
    if status.heading is None:
        return
    base = status.mount_yaw if status.earth else 0.0
    if base is None:  # the mount is not known: the axis stands on the earth
        yield _transform(EARTH, f"{who}/axis", yaw(status.heading, earth=True), at)
        return
    if status.earth:
        yield _transform(EARTH, mount(who), yaw(base, earth=True), at)
    yield _transform(mount(who), f"{who}/axis", status.heading - base, at)


def heading(who: ComponentId, status: Status, at: Timestamp) -> PoseInFrame | None:
    """Return where the axis points; None: that is not known."""
    if status.heading is None:
        return None
    pose = Pose(position=NOWHERE, orientation=about_z(yaw(status.heading, status.earth)))
    return PoseInFrame(timestamp=at, frame_id=_frame(who, status.earth), pose=pose)


def sources(known: PayloadState, at: Timestamp) -> SceneUpdate:
    """Return all sources of the latest estimate: a wedge and a name each, a line where it may be instead."""
    earth = known.sources[0].earth if known.sources else known.earth
    entity = SceneEntity(
        timestamp=at,
        frame_id=_frame(known.who, earth),
        id="sources",
        triangles=[_wedge(source) for source in known.sources],
        lines=[_mirror(source, source.mirror) for source in known.sources if source.mirror is not None],
        texts=[_name(source) for source in known.sources],
    )
    return SceneUpdate(entities=[entity])


def location(system: int, position: Position, at: Timestamp) -> LocationFix:
    """Return where a vehicle is; its heading is clockwise from north, as this message wants it."""
    return LocationFix(
        timestamp=at,
        frame_id=f"vehicle-{system}",
        latitude=math.degrees(position.latitude),
        longitude=math.degrees(position.longitude),
        altitude=position.height,
        heading=None if position.yaw is None else -position.yaw % (2 * math.pi),
    )


def about_z(angle: float) -> Quaternion:
    """Return the rotation by an angle [rad], counter-clockwise seen from above."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(angle / 2), w=math.cos(angle / 2))


def _transform(parent: str, child: str, angle: float, at: Timestamp) -> FrameTransform:
    return FrameTransform(
        timestamp=at, parent_frame_id=parent, child_frame_id=child, translation=NOWHERE, rotation=about_z(angle)
    )


def _frame(who: ComponentId, earth: bool) -> str:
    return EARTH if earth else mount(who)


def _point(angle: float, length: float) -> Point3:
    return Point3(x=length * math.cos(angle), y=length * math.sin(angle), z=0.0)


def _colour(source: Source, alpha: float) -> Color:
    r, g, b = parts(COLOURS[source.source % len(COLOURS)])
    return Color(r=r, g=g, b=b, a=alpha)


def _wedge(source: Source) -> TriangleListPrimitive:
    middle, half = yaw(source.azimuth, source.earth), min(max(SIGMAS * source.sigma, 0.0), math.pi)
    steps = 2 + 2 * math.ceil(half / math.radians(5))
    edges = [_point(middle + half * (2 * step / steps - 1), LENGTH) for step in range(steps + 1)]
    points = [point for pair in pairwise(edges) for point in (_point(0.0, 0.0), *pair)]
    return TriangleListPrimitive(points=points, color=_colour(source, 0.3 + 0.5 * min(max(source.confidence, 0), 1)))


def _mirror(source: Source, azimuth: float) -> LinePrimitive:
    ends = [_point(0.0, 0.0), _point(yaw(azimuth, source.earth), LENGTH)]
    kind = LinePrimitiveLineType.LineStrip
    return LinePrimitive(type=kind, thickness=2.0, scale_invariant=True, points=ends, color=_colour(source, 0.6))


def _name(source: Source) -> TextPrimitive:
    angle, length = yaw(source.azimuth, source.earth), 1.08 * LENGTH
    place = Vector3(x=length * math.cos(angle), y=length * math.sin(angle), z=0.0)
    pose = Pose(position=place, orientation=about_z(0.0))
    text = f"{source.source} target" if source.target else str(source.source)
    return TextPrimitive(pose=pose, billboard=True, font_size=0.4, color=_colour(source, 1.0), text=text)
