"""A Reachy Mini as actuator and audio source of a RoSS payload."""
