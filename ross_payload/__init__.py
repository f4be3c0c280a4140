"""The RoSS payload: it listens, turns until interferers pose as one, and separates the target voice."""

__version__ = "0.1.0"
