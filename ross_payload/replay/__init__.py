"""Run a recorded mission again: identically, or with another configuration."""
