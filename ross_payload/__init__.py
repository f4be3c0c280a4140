"""The RoSS payload: it listens, turns until interferers have the same delay, and separates the target voice."""

__version__ = "0.1.0"
