"""A whole mission in lock-step: scenario, plant, report."""
