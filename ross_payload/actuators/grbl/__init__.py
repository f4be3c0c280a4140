"""A stepper behind a controller with grbl 1.1."""
