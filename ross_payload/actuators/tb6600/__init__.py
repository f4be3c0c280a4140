"""A stepper behind a TB6600 module: every edge is ours."""
