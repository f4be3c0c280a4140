"""Where to turn, so that interferers arrive with one delay. Pure functions on geometry."""
