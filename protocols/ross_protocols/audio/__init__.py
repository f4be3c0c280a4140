"""Audio over byte streams."""
