"""Pure functions on arrays: time-frequency analysis, source finding, alignment, separation and metrics."""
