"""Wire formats: bytes to values and back. No bus, no clock, no threads."""
