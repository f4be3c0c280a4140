"""The picture of a payload in a terminal, as text lines, or as JSON lines."""
