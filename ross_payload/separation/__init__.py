"""Separating sources at one heading: separators as plug-ins. Pure functions on arrays."""
