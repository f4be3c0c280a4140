"""The turntable as a MAVLink gimbal: ground stations see where the array points, and may point it."""

from ross_payload.gimbal.service import Gimbal

__all__ = ["Gimbal"]
