"""The simulated world in real time, in a process of its own."""
