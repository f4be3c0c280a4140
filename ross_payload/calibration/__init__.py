"""What the array itself is like, heard by turning: spacing, heading offset, gain, polarity. Pure functions."""
