"""The turntable as a MAVLink gimbal: ground stations see where the array points, and may point it."""

from ross_payload.mavlink.gimbal.gimbal_node import Gimbal

__all__ = ["Gimbal"]
