"""The sound of payloads on the ground: it is ordered, received, and given to whoever listens."""
