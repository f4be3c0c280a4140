"""Software in the loop: rooms, voices, the far ends of every wire, and a clock that moves only when asked."""
