"""The MAVLink component: what the payload tells a ground station."""
