"""Live listening: hops of audio and the mission's events in, voices out to sinks, beside the mission."""
