"""A servo or gimbal on a DroneCAN bus."""
