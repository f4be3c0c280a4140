"""What crosses the serial line of a controller with grbl 1.1."""
