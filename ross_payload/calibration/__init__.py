"""What the array itself is like, heard by turning: spacing, offset, gain, polarity, roll-off. All pure."""
