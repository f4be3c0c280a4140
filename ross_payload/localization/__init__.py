"""Finding sources: how many there are and where, from ITDs under rotation. Pure functions on arrays."""
