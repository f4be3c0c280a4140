"""Measured tables: sweeps over rooms, layouts and talkers."""
