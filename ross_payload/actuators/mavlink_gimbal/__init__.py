"""A gimbal on MAVLink, managed by an autopilot or by us."""
